// SPDX-License-Identifier: Apache-2.0
// Requests to a server of one rank with all its modules, without sockets: each is answered exactly once, whatever it says.
// An input is lines, each a request.
#include <spdlog/spdlog.h>

#include <cstdint>
#include <cstdlib>
#include <string_view>
#include <thread>

#include "gxy/comm/error.h"
#include "multiserver/test_server.h"

namespace {

using namespace gxy;

struct World {
  World() : server(setup()) {}
  static test::ServerSetup setup() {
    test::ServerSetup setup;
    setup.ranks = 1;
    setup.modules = GALAXY_MODULES;
    setup.node.memory = setup.node.tenantMemory = 64 << 20;
    return setup;
  }
  test::TestServer server;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static World world;
  protocol::Limits limits;
  limits.pixels = 4096;
  const auto outbox = std::make_shared<Outbox>(
      Outbox::Limits{}, [] {}, LedgerEntry());
  const auto session = std::make_shared<Session>(world.server.node(), outbox,
                                                 Session::Identity{1, "fuzzer", "user", false}, limits);
  uint32_t sent = 0;
  session->submit(++sent, "load data");
  session->submit(++sent, "load viewer");
  session->submit(++sent, "load example");
  std::string_view text(reinterpret_cast<const char*>(data), size);
  while (!text.empty() && sent < 40) {
    const size_t end = std::min(text.find('\n'), text.size());
    session->submit(++sent, std::string(text.substr(0, end)));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  // What waits on purpose is cancelled after a while.
  for (int i = 0; session->unanswered() > 0; i++) {
    if (i == 20)
      for (uint32_t id = 1; id <= sent; id++) session->cancel(id);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  uint32_t answered = 0;
  session->end();
  while (const auto frame = outbox->next()) answered += frame->channel == protocol::FrameChannel::Reply;
  if (answered != sent) std::abort();
  return 0;
}

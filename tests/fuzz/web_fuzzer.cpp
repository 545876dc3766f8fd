// SPDX-License-Identifier: Apache-2.0
// A browser, or who pretends to be one, at the socket of a whole server: whatever bytes come, what is answered is HTTP or
// frames of a WebSocket, nobody stays, and others are served as before. An input that begins with `!` is bytes as they come.
// Any other is sent in a WebSocket after its opening: lines, of which `#` begins a message on channel 0, `<` the bytes of a frame
// as they come, `-` a fragment of a message; any other is a request.
#include <cstdint>
#include <cstdlib>
#include <iostream>
#include <string_view>
#include <thread>

#include "multiserver/server/datasets.h"
#include "tests/multiserver/test_server.h"
#include "tests/multiserver/web_client.h"

namespace {

using namespace gxy;
using protocol::MessageChannel;
using test::WebSocketClient;

[[noreturn]] void failWeb(const std::string& what) {
  std::cerr << what << '\n';
  std::abort();
}

// The bytes of a line of an input.
std::string framesOf(std::string_view line, uint32_t id) {
  const auto message = [](MessageChannel channel, uint32_t number, std::string_view text) {
    return WebSocketClient::frame(WebSocketClient::kBinary,
                                  WebSocketClient::bytesOf(protocol::textMessage(channel, number, text)));
  };
  if (line.starts_with('#')) return message(MessageChannel::Control, 0, line.substr(1));
  if (line.starts_with('<')) return std::string(line.substr(1));
  if (line.starts_with('-')) return WebSocketClient::frame(WebSocketClient::kBinary, line.substr(1), false);
  return message(MessageChannel::Request, id, line);
}

std::string bytesToSend(std::string_view input) {
  if (input.starts_with('!')) return std::string(input.substr(1));
  std::string bytes = test::webRequest("/ws", test::upgradeFields());
  std::string frames = framesOf("#hello {\"client\": \"fuzzer\", \"tenant\": \"fuzzer\"}", 0);
  for (uint32_t id = 1; !input.empty() && id < 60; id++) {
    const std::string_view line = input.substr(0, input.find('\n'));
    input.remove_prefix(std::min(line.size() + 1, input.size()));
    frames += framesOf(line, id);
  }
  return bytes + frames;
}

class WebWorld {
 public:
  void take(std::string_view input) {
    const std::string bytes = bytesToSend(input);
    {
      test::WebClient client(server_.port());
      const size_t head = input.starts_with('!') ? 0 : bytes.find("\r\n\r\n") + 4;
      std::string_view rest = bytes;
      if (head > 0) {
        const auto answer = client.ask(std::string(rest.substr(0, head)), true);
        if (answer.status != 101) failWeb("no WebSocket: " + answer.head);
        rest.remove_prefix(head);
      }
      const size_t piece = 1 + rest.size() / (1 + input.size() % 7);
      for (; !rest.empty(); rest.remove_prefix(std::min(piece, rest.size())))
        if (!client.raw().send(test::bytesIn(rest.substr(0, piece)), 1000)) break;
      client.raw().endOfInput();
      if (!client.closedByServer()) failWeb("the server keeps a connection whose client has ended");
    }
    cleanUpWeb();
    if (++inputs_ % 16 == 0 && test::WebClient(server_.port()).ask(test::webRequest("/")).status != 200)
      failWeb("the page is not served any more");
  }

 private:
  static test::ServerSetup setup() {
    test::ServerSetup setup;
    setup.ranks = 1;
    setup.modules = GALAXY_MODULES;
    setup.serverRank.memory = setup.serverRank.tenantMemory = 64 << 20;
    return setup;
  }
  void cleanUpWeb() {
    const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(10);
    while (server_.server().clients() > 0) {
      if (std::chrono::steady_clock::now() > until) failWeb("a client that has gone stays");
      std::this_thread::sleep_for(std::chrono::microseconds(100));
    }
    for (const NamedDataset& d : server_.serverRank().datasets->list("fuzzer"))
      if (d.owner == "fuzzer") server_.serverRank().datasets->drop("fuzzer", d.name);
  }

  test::TestServer server_{setup()};
  uint64_t inputs_ = 0;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static WebWorld world;
  world.take({reinterpret_cast<const char*>(data), size});
  return 0;
}

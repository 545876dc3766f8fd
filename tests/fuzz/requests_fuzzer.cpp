// SPDX-License-Identifier: Apache-2.0
// One client of a whole server with all its modules, without sockets: whatever it says, in whatever pieces it comes, each
// request is answered exactly once, what the server says can be read, nothing is left behind, and the pictures of another
// client stay the same to the bit. An input is lines: `#CI...` is a frame on channel C with id I, any other a request.
// After a first `!` it is bytes as they come, instead, preamble and all.
#include <cstdint>
#include <cstdlib>
#include <iostream>
#include <map>
#include <set>
#include <string_view>
#include <thread>

#include "core/comm/error.h"
#include "multiserver/protocol/tile_codec.h"
#include "multiserver/server/datasets.h"
#include "multiserver/server/dialogue.h"
#include "tests/multiserver/test_server.h"

namespace {

using namespace gxy;
using protocol::MessageChannel;
using protocol::WireMessage;

[[noreturn]] void fail(const std::string& what) {
  std::cerr << what << '\n';
  std::abort();
}

void append(Bytes& stream, std::span<const std::byte> bytes) {
  stream.insert(stream.end(), bytes.begin(), bytes.end());
}
void append(Bytes& stream, const WireMessage& frame) {
  append(stream, protocol::headerOf(frame));
  append(stream, frame.payload);
}
void request(Bytes& stream, uint32_t id, std::string_view text) {
  append(stream, protocol::textMessage(MessageChannel::Request, id, text));
}

Bytes greeting() {
  Bytes stream;
  append(stream, protocol::preamble());
  append(stream,
         protocol::textMessage(MessageChannel::Control, 0, protocol::helloText({"", "fuzzer", "fuzzer"})));
  uint32_t id = 0;
  for (const char* module : {"load data", "load viewer", "load analysis", "load example"})
    request(stream, ++id, module);
  return stream;
}

// The bytes that a client sends.
Bytes streamOf(std::string_view input) {
  if (input.starts_with('!')) {
    Bytes stream;
    append(stream, std::as_bytes(std::span(input.substr(1))));
    return stream;
  }
  Bytes stream = greeting();
  for (uint32_t id = 10; !input.empty() && id < 60; id++) {
    const std::string_view line = input.substr(0, input.find('\n'));
    input.remove_prefix(std::min(line.size() + 1, input.size()));
    if (line.size() >= 3 && line[0] == '#')
      append(stream, protocol::textMessage(MessageChannel(uint16_t(line[1] - '0')), uint32_t(line[2] - '0'),
                                           line.substr(3)));
    else
      request(stream, id, line);
  }
  return stream;
}

/// One client, and what the server has said to it.
class Conversation {
 public:
  Conversation(ServerRank& serverRank, const std::string& tenant)
      : tenant_(tenant),
        outbox_(std::make_shared<Outbox>(
            Outbox::Limits{}, [] {}, LedgerEntry())),
        dialogue_(outbox_, limits(),
                  [this, &serverRank](const auto&, const auto& outbox, protocol::Welcome& welcome) {
                    welcome.limits = limits();
                    return std::make_shared<Session>(serverRank, outbox,
                                                     Session::Identity{1, tenant_, tenant_, false}, limits());
                  }) {}
  ~Conversation() { end(); }

  /// In pieces of so many bytes; false if the server has had enough.
  bool say(std::span<const std::byte> stream, size_t piece) {
    try {
      while (!stream.empty() && !dialogue_.over()) {
        std::span<const std::byte> some = stream.first(std::min(piece, stream.size()));
        stream = stream.subspan(some.size());
        while (!some.empty() && !dialogue_.over()) {
          dialogue_.take(some);
          if (dialogue_.paused()) hear(std::chrono::milliseconds(1));
        }
      }
    } catch (const Error&) {
      return false;
    }
    return !dialogue_.over();
  }
  /// Takes what the server says, for as long or until all is answered.
  void hear(std::chrono::milliseconds time) {
    const auto until = std::chrono::steady_clock::now() + time;
    for (;;) {
      const bool answered = !dialogue_.session() || dialogue_.session()->unanswered() == 0;
      while (auto frame = outbox_->next()) heard(*std::move(frame));
      if (answered || std::chrono::steady_clock::now() > until) return;
      std::this_thread::sleep_for(std::chrono::microseconds(200));
    }
  }
  /// Whatever is still asked is cancelled, and answered.
  void end() {
    if (!dialogue_.session()) return;
    dialogue_.session()->end();
    hear(std::chrono::milliseconds(0));
    if (dialogue_.session()->unanswered() > 0) fail("a request is never answered");
  }

  size_t replies() const { return replies_; }
  const std::vector<uint8_t>& picture() const { return picture_; }
  bool pictureIsWhole() const { return ends_ > 0; }

 private:
  static protocol::Limits limits() {
    protocol::Limits limits;
    limits.pixels = 4096;
    return limits;
  }
  void heard(WireMessage frame) {
    Bytes bytes;
    append(bytes, frame);
    std::span<const std::byte> rest(bytes);
    const auto read = reader_.take(rest);
    if (!read || !rest.empty()) fail("the server sent what no client can read");
    if (read->channel == MessageChannel::Reply) {
      if (!read->text().starts_with("ok") && !read->text().starts_with("error: "))
        fail("a reply of another form");
      replies_++;
    }
    if (read->channel != MessageChannel::Pixels) return;
    const protocol::PixelHeader header = protocol::pixelHeader(read->payload);
    if (header.kind == protocol::PixelKind::EndOfFrame) ends_++;
    if (header.kind == protocol::PixelKind::Tile && header.scale == 1)
      picture_ = protocol::decodeTile(header, protocol::pixelData(read->payload)).bytes;
  }

  const std::string tenant_;
  const std::shared_ptr<Outbox> outbox_;
  Dialogue dialogue_;
  protocol::MessageReader reader_{protocol::MessageReader::fromServer()};
  size_t replies_ = 0, ends_ = 0;
  std::vector<uint8_t> picture_;
};

class World {
 public:
  World() : server_(setup()) { expected_ = bystandersPicture(); }

  void take(std::string_view input) {
    const Bytes stream = streamOf(input);
    const size_t requests = requestsIn(stream);
    {
      Conversation client(server_.serverRank(), "fuzzer");
      const bool welcome = client.say(stream, 1 + stream.size() / (1 + input.size() % 7));
      client.hear(std::chrono::milliseconds(20));
      client.end();
      if (client.replies() > requests || (welcome && client.replies() != requests))
        fail(std::to_string(requests) + " requests have " + std::to_string(client.replies()) + " replies");
    }
    cleanUp();
    if (++inputs_ % 16 == 0 && bystandersPicture() != expected_) fail("another client's picture is another");
  }

 private:
  static test::ServerSetup setup() {
    test::ServerSetup setup;
    setup.ranks = 1;
    setup.modules = GALAXY_MODULES;
    setup.serverRank.memory = setup.serverRank.tenantMemory = 64 << 20;
    return setup;
  }

  // Up to the first that is no frame, or stands in for one that is never said.
  static size_t requestsIn(std::span<const std::byte> stream) {
    size_t requests = 0;
    if (stream.size() < protocol::kPreambleBytes) return 0;
    stream = stream.subspan(protocol::kPreambleBytes);
    protocol::MessageReader reader(protocol::MessageReader::fromClient(protocol::Limits{}.requestBytes));
    try {
      while (!stream.empty())
        if (const auto frame = reader.take(stream)) requests += frame->channel == MessageChannel::Request;
    } catch (const Error&) {
    }
    return requests;
  }

  std::vector<uint8_t> bystandersPicture() {
    Conversation client(server_.serverRank(), "bystander");
    Bytes stream = greeting();
    uint32_t id = 10;
    if (expected_.empty()) request(stream, ++id, test::importBall("ball"));
    if (!client.say(stream, 100)) fail("the bystander is not let in");
    client.hear(std::chrono::minutes(1));
    stream.clear();
    request(stream, ++id, "window 1 {\"size\": [40, 30]}");
    request(stream, ++id, "set 1 " + test::stateOf("ball"));
    request(stream, ++id, "render 1 {\"levels\": [1]}");
    client.say(stream, stream.size());
    while (!client.pictureIsWhole()) client.hear(std::chrono::milliseconds(1));
    return client.picture();
  }

  // Each input finds the same server.
  void cleanUp() {
    for (const NamedDataset& d : server_.serverRank().datasets->list("fuzzer"))
      if (d.owner == "fuzzer") server_.serverRank().datasets->drop("fuzzer", d.name);
    for (const auto& file : std::filesystem::directory_iterator(server_.folder().path()))
      if (file.path().stem() != "ball") std::filesystem::remove(file.path());
    const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(4);
    while (server_.serverRank().renderer.kept().frames > 0 ||
           server_.serverRank().ledger.total("fuzzer") > 0) {
      if (std::chrono::steady_clock::now() > until) fail("a client that has gone leaves something behind");
      std::this_thread::sleep_for(std::chrono::microseconds(200));
    }
  }

  test::TestServer server_;
  std::vector<uint8_t> expected_;
  uint64_t inputs_ = 0;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static World world;
  world.take({reinterpret_cast<const char*>(data), size});
  return 0;
}

// SPDX-License-Identifier: Apache-2.0
// What somebody may send to a port for data: no rank goes down, and nobody else is disturbed.
#include <gtest/gtest.h>

#include "core/comm/random.h"
#include "tests/insitu/data_messages.h"
#include "tests/insitu/mini_simulation.h"
#include "tests/multiserver/raw_client.h"
#include "tests/multiserver/viewer_client.h"
#include "tests/support/seeds.h"

namespace gxy::test {
namespace {

using insitu::Control;
using nlohmann::json;
using protocol::MessageChannel;
using protocol::WireMessage;

WireMessage piece(uint64_t count, uint32_t item, uint64_t offset, size_t bytes, uint64_t points = 512) {
  const auto header = written(insitu::PieceHeader{count, offset, points, item, 0});
  Bytes payload(header.begin(), header.end());
  payload.resize(payload.size() + bytes);
  return message(MessageChannel::Piece, std::move(payload));
}

/// A server, and a stream of one rank.
struct Port {
  Port() {
    client = server->client();
    client->expect("load data");
    client->expect("load insitu");
    join();
  }
  void join() { joined = client->expect(R"(insitu.join {"name": "raw", "rank": 0, "ranks": 1})"); }
  uint16_t port(size_t rank = 0) const { return joined.at("ranks").at(rank).at("port"); }
  insitu::Hello hello() const { return {joined.at("stream"), ticketOf(joined.at("ticket")), 0}; }

  /// A connection that has said hello.
  std::unique_ptr<RawClient> connect(size_t rank = 0) const {
    auto raw = std::make_unique<RawClient>(port(rank));
    raw->send(protocol::preamble(protocol::Purpose::Data));
    raw->send(message(MessageChannel::DataHello, written(hello())));
    return raw;
  }
  /// Reads until the server closes; the reason that it gave.
  std::string reason(RawClient& raw) const {
    std::vector<std::byte> all(1 << 16), bytes;
    for (size_t n; (n = raw.receive(all, 10000)) > 0;)
      bytes.insert(bytes.end(), all.begin(), all.begin() + long(n));
    protocol::MessageReader reader(protocol::MessageReader::ofDataToSimulation());
    std::span<const std::byte> rest(bytes);
    rest = rest.subspan(std::min(rest.size(), protocol::kPreambleBytes));
    while (!rest.empty())
      if (const auto m = reader.take(rest); m && m->channel == MessageChannel::Bye)
        return std::string(m->text());
    return {};
  }
  void expectEnds(const WireMessage& bad, const std::string& why) {
    const auto raw = connect();
    raw->send(message(MessageChannel::Describe, written(described())));
    raw->send(bad);
    const std::string found = reason(*raw);
    EXPECT_NE(found.find(why), std::string::npos) << "found: " << found;
    until([&] { return client->expect("insitu.streams").at("streams").empty(); }, "the end of the stream");
    join();
  }

  std::unique_ptr<TestServer> server = serve();
  std::unique_ptr<Client> client;
  json joined;
};

TEST(DataPort, WhoeverHasNoTicketIsClosedWithoutAWord) {
  const Port p;
  const auto expectClosed = [&](const insitu::Hello& hello, const std::string& what) {
    RawClient raw(p.port());
    raw.send(protocol::preamble(protocol::Purpose::Data));
    raw.send(message(MessageChannel::DataHello, written(hello)));
    EXPECT_EQ(p.reason(raw), "") << what;
  };
  insitu::Hello hello = p.hello();
  hello.ticket[31] ^= 1;
  expectClosed(hello, "another ticket");
  hello = p.hello();
  hello.stream++;
  expectClosed(hello, "another stream");
  hello = p.hello();
  hello.rank = 1;
  expectClosed(hello, "no such rank");
  RawClient wrong(p.port());
  wrong.send(protocol::preamble());
  EXPECT_TRUE(wrong.closedByServer()) << "a client's preamble";
  RawClient garbage(p.port());
  garbage.send(protocol::preamble(protocol::Purpose::Data));
  garbage.send(message(MessageChannel::Describe, Bytes(1000)));
  EXPECT_TRUE(garbage.closedByServer()) << "no hello";
  EXPECT_EQ(p.client->expect("insitu.streams").at("streams").size(), 1u) << "the stream is not harmed";
}

TEST(DataPort, HelloAndDescriptionMayComeTogether) {
  const Port p;
  RawClient raw(p.port());
  Bytes all;
  const auto add = [&](const auto& bytes) { all.insert(all.end(), bytes.begin(), bytes.end()); };
  add(protocol::preamble(protocol::Purpose::Data));
  for (const WireMessage& m : {message(MessageChannel::DataHello, written(p.hello())),
                               message(MessageChannel::Describe, written(described()))}) {
    add(protocol::headerOf(m));
    add(m.payload);
  }
  raw.send(all);
  until([&] { return p.client->expect("insitu.streams").at("streams").at(0).contains("published"); },
        "a plan");
}

TEST(DataPort, OtherRanksThanTheFirstTakeSamplesOnly) {
  const Port p;
  const auto raw = p.connect(1);
  raw->send(message(MessageChannel::Describe, written(described())));
  EXPECT_NE(p.reason(*raw).find("on channel 17, on which none may come"), std::string::npos);
}

TEST(DataPort, ARankConnectsOnce) {
  const Port p;
  const auto first = p.connect();
  until([&] { return p.client->expect("insitu.streams").at("streams").at(0).at("connected") == 1; },
        "connected");
  EXPECT_EQ(p.reason(*p.connect()), "");
  EXPECT_EQ(p.client->expect("insitu.streams").at("streams").at(0).at("connected"), 1);
}

TEST(DataPort, TooManyBlocksEndTheStream) {
#ifdef __SANITIZE_THREAD__
  GTEST_SKIP() << "a million blocks take the thread sanitizer a minute; the other suites read them";
#endif
  Port p;
  insitu::Description many = described();
  many.parts[0].blocks.assign(insitu::kMostBlocks / 2 + 1, {{0, 0, 0}, {1, 1, 1}});
  many.meshes.push_back(many.meshes[0]);
  many.meshes[1].name = "other", many.meshes[1].fields[0].name = "u";
  many.parts.push_back(many.parts[0]);
  const auto raw = p.connect();
  ASSERT_TRUE(raw->send(message(MessageChannel::Describe, written(many)), 60000));
  EXPECT_NE(p.reason(*raw).find("more than 2^20 blocks together"), std::string::npos);
  until([&] { return p.client->expect("insitu.streams").at("streams").empty(); }, "the end of the stream");
}

TEST(DataPort, WrongMessagesEndTheStreamWithAReason) {
  Port p;
  p.expectEnds(message(MessageChannel::Describe, written(described())), "expected one of publishes after 1");
  p.expectEnds(message(MessageChannel::Describe, Bytes(3)), "description of a simulation's data");
  p.expectEnds(message(MessageChannel::DataControl, Bytes(3)), "control message");
  p.expectEnds(message(MessageChannel::Plan, Bytes(3)), "on channel 18, on which none may come");
  p.expectEnds(message(MessageChannel::Piece, Bytes(3)), "expected a header of 32");
  p.expectEnds(message(MessageChannel::Step, Bytes(3)), "step");
  p.expectEnds(message(MessageChannel::Piece, Bytes((1 << 20) + 1000)), "expected at most");
}

TEST(DataPort, SamplesThatWereNotAskedForEndTheStream) {
  Port p;
  const auto raw = p.connect();
  raw->send(message(MessageChannel::Describe, written(described())));
  until([&] { return p.client->expect("insitu.streams").at("streams").at(0).contains("published"); },
        "a plan");
  raw->send(piece(5, 0, 4, 4));               // An item begins at its begin.
  const std::string reason = p.reason(*raw);  // There is room for a step by now, or not yet.
  EXPECT_TRUE(reason.find("expected byte 0 of item 0") != std::string::npos ||
              reason.find("which was not asked for") != std::string::npos)
      << reason;
}

/// A message as it should be, but for a few bytes.
WireMessage changed(Random& random) {
  const uint64_t count = random.below(6);
  WireMessage all[] = {message(MessageChannel::Describe, written(described())),
                       message(MessageChannel::DataControl,
                               written(Control{Control::Kind(random.below(6)), count, random.below(6)})),
                       message(MessageChannel::Step, written(insitu::StepHeader{count, int64_t(count), 0})),
                       piece(count, uint32_t(random.below(2)), 4 * random.below(3), 4 * random.below(600)),
                       message(MessageChannel(16 + random.below(8)), Bytes(random.below(200)))};
  WireMessage m = std::move(all[random.below(std::size(all))]);
  for (uint64_t n = random.below(3); n > 0 && !m.payload.empty(); n--)
    m.payload[random.below(m.payload.size())] = std::byte(random.below(256));
  return m;
}

TEST(DataPort, RandomBytesHarmNobodyElse) {
  Port p;
  const Grid grid{{0, 0, 0}, {1, 1, 1}, {8, 8, 8}};
  MiniSimulation good(
      "good", grid, {{0, 0, {{0, 0, 0}, {8, 8, 8}}}}, 1, {{"t"}}, Layout::Together,
      json{{"to", "127.0.0.1:" + std::to_string(p.server->port())}, {"token-file", "-"}}.dump());
  p.client->expect("observe good.t");
  for (uint64_t seed = 1; seed <= uint64_t(sweep(60)); seed++) {
    Random random(seed);
    p.join();
    const auto raw = p.connect(random.below(2));
    if (random.oneIn(2)) raw->send(message(MessageChannel::Describe, written(described())));
    for (int i = 0; i < 5; i++) {
      raw->send(changed(random));
      good.publish();
    }
    if (random.oneIn(2)) raw->reset();
    p.client->request("insitu.close raw");
    until(
        [&] {
          const json streams = p.client->expect("insitu.streams").at("streams");
          for (const json& s : streams)
            if (s.at("name") == "raw") return false;
          return true;
        },
        "the end of the stream");
  }
  const int64_t before = good.published();
  until([&] { return good.publish(), good.published() > before + 2; }, "further steps of the other stream");
}

}  // namespace
}  // namespace gxy::test

// SPDX-License-Identifier: Apache-2.0
// Samples that are damaged on their way to a server are found before they are stored.
#include <ifaddrs.h>

#include "core/comm/crc32c.h"
#include "tests/insitu/data_messages.h"
#include "tests/insitu/published.h"
#include "tests/insitu/random_blocks.h"
#include "tests/multiserver/raw_client.h"

namespace gxy::test {
namespace {

using insitu::Checksum;
using insitu::Control;
using nlohmann::json;
using protocol::MessageChannel;
using protocol::WireMessage;

constexpr size_t kPoints = 8 * 8 * 8;

std::unique_ptr<TestServer> serveOne(const std::string& bind = "127.0.0.1") {
  ServerSetup setup;
  setup.ranks = 1;
  setup.modules = GALAXY_MODULES;
  setup.server.bind = bind;
  setup.serverRank.insituBind = bind;
  return std::make_unique<TestServer>(std::move(setup));
}

/// A rank of a simulation that says hello, describes a field (described()), and waits until it is asked for a step.
class Rank {
 public:
  Rank(Client& client, Checksum checksum) {
    const json joined = client.expect(R"(insitu.join {"name": "raw", "rank": 0, "ranks": 1})");
    const insitu::Hello hello{joined.at("stream"), ticketOf(joined.at("ticket")), 0, checksum};
    raw_ = std::make_unique<RawClient>(joined.at("ranks").at(0).at("port").get<uint16_t>());
    raw_->send(protocol::preamble(protocol::Purpose::Data));
    raw_->send(message(MessageChannel::DataHello, written(hello)));
    raw_->send(message(MessageChannel::Describe, written(described())));
  }

  /// Answers the server until it has appointed a publish, and returns its count.
  uint64_t appointed() {
    for (;;) {
      const WireMessage m = next();
      if (m.channel != MessageChannel::DataControl) continue;
      const Control control = insitu::readControl(m.payload);
      if (control.kind == Control::Kind::Appoint) return control.count;
      if (control.kind == Control::Kind::AskNewest) answer({Control::Kind::Newest, control.count, 0});
    }
  }

  /// Sends the step of a publish, with the checksum of `samples` and these samples but for the bit `flipped`, if there is one.
  void sendStep(uint64_t count, Bytes samples, uint32_t checksum, std::optional<size_t> flipped) {
    if (flipped) samples[*flipped / 8] ^= std::byte(1 << *flipped % 8);
    raw_->send(message(MessageChannel::Step, written(insitu::StepHeader{count, 7, 0.5})));
    const auto header = written(insitu::PieceHeader{count, 0, kPoints, 0, checksum});
    Bytes payload(header.begin(), header.end());
    payload.insert(payload.end(), samples.begin(), samples.end());
    raw_->send(message(MessageChannel::Piece, std::move(payload)));
  }

  /// What the server says of the step in the end: nothing if it is published, else why it has ended the stream.
  std::string outcome() {
    for (;;) {
      const WireMessage m = next();
      if (m.channel == MessageChannel::Bye) return std::string(m.text());
      if (m.channel == MessageChannel::DataControl &&
          insitu::readControl(m.payload).kind == Control::Kind::Published)
        return {};
    }
  }

 private:
  void answer(const Control& control) { raw_->send(message(MessageChannel::DataControl, written(control))); }

  WireMessage next() {
    for (;;) {
      while (unread_.empty()) {
        const size_t n = raw_->receive(buffer_, 20000);
        if (n == 0) throw std::runtime_error("the server has closed the connection");
        const size_t greeting = std::min(preamble_, n);
        preamble_ -= greeting;
        unread_ = std::span<const std::byte>(buffer_).first(n).subspan(greeting);
      }
      if (auto m = reader_.take(unread_)) return *std::move(m);
    }
  }

  std::unique_ptr<RawClient> raw_;
  size_t preamble_ = protocol::kPreambleBytes;  ///< bytes of it that are to come
  std::vector<std::byte> buffer_ = std::vector<std::byte>(1 << 16);
  std::span<const std::byte> unread_;
  protocol::MessageReader reader_{protocol::MessageReader::ofDataToSimulation()};
};

Bytes someSamples() {
  std::vector<float> values(kPoints);
  for (size_t i = 0; i < kPoints; i++) values[i] = 0.25f * float(i);
  const auto bytes = std::as_bytes(std::span(values));
  return {bytes.begin(), bytes.end()};
}

TEST(Checksums, AFlippedBitEndsTheStreamWithWhatWasDamagedAndNothingElse) {
  const auto server = serveOne();
  std::mutex mutex;
  std::vector<json> ends;
  auto options = server->options();
  options.onEvent = [&](const json& event) {
    const std::lock_guard lock(mutex);
    if (event.at("event") == "stream ended") ends.push_back(event);
  };
  Client client(options);
  client.expect("load data");
  client.expect("load insitu");
  client.expect("insitu.listen");
  const Bytes samples = someSamples();
  const size_t bits[] = {0, 4321, 8 * samples.size() - 1};
  for (size_t i = 0; i < std::size(bits); i++) {
    Rank rank(client, Checksum::Crc32c);
    const uint64_t count = rank.appointed();
    rank.sendStep(count, samples, crc32c(samples), bits[i]);
    const std::string reason = rank.outcome();
    EXPECT_NE(reason.find("samples were damaged on their way: publish " + std::to_string(count) +
                          ", item 0 (\"t\" of mesh \"grid\"), 2048 bytes from byte 0 have the CRC-32C "),
              std::string::npos)
        << reason;
    until(
        [&] {
          const std::lock_guard lock(mutex);
          return ends.size() == i + 1;
        },
        "the end of the stream");
    const std::lock_guard lock(mutex);
    EXPECT_NE(
        ends.back().at("reason").get<std::string>().find("rank 0 of the simulation: samples were damaged"),
        std::string::npos)
        << ends.back();
  }
  EXPECT_TRUE(client.expect("list").at("datasets").empty()) << "no damaged step is seen";
  Rank rank(client, Checksum::Crc32c);
  const uint64_t count = rank.appointed();
  rank.sendStep(count, samples, crc32c(samples), std::nullopt);
  EXPECT_EQ(rank.outcome(), "") << "the server goes on";
}

TEST(Checksums, ZeroIsAChecksumWhereThereAreSome) {
  const auto server = serveOne();
  const auto client = server->client();
  client->expect("load insitu");
  Rank rank(*client, Checksum::Crc32c);
  const uint64_t count = rank.appointed();
  rank.sendStep(count, someSamples(), 0, std::nullopt);
  EXPECT_NE(rank.outcome().find("expected 00000000"), std::string::npos);
}

TEST(Checksums, WithoutThemTheWordMeansNothing) {
  const auto server = serveOne();
  const auto client = server->client();
  client->expect("load insitu");
  Rank rank(*client, Checksum::None);
  const uint64_t count = rank.appointed();
  rank.sendStep(count, someSamples(), 12345, std::nullopt);
  EXPECT_EQ(rank.outcome(), "");
}

/// Publishes steps of some ranks, and returns how many connections to rank 0 have checksums.
size_t checked(TestServer& server, const std::string& options, int ranks) {
  const auto client = server.client();
  client->expect("load data");
  client->expect("load insitu");
  client->expect("observe");
  const Grid grid = gridOf({40, 33, 29});
  const std::vector<MiniField> fields{{"a", ScalarType::Float64, 3}, {"b", ScalarType::UInt8, 1}};
  size_t found = 0;
  {
    Random random(1);
    MiniSimulation simulation("heat", grid, insitu::randomBlocks(random, grid.points, ranks), ranks, fields,
                              Layout::Ghosts, options);
    EXPECT_EQ(simulation.results(), 0) << gxy_message(simulation.rank(0));
    run(simulation, [&] { return simulation.published() >= 2; });
    found = client->expect("insitu.streams").at("streams").at(0).at("checked");
  }
  until([&] { return client->expect("insitu.streams").at("streams").empty(); }, "the end of the stream");
  expectEqualsImport(server, *client, grid, GXY_OF_POINTS, fields);
  return found;
}

TEST(Checksums, WhatIsPublishedIsTheSameAndLoopbackHasThemIfAsked) {
  const auto with = [](const TestServer& server, const json& checksum) {
    json options = json::parse(to(server));
    options["checksum"] = checksum;
    return options.dump();
  };
  ServerSetup setup;
  setup.ranks = 3;
  setup.modules = GALAXY_MODULES;
  TestServer server(std::move(setup));
  EXPECT_EQ(checked(server, with(server, true), 4), 4u);
  EXPECT_EQ(checked(server, with(server, false), 4), 0u);
  EXPECT_EQ(checked(server, with(server, nullptr), 4), 0u);
}

/// An address of this machine that is not one of its loopback.
std::string ownAddress() {
  ifaddrs* list = nullptr;
  if (::getifaddrs(&list) != 0) return {};
  std::string address;
  for (const ifaddrs* i = list; i; i = i->ifa_next) {
    if (!i->ifa_addr || i->ifa_addr->sa_family != AF_INET) continue;
    char text[INET_ADDRSTRLEN] = {};
    const auto& in = reinterpret_cast<const sockaddr_in*>(i->ifa_addr)->sin_addr;
    if ((ntohl(in.s_addr) >> 24) != 127 && ::inet_ntop(AF_INET, &in, text, sizeof text)) address = text;
  }
  ::freeifaddrs(list);
  return address;
}

TEST(Checksums, OtherAddressesThanLoopbackHaveThemUnlessTheyAreRefused) {
  const std::string address = ownAddress();
  if (address.empty()) GTEST_SKIP() << "this machine has loopback only";
  const auto server = serveOne("0.0.0.0");
  json options{{"to", address + ":" + std::to_string(server->port())}, {"token-file", "-"}};
  EXPECT_EQ(checked(*server, options.dump(), 2), 2u);
  options["checksum"] = false;
  EXPECT_EQ(checked(*server, options.dump(), 2), 0u);
}

}  // namespace
}  // namespace gxy::test

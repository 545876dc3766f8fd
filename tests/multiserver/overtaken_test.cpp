// SPDX-License-Identifier: Apache-2.0
// A frame that refines is over as soon as the one that waited begins, whatever it was at.
#include <array>

#include "tests/multiserver/raw_client.h"
#include "tests/multiserver/viewer_client.h"
#include "tests/support/seeds.h"

namespace gxy::test {
namespace {

using nlohmann::json;

json statOf(Client& client, const std::string& tenant) {
  const json stat = client.expect("stat");
  for (const json& c : stat.at("clients"))
    if (c.at("tenant") == tenant) return c;
  return {};
}

// 0 before the tenant's session has begun.
int64_t counted(Client& client, const std::string& tenant, const char* what) {
  const json stat = statOf(client, tenant);
  return stat.is_object() ? stat.value(what, int64_t(0)) : 0;
}

// The client reads nothing until the first frame refines, so that the second begins when the first may be at anything:
// rendering a pass, or making tiles of one that is rendered.
TEST(Overtaken, AFrameThatRefinesSendsNothingMoreAndSaysThatItIsSuperseded) {
  const auto server = serve(1);
  const auto other = server->client("other");
  other->expect("load data");
  other->expect("import shared " + importBall("ball").substr(7));
  for (int round = 0; round < sweep(12); round++) {
    const std::string tenant = "slow" + std::to_string(round);
    RawClient slow(server->port(), 4096);
    slow.greet(tenant);
    uint32_t id = 1;
    const auto say = [&](const std::string& statement) { ASSERT_TRUE(slow.request(id++, statement)); };
    say("load viewer");
    for (const char* window : {"1", "2"}) {
      say(std::string("window ") + window + " {\"size\": [" +
          (*window == '1' ? "128, 128]}" : "1024, 512]}"));
      say(std::string("set ") + window + " " + stateOf("ball"));
    }
    say("render 2 {\"encoding\": \"raw\", \"levels\": [1]}");  // more than sockets take
    until([&] { return counted(*other, tenant, "queued bytes") > (1 << 20); }, "it is not read");
    say("render 1 {\"passes\": 300, \"levels\": [1], \"encoding\": \"zlib\"}");
    until([&] { return counted(*other, tenant, "tiles dropped") > 0; }, "it refines");
    say("render 1 {\"levels\": [1], \"wait\": true}");
    std::array<std::string, 3> ends;
    bool begun = false, mixed = false;
    EXPECT_TRUE(slow.readUntil([&](const protocol::WireMessage& frame) {
      if (frame.channel != protocol::MessageChannel::Pixels) return false;
      const auto header = protocol::pixelHeader(frame.payload);
      if (header.window != 1) return false;
      if (header.kind == protocol::PixelKind::Tile) {
        begun = begun || header.frame == 2;
        mixed = mixed || (begun && header.frame == 1);
      }
      if (!RawClient::isEnd(frame)) return false;
      const auto data = protocol::pixelData(frame.payload);
      const auto text = std::string_view(reinterpret_cast<const char*>(data.data()), data.size());
      ends.at(header.frame) = json::parse(text).at("status");
      return !ends[1].empty() && !ends[2].empty();
    }));
    EXPECT_EQ(ends[1], "superseded");
    EXPECT_EQ(ends[2], "complete");
    EXPECT_FALSE(mixed) << "tiles of the older frame come after those of the newer one";
  }
}

}  // namespace
}  // namespace gxy::test

// SPDX-License-Identifier: Apache-2.0
// Filters that send rays, in a server.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/multiserver/viewer_client.h"

namespace gxy::test {
namespace {

using nlohmann::json;

std::unique_ptr<TestServer> serve(int ranks) {
  ServerSetup setup;
  setup.ranks = ranks;
  setup.modules = GALAXY_MODULES;
  return std::make_unique<TestServer>(std::move(setup));
}

json sampled(Client& client, const std::string& properties) {
  return client
      .expect(
          R"(make {"filter":"IsosurfaceSampler","name":"points","type":"Particles","inputs":{"field":"ball"},)" +
          properties + "}")
      .at("results")
      .at(0);
}

TEST(ServerSampling, MakesPointsOnAnIsosurfaceOnAnyNumberOfRanks) {
  json expected;
  for (const int ranks : {3, 1}) {
    const auto server = serve(ranks);
    const auto client = server->client();
    client->expect("load data");
    client->expect("load analysis");
    client->expect(importBall("ball"));
    const json told = sampled(*client, R"("isovalue":0.5,"count":2000)");
    EXPECT_EQ(told.at("particles"), 2000);
    EXPECT_EQ(told.at("generation"), 1);
    EXPECT_NEAR(told.at("area"), std::numbers::pi,
                3 * double(told.at("area error")) + 0.02 * std::numbers::pi);
    if (expected.is_null()) expected = told;
    EXPECT_EQ(told, expected);
    const json info = client->expect("info points").at("datasets").at(0);
    EXPECT_EQ(info.at("primitives"), 2000);
    EXPECT_EQ(sampled(*client, R"("isovalue":0.6,"count":10)").at("generation"), 2);
    client->expect("drop points");
    client->expect("drop ball");
    // A thread that has ended the last ray may still let go of the scene.
    for (int rank = 0; rank < ranks; rank++)
      until([&] { return server->serverRank(rank).ledger.total("user") == 0; }, "nothing is kept");
  }
}

TEST(ServerSampling, PointsThatHaveNoRoomAreNotNamed) {
  ServerSetup setup;
  setup.ranks = 3;
  setup.modules = GALAXY_MODULES;
  setup.serverRank.tenantMemory = 1 << 20;
  TestServer server(std::move(setup));
  const auto client = server.client();
  client->expect("load data");
  client->expect("load analysis");
  client->expect(importBall("ball"));
  const auto reply = client->request(
      R"(make {"filter":"IsosurfaceSampler","name":"points","inputs":{"field":"ball"},"isovalue":0.5,"count":1000000})");
  EXPECT_FALSE(reply.ok);
  EXPECT_EQ(client->expect("list").at("datasets").size(), 1u);
  for (int rank = 0; rank < 3; rank++)
    until([&] { return server.serverRank(rank).ledger.total("user") < 1 << 20; }, "no sample is kept");
}

}  // namespace
}  // namespace gxy::test

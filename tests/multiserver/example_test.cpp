// SPDX-License-Identifier: Apache-2.0
// Module example: the paper's data range and its data-parallel filter, on several ranks.
#include <gtest/gtest.h>

#include <cmath>

#include "gxy/server/datasets.h"
#include "multiserver/test_server.h"

namespace gxy::test {
namespace {

using nlohmann::json;

TEST(Example, FindsTheRangeAndMakesADatasetWhereTheSourceIs) {
  ServerSetup setup;
  setup.ranks = 3;
  setup.modules = GALAXY_MODULES;
  TestServer server(std::move(setup));
  const auto client = server.client();
  client->expect("load data");
  EXPECT_EQ(client->expect("load example").at("hidden"), json{"range"});
  client->expect(importBall("ball"));
  const json range = client->expect("example.range ball").at("range");
  EXPECT_NEAR(range.at(0).get<double>(), std::sqrt(3.0) / 15, 1e-6);
  EXPECT_NEAR(range.at(1).get<double>(), std::sqrt(3.0), 1e-6);

  client->expect("threshold ball shell 0.5 1");
  const json info = client->expect("info shell").at("datasets").at(0);
  EXPECT_EQ(info.at("points"), (json{16, 16, 16}));
  EXPECT_EQ(info.at("partitions"), 3);
  EXPECT_EQ(client->expect("range shell").at("range"), (json{0, 1}));
  int shown = 0;
  for (int rank = 0; rank < 3; rank++) {
    const Pin pin = server.node(rank).objects.pin(server.node(0).datasets->get("user", "shell").key, 1);
    for (const auto& [partition, block] : pin.get<Dataset>()->volume->blocks) {
      EXPECT_EQ(pin.get<Dataset>()->partitioning->owner(partition), rank);
      shown++;
    }
  }
  EXPECT_EQ(shown, 3);

  EXPECT_FALSE(client->request("threshold nothing x 0 1").ok);
  EXPECT_FALSE(client->request("threshold ball x").ok);
  client->expect("drop shell");
  client->expect("drop ball");
  for (int rank = 0; rank < 3; rank++) EXPECT_EQ(server.node(rank).ledger.total("user"), 0);
}

}  // namespace
}  // namespace gxy::test

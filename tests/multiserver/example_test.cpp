// SPDX-License-Identifier: Apache-2.0
// Module example: the paper's data range and its data-parallel filter, on several ranks.
#include <gtest/gtest.h>

#include <cmath>
#include <future>

#include "multiserver/server/datasets.h"
#include "tests/multiserver/test_server.h"

namespace gxy::test {
namespace {

using nlohmann::json;

std::string threshold(const std::string& source, const std::string& name, double least, double largest) {
  return "make " + json{{"name", name},
                        {"filter", "Threshold"},
                        {"inputs", {{"source", source}}},
                        {"least", least},
                        {"largest", largest}}
                       .dump();
}

TEST(Example, FindsTheRangeAndMakesADatasetWhereTheSourceIs) {
  ServerSetup setup;
  setup.ranks = 3;
  setup.modules = GALAXY_MODULES;
  TestServer server(std::move(setup));
  const auto client = server.client();
  client->expect("load data");
  client->expect("load analysis");
  EXPECT_EQ(client->expect("load example").at("hidden"), json{"range"});
  client->expect(importBall("ball"));
  const json range = client->expect("example.range ball").at("range");
  EXPECT_NEAR(range.at(0).get<double>(), std::sqrt(3.0) / 15, 1e-6);
  EXPECT_NEAR(range.at(1).get<double>(), std::sqrt(3.0), 1e-6);

  client->expect(threshold("ball", "shell", 0.5, 1));
  const json info = client->expect("info shell").at("datasets").at(0);
  EXPECT_EQ(info.at("points"), (json{16, 16, 16}));
  EXPECT_EQ(info.at("partitions"), 3);
  EXPECT_EQ(client->expect("range shell").at("range"), (json{0, 1}));
  int shown = 0;
  for (int rank = 0; rank < 3; rank++) {
    const Pin pin =
        server.serverRank(rank).objects.pin(server.serverRank(0).datasets->get("user", "shell").key, 1);
    for (const auto& [partition, block] : pin.get<Dataset>()->volume->blocks) {
      EXPECT_EQ(pin.get<Dataset>()->partitioning->owner(partition), rank);
      shown++;
    }
  }
  EXPECT_EQ(shown, 3);

  EXPECT_FALSE(client->request(threshold("nothing", "x", 0, 1)).ok);
  const std::string wrong =
      client->request(R"(make {"name": "x", "filter": "Threshold", "inputs": {"source": "ball"}})").error;
  EXPECT_NE(wrong.find("filter Threshold without `least`; expected number"), std::string::npos) << wrong;
  client->expect("drop shell");
  client->expect("drop ball");
  for (int rank = 0; rank < 3; rank++) EXPECT_EQ(server.serverRank(rank).ledger.total("user"), 0);
}

TEST(Example, WhatAFilterMadeSaysHowAndIsOfTheStepOfItsSource) {
  ServerSetup setup;
  setup.modules = GALAXY_MODULES;
  TestServer server(std::move(setup));
  const auto client = server.client();
  for (const char* module : {"data", "analysis", "example"}) client->expect(std::string("load ") + module);
  const auto info = [&](const std::string& name) {
    return client->expect("info " + name).at("datasets").at(0);
  };
  for (int step = 1; step <= 2; step++) {
    client->expect(importBall("ball"));
    const json ball = info("ball");
    ASSERT_EQ(ball.at("origins").size(), 1u);
    EXPECT_EQ(ball.at("origins").at(0).at("step"), step) << "its own generation";
    EXPECT_FALSE(ball.contains("provenance"));
    EXPECT_FALSE(ball.contains("time")) << "it has none";
    client->expect(threshold("ball", "shell", 0.5, 1));
    const json shell = info("shell");
    EXPECT_EQ(shell.at("origins"), ball.at("origins"));
    EXPECT_EQ(
        shell.at("provenance"),
        (json{{"filter", "Threshold"},
              {"version", 1},
              {"properties", {{"least", 0.5}, {"largest", 1.0}}},
              {"inputs", json::array({{{"input", "source"}, {"name", "ball"}, {"generation", step}}})}}));
  }
  client->expect(importBall("ball"));
  EXPECT_EQ(info("ball").at("origins").at(0).at("step"), 3);
  EXPECT_EQ(info("shell").at("origins").at(0).at("step"), 2) << "of what it was made of";
  EXPECT_EQ(info("shell").at("generation"), 2) << "made again under the same name, it is the same object";
}

// A state document that named the source's file for it would bring back the source.
TEST(Example, AStateDocumentSaysHowAFilterMadeADataset) {
  ServerSetup setup;
  setup.modules = GALAXY_MODULES;
  TestServer server(std::move(setup));
  const auto client = server.client();
  for (const char* module : {"data", "viewer", "analysis", "example"})
    client->expect(std::string("load ") + module);
  client->expect(importBall("ball"));
  client->expect(threshold("ball", "shell", 0.5, 1));
  EXPECT_FALSE(client->expect("info shell").at("datasets").at(0).contains("file"));
  client->expect("window 1");
  EXPECT_EQ(client->expect("set 1 " + stateOf("shell")).at("warnings"), json::array());
  const json state = client->expect("state 1").at("state");
  ASSERT_EQ(state.at("Datasets").size(), 2u);
  EXPECT_EQ(state.at("Datasets").at(0).at("name"), "ball") << "what it is made of comes first";
  EXPECT_EQ(state.at("Datasets").at(1), (json{{"name", "shell"},
                                              {"type", "Volume"},
                                              {"filter", "Threshold"},
                                              {"inputs", {{"source", "ball"}}},
                                              {"color", {0.8, 0.8, 0.8, 1.0}},
                                              {"least", 0.5},
                                              {"largest", 1.0}}));

  const auto other = server.client("other");
  for (const char* module : {"data", "viewer"}) other->expect(std::string("load ") + module);
  other->expect("window 1");
  EXPECT_EQ(other->expect("set 1 " + state.dump()).at("warnings"), json::array());
  EXPECT_EQ(other->expect("info shell").at("datasets").at(0).at("provenance"),
            client->expect("info shell").at("datasets").at(0).at("provenance"))
      << "it was made again";
  EXPECT_EQ(other->request("render 1").error, "");
}

TEST(Example, ItsWorksLookAtAllSamplesAndLeaveTheWorkersToFrames) {
  ServerSetup setup;
  setup.modules = GALAXY_MODULES;
  TestServer server(std::move(setup));
  server.client()->expect("load example");
  for (int rank = 0; rank < 2; rank++)
    for (const char* name : {"example.range", "filters.make"})
      EXPECT_EQ(server.serverRank(rank).work.runsOf(name), Work::Runs::Long) << name;
}

/// A server on whose rank 1 nothing arrives until told; messages to rank 0 go on.
struct Held {
  Held() {
    ServerSetup setup;
    setup.modules = GALAXY_MODULES;
    server = std::make_unique<TestServer>(std::move(setup));
  }
  ~Held() {
    if (holds) goOn.set_value();
  }
  void hold() {
    holds = true;
    std::promise<void> begun;
    server->serverRank(1).transport.onMessage(
        Channel::Test, [&begun, released = goOn.get_future().share()](int, const Bytes&) {
          begun.set_value();
          released.wait();
        });
    server->serverRank(1).transport.send(1, Channel::Test, {});
    begun.get_future().wait();
  }
  void release() {
    holds = false;
    goOn.set_value();
  }
  bool holds = false;
  std::promise<void> goOn;
  std::unique_ptr<TestServer> server;
};

TEST(Example, AFilterThatIsCancelledMakesNothing) {
  Held held;
  std::promise<json> begun;
  std::once_flag once;
  auto options = held.server->options();
  options.onEvent = [&](const json& event) {
    if (event.at("event") == "progress" && event.at("text") == "threshold")
      std::call_once(once, [&] { begun.set_value(event); });
  };
  Client client(options);
  for (const char* module : {"data", "analysis", "example"}) client.expect(std::string("load ") + module);
  client.expect(importBall("ball"));
  held.hold();
  std::promise<Reply> made;
  const uint32_t id =
      client.send(threshold("ball", "shell", 0.5, 1), [&](const Reply& reply) { made.set_value(reply); });
  const json progress = begun.get_future().get();
  EXPECT_EQ(progress.at("request"), id);
  EXPECT_EQ(progress.at("done"), 0);
  EXPECT_EQ(progress.at("of"), 2 * Exchanges::kUnits);
  client.expect("cancel " + std::to_string(id));  // rank 0 is at it, rank 1 has not heard of it
  held.release();
  EXPECT_EQ(made.get_future().get().error, "cancelled");
  EXPECT_EQ(client.expect("list").at("datasets").size(), 1u);
  client.expect("drop ball");
  for (int rank = 0; rank < 2; rank++) EXPECT_EQ(held.server->serverRank(rank).ledger.total("user"), 0);
}

// It pins what the name means once it has it: pinned before, the source would be in the way of its own next generation.
TEST(Example, AFilterWhoseResultIsItsSourceWaitsForItsTurn) {
  Held held;
  std::promise<void> begun;
  std::once_flag once;
  auto options = held.server->options();
  options.onEvent = [&](const json& event) {
    if (event.at("event") == "progress" && event.at("text") == "threshold")
      std::call_once(once, [&] { begun.set_value(); });
  };
  Client client(options);
  const auto other = held.server->client();
  for (Client* each : {&client, other.get()})
    for (const char* module : {"data", "analysis", "example"}) each->expect(std::string("load ") + module);
  client.expect(importBall("ball"));
  held.hold();
  std::promise<Reply> first, second;
  client.send(threshold("ball", "ball", 0, 1), [&](const Reply& reply) { first.set_value(reply); });
  begun.get_future().wait();
  other->send(threshold("ball", "ball", 0, 2), [&](const Reply& reply) { second.set_value(reply); });
  other->expect("list");  // the request before it has begun
  held.release();
  EXPECT_EQ(first.get_future().get().error, "");
  EXPECT_EQ(second.get_future().get().error, "");
  const json info = client.expect("info ball").at("datasets").at(0);
  EXPECT_EQ(info.at("generation"), 3);
  EXPECT_EQ(info.at("provenance").at("inputs").at(0).at("generation"), 2);
}

}  // namespace
}  // namespace gxy::test

// SPDX-License-Identifier: Apache-2.0
// Module example: the paper's data range and its data-parallel filter, on several ranks.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <fstream>
#include <future>
#include <iterator>

#include "core/analysis/pointwise.h"
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

/// The same volume. Where it is told to, it stops on rank 0 until it may go on, or until its request is cancelled.
struct Pause {
  struct Stop {
    std::promise<void> begun, goOn;
  };
  static inline std::atomic<Stop*> stop = nullptr;  ///< of the run that comes next

  static FilterInfo info() {
    return {"Pause", 1, "The same volume.", {{"source", kVolumes, "."}}, DatasetType::Volume};
  }
  static std::vector<KeyRow<Pause>> properties() { return {}; }
  FilterResult run(FilterRun& run) const {
    run.begin(0, 2, "pause");
    agree(run.ranks, [&] {
      Stop* const here = run.ranks.rank() == 0 ? stop.exchange(nullptr) : nullptr;
      if (!here) return;
      here->begun.set_value();
      const auto goesOn = here->goOn.get_future();
      while (goesOn.wait_for(std::chrono::milliseconds(1)) == std::future_status::timeout) run.ranks.check();
    });
    return pointwise(run, run.input("source"), "pause", [](double value) { return float(value); });
  }
};

std::string pause(const std::string& source, const std::string& name) {
  return "make " + json{{"name", name}, {"filter", "Pause"}, {"inputs", {{"source", source}}}}.dump();
}

struct PauseServer : TestServer {
  static ServerSetup setup() {
    ServerSetup setup;
    setup.modules = GALAXY_MODULES;
    return setup;
  }
  PauseServer() : TestServer(setup()) {
    for (int rank = 0; rank < 2; rank++) serverRank(rank).filters.add(makeFilter<Pause>());
  }
};

TEST(Example, AFilterThatIsCancelledMakesNothing) {
  PauseServer server;
  std::promise<json> told;
  std::once_flag once;
  auto options = server.options();
  options.onEvent = [&](const json& event) {
    if (event.at("event") == "progress" && event.at("text") == "pause")
      std::call_once(once, [&] { told.set_value(event); });
  };
  Client client(options);
  for (const char* module : {"data", "analysis"}) client.expect(std::string("load ") + module);
  client.expect(importBall("ball"));
  Pause::Stop stop;
  Pause::stop = &stop;
  std::promise<Reply> made;
  const uint32_t id = client.send(pause("ball", "shell"), [&](const Reply& reply) { made.set_value(reply); });
  stop.begun.get_future().wait();
  const json progress = told.get_future().get();
  EXPECT_EQ(progress.at("request"), id);
  EXPECT_EQ(progress.at("done"), 0);
  EXPECT_EQ(progress.at("of"), 2 * Exchanges::kUnits);
  client.expect("cancel " + std::to_string(id));
  EXPECT_EQ(made.get_future().get().error, "cancelled");
  EXPECT_EQ(client.expect("list").at("datasets").size(), 1u);
  client.expect("drop ball");
  for (int rank = 0; rank < 2; rank++) EXPECT_EQ(server.serverRank(rank).ledger.total("user"), 0);
}

TEST(Example, AFilterWhoseResultIsItsSourceIsRefused) {
  PauseServer server;
  const auto client = server.client();
  for (const char* module : {"data", "analysis"}) client->expect(std::string("load ") + module);
  client->expect(importBall("ball"));
  const std::string error = client->request(pause("ball", "ball")).error;
  EXPECT_NE(error.find("expected no cycle: \"ball\" of \"ball\""), std::string::npos) << error;
}

/// A document with a live volume "ball", a threshold "shell" of it, and `more` entries.
json documentOf(double largest, const json& more = json::array()) {
  json entries{{{"name", "ball"}, {"type", "Volume"}},
               {{"name", "shell"},
                {"type", "Volume"},
                {"filter", "Threshold"},
                {"inputs", {{"source", "ball"}}},
                {"least", 0.5},
                {"largest", largest}}};
  for (const json& entry : more) entries.push_back(entry);
  json document = json::parse(stateOf("shell"));
  document["Datasets"] = entries;
  return document;
}

TEST(DocumentFilters, AreMadeAgainWhereTheDocumentOrItsDataHaveChanged) {
  ServerSetup setup;
  setup.modules = GALAXY_MODULES;
  TestServer server(std::move(setup));
  const auto client = server.client();
  for (const char* module : {"data", "viewer", "example"}) client->expect(std::string("load ") + module);
  client->expect(importBall("ball"));
  client->expect("window 1");
  // The generation of the threshold, and that of its input.
  const auto made = [&](double largest) {
    client->expect("set 1 " + documentOf(largest).dump());
    const json info = client->expect("info shell").at("datasets").at(0);
    return json{info.at("generation"), info.at("provenance").at("inputs").at(0).at("generation")};
  };
  EXPECT_EQ(made(1), (json{1, 1}));
  EXPECT_EQ(made(1), (json{1, 1})) << "it is made already";
  client->expect(importBall("ball"));
  EXPECT_EQ(made(1), (json{2, 2}));
  EXPECT_EQ(made(1.5), (json{3, 2}));
  client->expect("drop ball");
  client->expect(importBall("ball"));
  EXPECT_EQ(made(1.5), (json{4, 1})) << "another dataset of the same name";
  client->expect("drop shell");
  client->expect(importBall("shell"));
  client->expect("set 1 " + documentOf(1).dump());
  EXPECT_FALSE(client->expect("info shell").at("datasets").at(0).contains("provenance"))
      << "whoever reads a file under this name wants that";
}

TEST(DocumentFilters, SeeDataOfOneMomentAndSoDoPictures) {
  PauseServer server;
  const auto client = server.client(), other = server.client();
  for (const auto* each : {&client, &other})
    for (const char* module : {"data", "viewer", "example"}) (*each)->expect(std::string("load ") + module);
  writeBall(server.folder().path().string(), "other", 16, 0.7F);
  const auto generations = [&] {
    json found;
    for (const char* name : {"pause", "shell"})
      found.push_back(client->expect(std::string("info ") + name)
                          .at("datasets")
                          .at(0)
                          .at("provenance")
                          .at("inputs")
                          .at(0)
                          .at("generation"));
    return found;
  };
  json document = documentOf(
      1,
      json{{{"name", "pause"}, {"type", "Volume"}, {"filter", "Pause"}, {"inputs", {{"source", "ball"}}}}});
  std::swap(document["Datasets"][1], document["Datasets"][2]);  // the threshold comes after the pause
  json& operators = document["Visualization"]["operators"];
  operators[0]["isovalues"] = {0.5};
  for (const char* name : {"ball", "pause"})
    operators.push_back(
        {{"type", "Volume"}, {"dataset", name}, {"isovalues", {1.1}}, {"data range", {0, 1.7}}});
  const auto batch = [&](const std::string& prefix) {
    return "batch " + json{{"state", document}, {"prefix", prefix}}.dump();
  };
  const auto picture = [&](const std::string& prefix) {
    std::ifstream file(server.folder().path() / (prefix + "_00000.png"), std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  client->expect(importBall("ball"));
  client->expect(batch("before"));
  EXPECT_EQ(generations(), (json{1, 1}));
  for (const char* name : {"pause", "shell"}) client->expect(std::string("drop ") + name);

  Pause::Stop stop;
  Pause::stop = &stop;
  std::promise<Reply> done;
  client->send(batch("meanwhile"), [&](const Reply& reply) { done.set_value(reply); });
  stop.begun.get_future().wait();
  other->expect(importBall("ball", "other.vol"));
  stop.goOn.set_value();
  EXPECT_EQ(done.get_future().get().error, "");
  EXPECT_EQ(generations(), (json{1, 1}));
  EXPECT_FALSE(picture("before").empty());
  EXPECT_TRUE(picture("meanwhile") == picture("before"));

  client->expect(batch("after"));
  EXPECT_EQ(generations(), (json{2, 2}));
  EXPECT_FALSE(picture("after") == picture("before"));
}

}  // namespace
}  // namespace gxy::test

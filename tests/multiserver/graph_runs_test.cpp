// SPDX-License-Identifier: Apache-2.0
// What runs for a graph and when: cancelling, edits while something runs, pausing, room, and steps of a simulation.
#include <thread>

#include "multiserver/graph/document_edits.h"
#include "tests/multiserver/graph_client.h"
#include "tests/support/seeds.h"

namespace gxy::test {
namespace {

using nlohmann::json;

json numberTo(const std::string& node, int number) {
  return json::array({{{"set", {"Datasets", node, "number"}}, {"to", number}}});
}

void untilBegun(int count) {
  until([&] { return Held::gate().begun >= count; }, "it runs on all ranks");
}

TEST(GraphRuns, ACancelledEvaluationEndsOnAllRanksAndIsNotTriedAgain) {
  const auto server = serveGraphs(3);
  GraphClient c(*server);
  c.say(importBall("ball"));
  c.say(newGraph({liveVolume("ball"), copyOf("copy", "ball"), copyOf("next", "copy")}));
  Held::gate().shut = true;
  c.say("graph.run g");
  untilBegun(3);
  c.untilState("copy", "running");
  EXPECT_EQ(c.state("next"), "waiting");
  c.say("graph.cancel g copy");
  c.say("graph.wait g");
  EXPECT_EQ(Held::gate().ended, 3) << "on all ranks, while the gate is shut";
  EXPECT_EQ(c.state("copy"), "stale");
  EXPECT_EQ(c.node("copy").at("text"), "cancelled");
  EXPECT_EQ(c.node("next").at("by"), "copy");
  EXPECT_NE(c.error("graph.cancel g none").find("there is no dataset \"none\""), std::string::npos);
  Held::gate().shut = false;
  c.say("graph.run g");
  c.say("graph.wait g");
  EXPECT_EQ(c.state("next"), "done");
}

TEST(GraphRuns, WhatRunsForAViewWithoutAWindowGoesOnAndIsFoundAgain) {
  const auto server = serveGraphs(2);
  GraphClient c(*server);
  c.say(importBall("ball"));
  c.say(newGraph({liveVolume("ball"), copyOf("copy", "ball")}, json::array({viewOf("v", {"copy"})})));
  Held::gate().shut = true;
  {
    GraphClient other(*server);
    other.say(R"(viewer.show 1 {"graph": "g", "view": "v"})");
    untilBegun(2);
  }
  until([&] { return server->server().clients() == 1; }, "the other one has gone");
  c.untilState("copy", "running");
  Held::gate().shut = false;
  c.say("graph.wait g");
  EXPECT_EQ(c.node("v", "view").at("text"), "no window shows it");
  c.say(R"(viewer.show 1 {"graph": "g", "view": "v"})");
  c.untilState("v", "done", "view");
  EXPECT_EQ(Held::gate().begun, 2);
}

TEST(GraphRuns, AViewThatIsShownAgainHasItsPictureWhileOthersRun) {
  const auto server = serveGraphs(2);
  GraphClient c(*server);
  c.say(importBall("ball"));
  c.say(newGraph({liveVolume("ball"), copyOf("copy", "ball")},
                 json::array({viewOf("v", {"ball"}), viewOf("w", {"copy"})})));
  c.say(R"(viewer.show 1 {"graph": "g", "view": "v"})");
  c.untilState("v", "done", "view");
  Held::gate().shut = true;
  c.say(R"(viewer.show 2 {"graph": "g", "view": "w"})");
  untilBegun(2);
  c.say("close 1");
  c.say(R"(viewer.show 1 {"graph": "g", "view": "v"})");
  EXPECT_EQ(c.screen.waitFor(1, c.say("render 1").at("frame")).status, "complete");
  Held::gate().shut = false;
}

TEST(GraphRuns, WhatRunsForAViewWithoutAWindowEndsAfterAWhile) {
  ServerRankOptions options;
  options.leftViewsFor = std::chrono::milliseconds(20);
  const auto server = serveGraphs(2, options);
  GraphClient c(*server);
  c.say(importBall("ball"));
  c.say(newGraph({liveVolume("ball"), copyOf("copy", "ball")}, json::array({viewOf("v", {"copy"})})));
  Held::gate().shut = true;
  c.say(R"(viewer.show 1 {"graph": "g", "view": "v"})");
  untilBegun(2);
  c.say("close 1");
  until([] { return Held::gate().ended == 2; }, "it ends while the gate is shut");
  Held::gate().shut = false;
}

TEST(GraphRuns, AnEditSupersedesWhatRunsForAnOlderKey) {
  const auto server = serveGraphs(2);
  GraphClient c(*server);
  c.say(importBall("ball"));
  c.say(newGraph({liveVolume("ball"), copyOf("copy", "ball", 1)}, json::array({viewOf("v", {"copy"})})));
  Held::gate().shut = true;
  c.say(R"(viewer.show 1 {"graph": "g", "view": "v"})");
  untilBegun(2);
  c.edit(numberTo("copy", 2));
  untilBegun(4);
  until([] { return Held::gate().ended == 2; }, "the older one ends while the gate is shut");
  Held::gate().shut = false;
  c.untilState("v", "done", "view");
  EXPECT_EQ(c.node("copy").at("told").at("number"), 2);
  c.edit(numberTo("copy", 1));
  c.untilState("v", "done", "view");
  c.edit(numberTo("copy", 2));
  c.untilState("v", "done", "view");
  EXPECT_EQ(Held::gate().begun, 6) << "an output of before is found again";
  EXPECT_EQ(c.say("info g/copy").at("datasets").at(0).at("provenance").at("properties").at("number"), 2);
}

TEST(GraphRuns, OfLiveEditsOneIsEvaluatedAtATimeAndTheLastAlways) {
  const auto server = serveGraphs(1);
  GraphClient c(*server);
  c.say(importBall("ball"));
  c.say(newGraph({liveVolume("ball"), copyOf("copy", "ball", 1)}, json::array({viewOf("v", {"copy"})})));
  c.say(R"(viewer.show 1 {"graph": "g", "view": "v"})");
  c.untilState("v", "done", "view");
  Held::gate().shut = true;
  for (int number = 2; number < 20; number++)
    if (number != 13) c.edit(numberTo("copy", number), true);
  untilBegun(2);
  Held::gate().shut = false;
  c.say("graph.wait g");
  EXPECT_EQ(c.node("copy").at("told").at("number"), 19);
  EXPECT_EQ(Held::gate().begun, 3) << "the first, the one that ran, the last";
}

TEST(GraphRuns, AFailureIsOfItsNodeAndSaysTheRank) {
  const auto server = serveGraphs(2);
  GraphClient c(*server);
  c.say(importBall("ball"));
  c.say(newGraph(
      {liveVolume("ball"), copyOf("copy", "ball", 13), copyOf("next", "copy"), copyOf("other", "ball", 3)}));
  c.say("graph.run g");
  c.say("graph.wait g");
  const json copy = c.node("copy");
  EXPECT_EQ(copy.at("state"), "failed");
  EXPECT_EQ(copy.at("text"), "13 is no good number");
  EXPECT_EQ(copy.at("rank"), 1);
  EXPECT_EQ(c.node("next").at("by"), "copy");
  EXPECT_EQ(c.state("other"), "done") << "others go on";
  c.edit(numberTo("copy", 4));
  EXPECT_EQ(c.state("copy"), "waiting") << "an error belongs to a key";
  c.say("graph.run g");
  c.say("graph.wait g");
  EXPECT_EQ(c.state("next"), "done");
}

TEST(GraphRuns, APausedGraphEvaluatesWhenAsked) {
  const auto server = serveGraphs(1);
  GraphClient c(*server);
  c.say(importBall("ball"));
  c.say(newGraph({liveVolume("ball"), copyOf("copy", "ball")}, json::array({viewOf("v", {"copy"})})));
  c.say("graph.pause g");
  EXPECT_TRUE(c.say("graph.get g").at("paused"));
  c.say(R"(viewer.show 1 {"graph": "g", "view": "v"})");
  c.say("graph.wait g");
  EXPECT_EQ(c.state("copy"), "waiting");
  EXPECT_EQ(c.node("copy").at("text"), "paused");
  c.say("graph.run g");
  c.untilState("v", "done", "view");
  c.edit(numberTo("copy", 5));
  c.say("graph.wait g");
  EXPECT_EQ(c.state("copy"), "stale");
  c.say("graph.resume g");
  c.untilState("v", "done", "view");
  EXPECT_EQ(Held::gate().begun, 2);
}

TEST(GraphRuns, EqualNodesOfATenantsGraphsShareAnOutput) {
  const auto server = serveGraphs(1);
  GraphClient c(*server);
  c.say(importBall("ball"));
  c.say(newGraph({liveVolume("ball"), copyOf("copy", "ball")}));
  c.say("graph.run g");
  c.say("graph.wait g");
  c.say("graph.new h " + json{{"Datasets", {liveVolume("ball"), copyOf("other", "ball")}}}.dump());
  c.say("graph.run h");
  c.say("graph.wait h");
  EXPECT_EQ(Held::gate().begun, 1);
  c.say("graph.drop g");
  EXPECT_EQ(c.say("info h/other").at("datasets").size(), 1u) << "it is still the other graph's";
  c.say("graph.drop h");
  EXPECT_EQ(c.say("data.list all").at("datasets").size(), 1u);
}

TEST(GraphRuns, AnOutputThatHasGoneIsMadeAgain) {
  const auto server = serveGraphs(2);
  GraphClient c(*server);
  c.say(importBall("ball"));
  c.say(newGraph({liveVolume("ball"), copyOf("copy", "ball"), copyOf("next", "copy")}));
  c.say("graph.run g copy");
  c.say("graph.wait g");
  ServerRank& root = server->serverRank();
  root.callAll("datasets.drop", {{"key", root.datasets->get("user", "g/copy").key.value}});
  c.untilState("copy", "waiting");
  c.say("graph.run g");
  c.say("graph.wait g");
  EXPECT_EQ(c.state("next"), "done") << c.node("next");
  EXPECT_EQ(Held::gate().begun, 6);
  c.say("graph.drop g");
  c.say("drop ball");
  EXPECT_EQ(server->serverRank(1).ledger.total("user"), 0);
}

TEST(GraphRuns, OutputsThatNothingShowsMakeRoomForOthers) {
  ServerRankOptions options;
  options.tenantMemory = 150000;  // a ball takes 5 or 6 of 25 kB, with its bricks
  const auto server = serveGraphs(1, options);
  GraphClient c(*server);
  c.say(importBall("ball"));
  const int64_t bytes = server->serverRank(0).ledger.total("user");
  const auto fit = int(options.tenantMemory / bytes) - 1;
  ASSERT_GE(fit, 1);
  c.say(newGraph({liveVolume("ball"), copyOf("copy", "ball")}));
  for (int number = 0; number < 2 * fit + 2; number++) {
    c.edit(numberTo("copy", 20 + number));
    c.say("graph.run g");
    c.say("graph.wait g");
    ASSERT_EQ(c.state("copy"), "done") << number << " of " << fit << ": " << c.node("copy");
  }
  json all = json::array({liveVolume("ball")});
  std::vector<std::string> names;
  for (int i = 0; i < fit + 1; i++) {
    names.push_back("c" + std::to_string(i));
    all.push_back(copyOf(names.back(), "ball", 100 + i));
  }
  c.edit(json::array({{{"set", {"Datasets"}}, {"to", all}},
                      {{"set", {"Visualizations"}}, {"to", json::array({viewOf("v", names)})}}}));
  c.say(R"(viewer.show 1 {"graph": "g", "view": "v"})");
  c.say("graph.wait g");
  int failed = 0;
  for (const std::string& name : names)
    if (c.state(name) == "failed") {
      failed++;
      EXPECT_NE(c.node(name).at("text").get<std::string>().find("memory: "), std::string::npos);
    }
  EXPECT_GE(failed, 1) << "what is shown is not given up";
}

// The view shows p, t and what is made of both, of one step each time.
TEST(GraphRuns, WavesOfAViewAreOfOneStepOfASimulation) {
  ServerRankOptions options;
  options.adoptAfter = std::chrono::milliseconds(20);
  const auto server = serveGraphs(2, options);
  writeBall(server->folder().path().string(), "twice", 16, 2);
  GraphClient c(*server);
  c.say(importBall("ball"));
  c.say(importBall("twice", "twice.vol"));
  TwoFields fields(*server);
  fields.publish("ball");
  c.say(newGraph(
      {liveVolume("p"), liveVolume("t"),
       madeBy("Derive", "sum", {{"a", "p"}, {"b", "t"}}, {{"expression", "a + b"}}), copyOf("copy", "sum")},
      json::array({viewOf("v", {"p", "copy"})})));
  c.say(R"(viewer.show 1 {"graph": "g", "view": "v"})");
  c.untilState("v", "done", "view");
  Held::gate().shut = true;
  const int begun = Held::gate().begun;
  fields.publish("twice");
  untilBegun(begun + 2);
  fields.publish("ball");
  fields.publish("twice");
  EXPECT_EQ(Held::gate().ended, begun) << "new data cancel nothing";
  Held::gate().shut = false;
  c.say("graph.wait g");
  const auto stepOf = [&](const std::string& name) {
    const json origins = c.say("info " + name).at("datasets").at(0).at("origins");
    EXPECT_EQ(origins.size(), 1u) << origins;
    return origins.at(0).at("step").get<int64_t>();
  };
  until([&] { return stepOf("g/copy") == fields.step(); }, "the newest step is made");
  EXPECT_EQ(stepOf("g/sum"), fields.step());
  c.untilState("v", "done", "view");
  c.say("graph.drop g");
  for (const char* name : {"p", "t", "ball", "twice"}) c.say(std::string("drop ") + name);
  until([&] { return server->serverRank(1).ledger.total("user") == 0; }, "nothing is kept");
}

TEST(GraphRuns, APublisherGetsTheRoomOfWhatAGraphReads) {
  ServerRankOptions options;
  options.adoptAfter = std::chrono::milliseconds(20);
  const auto server = serveGraphs(2, options);
  GraphClient c(*server);
  c.say(importBall("ball"));
  TwoFields fields(*server);
  fields.publish("ball");
  c.say(newGraph({liveVolume("p"), copyOf("copy", "p")}));
  Held::gate().shut = true;
  c.say("graph.run g");
  untilBegun(2);
  for (int i = 0; i < 3; i++) fields.publish("ball");  // throws where there is no room
  EXPECT_TRUE(c.hasMemory(1, "graph g"));
  Held::gate().shut = false;
  c.say("graph.wait g");
  EXPECT_EQ(c.say("info g/copy").at("datasets").at(0).at("origins").at(0).at("step"), 1);
  c.say("graph.drop g");
  for (const char* name : {"p", "t", "ball"}) c.say(std::string("drop ") + name);
  until([&] { return server->serverRank(1).ledger.total("user") == 0; }, "nothing is kept");
}

TEST(GraphRuns, WhatIsDroppedEndsWhatRuns) {
  const auto server = serveGraphs(2);
  GraphClient c(*server);
  c.say(importBall("ball"));
  c.say(newGraph({liveVolume("ball"), copyOf("copy", "ball")}));
  Held::gate().shut = true;
  c.say("graph.run g");
  untilBegun(2);
  c.say("graph.drop g");
  EXPECT_EQ(Held::gate().ended, 2);
  c.say(newGraph({liveVolume("ball"), copyOf("copy", "ball")}));
  c.say("graph.run g");
  untilBegun(4);
  c.client.reset();  // The server stops while something runs.
}

// While a view is evaluated for each of them.
TEST(GraphRuns, EditsOfManyAreOrderedByTheServerAndTheLastIsShown) {
  const auto server = serveGraphs(2);
  GraphClient watcher(*server), ann(*server), bob(*server);
  watcher.say(importBall("ball"));
  watcher.say(newGraph({liveVolume("ball"), copyOf("copy", "ball", 1), copyOf("next", "copy", 1)},
                       json::array({viewOf("v", {"next"})})));
  watcher.say(R"(viewer.show 1 {"graph": "g", "view": "v"})");
  watcher.say("graph.watch g");
  json document = watcher.say("graph.get g").at("document");
  const int count = sweep(40);
  const auto edit = [count](GraphClient& c, const std::string& name) {
    for (int i = 0; i < count; i++) {
      c.edit(numberTo(i % 3 ? "copy" : "next", i % 10), i % 2);
      const std::string own = name + std::to_string(i);
      if (i % 5 == 0) c.edit(json::array({{{"add", {"Datasets"}}, {"to", copyOf(own, "copy")}}}));
      if (i % 10 == 5) c.edit(json::array({{{"rename", {"Datasets", own}}, {"to", own + " more"}}}));
    }
  };
  std::thread other([&] { edit(bob, "b"); });
  edit(ann, "a");
  other.join();
  ann.say("graph.wait g");
  const json graph = ann.say("graph.get g");
  watcher.untilEvent(
      [&](const json& e) { return e.at("event") == "graph" && e.at("revision") == graph.at("revision"); });
  int64_t revision = 1;
  const std::lock_guard lock(watcher.mutex);
  for (const json& event : watcher.events) {
    if (event.at("event") != "graph") continue;
    EXPECT_EQ(event.at("revision"), ++revision) << "each once, in their order";
    document = edited(document, event.at("edits")).document;
  }
  EXPECT_EQ(document, graph.at("document"));
  EXPECT_EQ(ann.state("v", "view"), "done");
  const json shown = ann.node("next");
  json expected;
  for (const json& dataset : graph.at("document").at("Datasets"))
    if (dataset.at("name") == "next") expected = dataset.at("number");
  EXPECT_EQ(shown.at("told").at("number"), expected);
}

}  // namespace
}  // namespace gxy::test

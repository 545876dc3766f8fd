// SPDX-License-Identifier: Apache-2.0
// A graph's life: sources that are dropped and renamed while something runs, edits that make no data, what only evaluation finds, cycles, and
// a graph that no client looks after.
#include "tests/multiserver/graph_client.h"

namespace gxy::test {
namespace {

using nlohmann::json;

TEST(GraphLife, WhatOnlyEvaluationFindsIsTheNodesErrorWithBothNames) {
  const auto server = serveGraphs(3);
  writeBall(server->folder().path().string(), "finer", 24);
  GraphClient c(*server);
  c.say(importBall("ball"));
  c.say(importBall("fine", "finer.vol"));
  c.say(newGraph({liveVolume("ball"), liveVolume("fine"),
                  madeBy("Derive", "sum", {{"f", "ball"}, {"g", "fine"}}, {{"expression", "f + g"}}),
                  copyOf("next", "sum"), copyOf("good", "ball")},
                 json::array({viewOf("both", {"ball", "fine"}), viewOf("one", {"ball", "good"})})));
  c.say("graph.run g");
  c.say("graph.wait g");
  const json sum = c.node("sum");
  EXPECT_EQ(sum.at("state"), "failed") << sum;
  const std::string text = sum.value("text", "");
  EXPECT_NE(text.find("`f` and `g`"), std::string::npos) << text;
  EXPECT_NE(text.find("Resample"), std::string::npos) << text;
  EXPECT_EQ(c.node("next").at("state"), "blocked");
  EXPECT_EQ(c.node("next").at("by"), "sum");
  EXPECT_EQ(c.state("good"), "done");
  c.say(R"(viewer.show 1 {"graph": "g", "view": "both"})");
  c.say(R"(viewer.show 2 {"graph": "g", "view": "one"})");
  c.untilState("one", "done", "view");
  c.untilState("both", "failed", "view");
  const std::string both =
      "visualization: \"ball\" and \"fine\" are partitioned differently, expected one partitioning; import "
      "one "
      "`like` the other";
  EXPECT_EQ(c.node("both", "view").at("text"), both);
  EXPECT_NE(c.error("render 1").find(both), std::string::npos) << c.error("render 1");
  const auto frame = c.say("render 2").at("frame").get<uint64_t>();
  EXPECT_EQ(c.screen.waitFor(2, frame).status, "complete");
  // With data that are cut alike there is a picture.
  c.say(R"(import like fine {"Datasets": [{"name": "ball", "type": "Volume", "filename": "ball.vol"}]})");
  c.untilState("both", "done", "view");
  // The window may hear of the data after the client, and then begins a frame of its own in place of this one.
  uint64_t last = c.say("render 1").at("frame");
  while (c.screen.waitFor(1, last).status == "superseded") last++;
  EXPECT_EQ(c.screen.waitFor(1, last).status, "complete");
}

TEST(GraphLife, CyclesByRenamingAreRefused) {
  const auto server = serveGraphs(1);
  GraphClient c(*server);
  c.say(newGraph({copyOf("a", "b"), copyOf("c", "a")}));
  EXPECT_EQ(c.state("a"), "incomplete");
  const json before = c.say("graph.get g");
  const std::string error =
      c.error("graph.edit g " + json{{"edits", {{{"rename", {"Datasets", "c"}}, {"to", "b"}}}}}.dump());
  EXPECT_NE(error.find("no cycle"), std::string::npos) << error;
  EXPECT_NE(error.find("a"), std::string::npos) << error;
  EXPECT_EQ(c.say("graph.get g"), before);
  // Two that swap their names are none.
  c.edit(json::array({{{"rename", {"Datasets", "c"}}, {"to", "d"}},
                      {{"rename", {"Datasets", "a"}}, {"to", "c"}},
                      {{"rename", {"Datasets", "d"}}, {"to", "a"}}}));
  const json document = c.say("graph.get g").at("document");
  EXPECT_EQ(document.at("Datasets").at(0).at("inputs").at("field"), "b");
  EXPECT_EQ(document.at("Datasets").at(1).at("name"), "a");
  EXPECT_EQ(document.at("Datasets").at(1).at("inputs").at("field"), "c");
}

TEST(GraphLife, SourcesMayGoWhileAFilterReadsThem) {
  for (const char* away : {"drop ball", "rename ball bowl"}) {
    SCOPED_TRACE(away);
    const auto server = serveGraphs(3);
    writeBall(server->folder().path().string(), "twice", 16, 2);
    GraphClient c(*server);
    c.say(importBall("ball"));
    c.say(newGraph(
        {liveVolume("ball"), copyOf("copy", "ball"), madeBy("Statistics", "numbers", {{"field", "copy"}})}));
    Held::gate().shut = true;
    c.say("graph.run g");
    until([] { return Held::gate().begun == 3; }, "it runs on all ranks");
    c.say(away);
    Held::gate().shut = false;
    c.say("graph.wait g");
    EXPECT_EQ(Held::gate().ended, Held::gate().begun);
    EXPECT_EQ(c.state("ball"), "waiting");
    // Whatever comes under the name is read next.
    c.say(importBall("ball", "twice.vol"));
    c.say("graph.run g");
    c.say("graph.wait g");
    EXPECT_EQ(c.state("numbers"), "done") << c.node("numbers");
    EXPECT_NEAR(c.node("numbers").at("told").at("largest").at("value").get<double>(), 2 * std::sqrt(3), 1e-5);
    c.say("graph.drop g");
    c.say("drop ball");
    if (std::string(away) != "drop ball") c.say("drop bowl");
    for (int r = 0; r < 3; r++)
      until([&] { return server->serverRank(r).ledger.total("user") == 0; }, "nothing is kept");
  }
}

TEST(GraphLife, EditsOfLooksNotesPositionsAndCamerasEvaluateNothing) {
  const auto server = serveGraphs(2);
  GraphClient c(*server);
  c.say(importBall("ball"));
  c.say(newGraph({liveVolume("ball"), copyOf("copy", "ball")}, json::array({viewOf("v", {"copy"})})));
  c.say(R"(viewer.show 1 {"graph": "g", "view": "v"})");
  c.untilState("v", "done", "view");
  const json made = c.node("copy");
  const int begun = Held::gate().begun;
  const json camera{{"viewpoint", {1, 2, 5}}, {"viewcenter", {0, 0, 0}}, {"viewup", {0, 1, 0}}, {"aov", 30}};
  const std::vector<json> edits{
      {{"set", {"Datasets", "copy", "note"}}, {"to", "what it is for"}},
      {{"set", {"Datasets", "copy", "color"}}, {"to", {1, 0.5, 0}}},
      {{"set", {"Datasets", "copy", "GUI"}}, {"to", {{"x", 12}, {"y", 5}}}},
      {{"set", {"GUI"}}, {"to", {{"nodes", {{"copy", {3, 4}}}}}}},
      {{"set", {"Visualizations", "v", "camera"}}, {"to", camera}},
      {{"set", {"Visualizations", "v", "operators", 0, "isovalues"}}, {"to", {0.4}}},
      {{"set", {"Visualizations", "v", "size"}}, {"to", {64, 48}}},
      {{"rename", {"Datasets", "copy"}}, {"to", "clone"}},
  };
  for (const json& edit : edits) {
    c.edit(json::array({edit}));
    c.say("graph.wait g");
    EXPECT_EQ(Held::gate().begun, begun) << edit;
  }
  const json clone = c.node("clone");
  EXPECT_EQ(clone.at("state"), "done") << clone;
  for (const char* same : {"told", "bytes"}) EXPECT_EQ(clone.at(same), made.at(same)) << clone;
  // What does count is seen.
  c.edit(json::array({{{"set", {"Datasets", "clone", "number"}}, {"to", 8}}}));
  c.say("graph.wait g");
  EXPECT_EQ(Held::gate().begun, begun + 2);
}

TEST(GraphLife, AGraphGoesOnWithoutAnyClient) {
  ServerRankOptions options;
  options.adoptAfter = std::chrono::milliseconds(20);
  const auto server = serveGraphs(2, options);
  writeBall(server->folder().path().string(), "twice", 16, 2);
  TwoFields fields(*server);
  {
    GraphClient c(*server);
    c.say(importBall("ball"));
    c.say(importBall("twice", "twice.vol"));
    c.say("graph.new g " + json{{"Datasets", {liveVolume("p"), copyOf("copy", "p")}},
                                {"Outputs", {{{"type", "Publish"}, {"of", "copy"}, {"to", "shown"}}}}}
                               .dump());
  }
  until([&] { return server->server().clients() == 0; }, "nobody is connected");
  const auto stepShown = [&]() -> int64_t {
    try {
      const auto found = server->serverRank().datasets->get("user", "shown");
      return server->serverRank(1)
          .objects.pin(found.key, found.generation)
          .get<Dataset>()
          ->origins.at(0)
          .step;
    } catch (const Error&) {
      return 0;  // not there yet
    }
  };
  for (int64_t step = 1; step <= 3; step++) {
    fields.publish(step % 2 ? "ball" : "twice");
    until([&] { return stepShown() == step; }, "the step is made");
  }
  EXPECT_EQ(server->server().clients(), 0u);
  EXPECT_EQ(Held::gate().begun, 6) << "each step once, on both ranks";
  GraphClient c(*server);
  EXPECT_EQ(c.say("graph.list").at("graphs").size(), 1u);
  EXPECT_EQ(c.state("copy"), "done");
  EXPECT_EQ(c.node("copy").at("generation"), 3) << c.node("copy");
  EXPECT_EQ(c.say("info shown").at("datasets").at(0).at("origins").at(0).at("step"), 3);
  c.say("graph.drop g");
  for (const char* name : {"p", "t", "ball", "twice"}) c.say(std::string("drop ") + name);
  until([&] { return server->serverRank(1).ledger.total("user") == 0; }, "nothing is kept");
}

}  // namespace
}  // namespace gxy::test

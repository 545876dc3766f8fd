// SPDX-License-Identifier: Apache-2.0
// Windows on views of graphs.
#include "tests/multiserver/graph_client.h"

namespace gxy::test {
namespace {

using nlohmann::json;

/// A document's picture in a window that shows datasets by their names.
std::vector<uint8_t> plainPicture(GraphClient& c, json view) {
  const json camera = view.at("camera");
  for (const char* key : {"name", "camera", "size"}) view.erase(key);
  c.say("window 9 {\"size\": [96, 80]}");
  c.say("set 9 " + json{{"Visualization", view}, {"Camera", camera}}.dump());
  const uint64_t frame = c.say("render 9").at("frame");
  EXPECT_EQ(c.screen.waitFor(9, frame).status, "complete");
  return c.screen.picture(9).rgba;
}

const json kSeeds = madeBy("Seeds", "seeds", {{"domain", "ball"}}, {{"shape", "line"}, {"count", 6}});
const json kParticles{{"type", "Particles"}, {"dataset", "seeds"}, {"radius0", 0.1}};

json particlesView() {
  json view = viewOf("v", {"ball"});
  view["operators"].push_back(kParticles);
  return view;
}

TEST(GraphViews, ShowTheSamePictureAsTheirDataByName) {
  const json& seeds = kSeeds;
  std::vector<uint8_t> expected;
  for (const int ranks : {1, 3}) {
    const auto server = serveGraphs(ranks);
    GraphClient c(*server);
    c.say(importBall("ball"));
    c.say(newGraph({liveVolume("ball"), seeds}, json::array({particlesView()})));
    c.say(R"(viewer.show 1 {"graph": "g", "view": "v"})");
    c.untilState("v", "done", "view");
    EXPECT_EQ(c.say("windows").at("windows").at(0).at("size"), (json{96, 80}));
    const uint64_t frame = c.say("render 1").at("frame");
    const Screen::End end = c.screen.waitFor(1, frame);
    EXPECT_EQ(end.status, "complete") << end.json;
    EXPECT_EQ(end.json.at("revision"), 1);
    EXPECT_EQ(end.json.at("generations"), (json{{"ball", 1}, {"seeds", 1}}));
    const auto picture = c.screen.picture(1).rgba;
    c.say("make " + seeds.dump());
    EXPECT_EQ(picture, plainPicture(c, particlesView()));
    if (expected.empty()) expected = picture;
    EXPECT_EQ(picture, expected) << ranks;
    EXPECT_EQ(c.say("pick 1 48 40").at("dataset"), "ball");
  }
}

TEST(GraphViews, FollowEditsOfLooksAndColours) {
  const auto server = serveGraphs(2);
  GraphClient c(*server);
  c.say(importBall("ball"));
  c.say(newGraph({liveVolume("ball"), kSeeds}, json::array({particlesView()})));
  c.say(R"(viewer.show 1 {"graph": "g", "view": "v"})");
  c.untilState("v", "done", "view");
  EXPECT_EQ(c.screen.waitFor(1, c.say("render 1").at("frame")).status, "complete");
  const auto first = c.screen.picture(1).rgba;
  const json thick =
      c.edit(json::array({{{"set", {"Visualizations", "v", "operators", 1, "radius0"}}, {"to", 0.2}}}));
  const Screen::End second = c.screen.waitFor(1, 2);
  EXPECT_EQ(second.json.at("revision"), 2);
  EXPECT_NE(c.screen.picture(1).rgba, first);
  c.edit(thick.at("inverse"));
  c.screen.waitFor(1, 3);
  EXPECT_EQ(c.screen.picture(1).rgba, first);
  c.edit(json::array({{{"set", {"Datasets", "seeds", "color"}}, {"to", {1, 0, 0}}}}));
  c.screen.waitFor(1, 4);
  EXPECT_NE(c.screen.picture(1).rgba, first);
  EXPECT_EQ(c.node("seeds").at("generation"), 1) << "a colour makes no data";
}

TEST(GraphViews, FollowTheirData) {
  const auto server = serveGraphs(2);
  writeBall(server->folder().path().string(), "twice", 16, 2);
  GraphClient c(*server);
  c.say(importBall("ball"));
  c.say(newGraph({liveVolume("ball"), copyOf("copy", "ball")}, json::array({viewOf("v", {"copy"})})));
  c.say(R"(viewer.show 1 {"graph": "g", "view": "v"})");
  c.untilState("v", "done", "view");
  EXPECT_EQ(c.screen.waitFor(1, c.say("render 1").at("frame")).status, "complete");
  const auto first = c.screen.picture(1).rgba;
  c.say(importBall("ball", "twice.vol"));
  const Screen::End end = c.screen.waitFor(1, 2);
  EXPECT_EQ(end.status, "complete");
  EXPECT_EQ(end.json.at("generations"), (json{{"copy", 2}}));
  EXPECT_NE(c.screen.picture(1).rgba, first);
  json plain = viewOf("v", {"ball"});
  EXPECT_EQ(c.screen.picture(1).rgba, plainPicture(c, plain));
}

TEST(GraphViews, TakeTheirWindowsAlongWhereTheyAreRenamed) {
  const auto server = serveGraphs(2);
  GraphClient c(*server);
  c.say(importBall("ball"));
  c.say(newGraph({liveVolume("ball"), kSeeds}, json::array({viewOf("a", {"ball"}), viewOf("b", {"ball"})})));
  c.say(R"(viewer.show 1 {"graph": "g", "view": "a"})");
  c.untilState("a", "done", "view");
  EXPECT_EQ(c.screen.waitFor(1, c.say("render 1").at("frame")).status, "complete");
  const auto first = c.screen.picture(1).rgba;
  // The two views take each other's names; the window stays with what it shows.
  const auto rename = [](const char* view, const char* to) {
    return json{{"rename", {"Visualizations", view}}, {"to", to}};
  };
  const json made = c.edit({rename("a", "c"), rename("b", "a"), rename("c", "b")});
  const auto cutAt = [](const char* view, double at) {
    return json{{"set", {"Visualizations", view, "operators", 0, "clip planes"}}, {"to", {{1, 0, 0, at}}}};
  };
  c.edit(json::array({cutAt("a", 0.25)}));
  EXPECT_EQ(c.state("a", "view"), "waiting") << "no window shows it";
  c.edit(json::array({cutAt("b", 0.0)}));
  until([&] { return c.screen.picture(1).rgba != first; }, "the view's look is another");
  c.edit(json::array({{{"remove", {"Visualizations", "b", "operators", 0, "clip planes"}}}}));
  until([&] { return c.screen.picture(1).rgba == first; }, "its look is as it was");
  c.edit(made.at("inverse"));
  c.edit(json::array({cutAt("a", 0.0)}));
  until([&] { return c.screen.picture(1).rgba != first; }, "its name is as it was");
}

TEST(GraphViews, ThatHaveNothingToShowSayWhy) {
  const auto server = serveGraphs(1);
  GraphClient c(*server);
  c.say(newGraph({liveVolume("ball"), copyOf("copy", "ball", 13)}, json::array({viewOf("v", {"copy"})})));
  c.say(R"(viewer.show 1 {"graph": "g", "view": "v"})");
  EXPECT_NE(c.error("render 1").find("window 1: its data are not there yet"), std::string::npos);
  c.say(importBall("ball"));
  c.untilState("v", "blocked", "view");
  until([&] { return c.error("render 1").find("13 is no good number") != std::string::npos; }, "the reason");
  c.edit(json::array({{{"set", {"Datasets", "copy", "number"}}, {"to", 1}}}));
  EXPECT_EQ(c.screen.waitFor(1, 1).status, "complete") << "it renders by itself what was asked for";
  EXPECT_NE(c.error(R"(viewer.show 1 {"graph": "none", "view": "v"})").find("there is none"),
            std::string::npos);
  EXPECT_NE(c.error(R"(viewer.show 1 {"graph": "g"})").find("`view` is missing"), std::string::npos);
  c.say("graph.drop g");
  until([&] { return c.error("render 1").find("the graph was dropped") != std::string::npos; }, "the reason");
}

TEST(GraphViews, HoldTheirPictureWhenTheirDataAreDropped) {
  const auto server = serveGraphs(2);
  GraphClient c(*server);
  c.say(importBall("ball"));
  c.say(newGraph({liveVolume("ball"), kSeeds}, json::array({viewOf("v", {"ball"})})));
  c.say(R"(viewer.show 1 {"graph": "g", "view": "v"})");
  c.untilState("v", "done", "view");
  EXPECT_EQ(c.screen.waitFor(1, c.say("render 1").at("frame")).status, "complete");
  const auto first = c.screen.picture(1).rgba;
  c.say("data.drop ball");
  c.untilState("v", "stale", "view");
  until([&] { return c.error("render 1").find("held picture: its data are gone") != std::string::npos; },
        "the reason");
  c.say(importBall("ball"));
  EXPECT_EQ(c.screen.waitFor(1, 2).status, "complete") << "it turns again with the next wave";
  EXPECT_EQ(c.screen.picture(1).rgba, first);
  EXPECT_EQ(c.state("ball"), "done");
}

TEST(GraphViews, WithoutAWindowNothingRuns) {
  const auto server = serveGraphs(1);
  GraphClient c(*server);
  c.say(importBall("ball"));
  c.say(newGraph({liveVolume("ball"), copyOf("copy", "ball")}, json::array({viewOf("v", {"copy"})})));
  c.say("graph.wait g");
  EXPECT_EQ(Held::gate().begun, 0);
  c.say(R"(viewer.show 1 {"graph": "g", "view": "v"})");
  c.untilState("v", "done", "view");
  c.say("close 1");
  c.say(importBall("ball"));
  c.say("graph.wait g");
  EXPECT_EQ(Held::gate().begun, 1);
  EXPECT_EQ(c.node("v", "view").at("text"), "no window shows it");
}

TEST(GraphViews, ThatAWindowDoesNotFollowTakeNoNewerData) {
  const auto server = serveGraphs(2);
  writeBall(server->folder().path().string(), "twice", 16, 2);
  GraphClient c(*server);
  c.say(importBall("ball"));
  c.say(importBall("twice", "twice.vol"));
  TwoFields fields(*server);
  fields.publish("ball");
  c.say(newGraph({liveVolume("p")}, json::array({viewOf("v", {"p"})})));
  c.say(R"(viewer.show 1 {"graph": "g", "view": "v"})");
  EXPECT_EQ(c.say("windows").at("windows").at(0).at("follow"), true);
  c.untilState("v", "done", "view");
  EXPECT_EQ(c.screen.waitFor(1, c.say("render 1").at("frame")).status, "complete");
  const auto first = c.screen.picture(1).rgba;
  c.say(R"(window 1 {"follow": false})");
  fields.publish("twice");
  c.say("graph.wait g");
  EXPECT_EQ(c.screen.waitFor(1, c.say("render 1").at("frame")).json.at("generations"), (json{{"p", 1}}));
  EXPECT_EQ(c.screen.picture(1).rgba, first);
  c.say(R"(window 1 {"follow": true})");
  const Screen::End end = c.screen.waitFor(1, 3);  // the server begins it by itself
  EXPECT_EQ(end.json.at("generations"), (json{{"p", 2}}));
  EXPECT_NE(c.screen.picture(1).rgba, first);
}

TEST(GraphViews, OfAnAdoptedStepTurnOnWhileThePublisherGoesOn) {
  ServerRankOptions options;
  options.adoptAfter = std::chrono::milliseconds(20);
  const auto server = serveGraphs(2, options);
  writeBall(server->folder().path().string(), "twice", 16, 2);
  GraphClient c(*server);
  c.say(importBall("ball"));
  c.say(importBall("twice", "twice.vol"));
  TwoFields fields(*server);
  fields.publish("ball");
  json view = viewOf("v", {"p"});
  view["follow"] = false;
  c.say(newGraph({liveVolume("p")}, json::array({view})));
  c.say(R"(viewer.show 1 {"graph": "g", "view": "v"})");
  c.untilState("v", "done", "view");
  EXPECT_EQ(c.screen.waitFor(1, c.say("render 1").at("frame")).status, "complete");
  const auto first = c.screen.picture(1).rgba;
  for (int i = 0; i < 3; i++) fields.publish("twice");
  c.edit(json::array({{{"set", {"Visualizations", "v", "operators", 0, "isovalues"}}, {"to", {0.5}}}}));
  c.screen.waitFor(1, 2);
  EXPECT_NE(c.screen.picture(1).rgba, first);
  c.edit(json::array({{{"set", {"Visualizations", "v", "operators", 0, "isovalues"}}, {"to", {0.6}}}}));
  const Screen::End end = c.screen.waitFor(1, 3);
  EXPECT_EQ(end.status, "complete") << end.json;
  EXPECT_EQ(end.json.at("generations"), (json{{"p", 1}}));
  EXPECT_EQ(c.screen.picture(1).rgba, first);
}

}  // namespace
}  // namespace gxy::test

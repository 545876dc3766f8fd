// SPDX-License-Identifier: Apache-2.0
// What graphs make beside windows: files, pictures and names, with each new generation and without any window.
#include <filesystem>
#include <fstream>

#include "tests/multiserver/graph_client.h"

namespace gxy::test {
namespace {

using nlohmann::json;

const json kLine = madeBy("Seeds", "seeds", {{"domain", "ball"}}, {{"shape", "line"}, {"count", 6}});

json output(const std::string& type, const std::string& of, const std::string& to) {
  return {{"type", type}, {"of", of}, {"to", to}};
}

std::string graphWith(const json& datasets, const json& outputs, const json& views = json::array()) {
  return "graph.new g " +
         json{{"Datasets", datasets}, {"Visualizations", views}, {"Outputs", outputs}}.dump();
}

std::string contentOf(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// While a file of the generation before is written and the newest is held for the next, a third is refused. A publisher sends it again.
void importWhenThereIsRoom(GraphClient& c, const std::string& name) {
  until(
      [&] {
        const Reply reply = c.request(importBall(name));
        EXPECT_TRUE(reply.ok || reply.error.find("both its generations are in use") != std::string::npos)
            << reply.error;
        return reply.ok || ::testing::Test::HasFailure();
      },
      "room for a new generation");
}

bool lists(GraphClient& c, const std::string& name) {
  const json listed = c.say("list");
  for (const json& d : listed.at("datasets"))
    if (d.at("name") == name) return true;
  return false;
}

TEST(GraphOutputs, AFileIsWrittenOfEachGenerationWithoutAWindow) {
  for (const int ranks : {1, 3}) {
    const auto server = serveGraphs(ranks);
    const auto& folder = server->folder().path();
    GraphClient c(*server);
    c.say(graphWith(
        {liveVolume("ball"), kLine, copyOf("copy", "ball")},
        {output("Data file", "seeds", "seeds_{step}.vtp"), output("Data file", "copy", "copy.vti")}));
    EXPECT_EQ(c.state("copy.vti", "output"), "waiting");
    c.say(importBall("ball"));
    c.untilState("copy.vti", "done", "output");
    c.say("graph.wait g");
    EXPECT_EQ(c.state("seeds_{step}.vtp", "output"), "done");
    EXPECT_EQ(c.node("copy.vti", "output").at("file"), (folder / "copy.vti").string());
    c.say("make " + kLine.dump());
    c.say("export seeds expected.vtp");
    c.say("export ball expected.vti");
    EXPECT_EQ(contentOf(folder / "seeds_000001.vtp"), contentOf(folder / "expected.vtp"));
    EXPECT_FALSE(std::filesystem::exists(folder / "seeds_000002.vtp"));
    writeBall(folder.string(), "ball", 16, 2);
    c.say(importBall("ball"));
    until([&] { return std::filesystem::exists(folder / "seeds_000002.vtp"); }, "the file of generation 2");
    c.say("graph.wait g");
    EXPECT_EQ(contentOf(folder / "seeds_000002.vtp"), contentOf(folder / "expected.vtp"));
    EXPECT_NE(contentOf(folder / "copy.vti"), contentOf(folder / "expected.vti"));
    c.say("export ball expected.vti");
    const std::string written = contentOf(folder / "copy.vti"), expected = contentOf(folder / "expected.vti");
    EXPECT_EQ(written.substr(written.find("<AppendedData")), expected.substr(expected.find("<AppendedData")))
        << "but for the array's name";
  }
}

TEST(GraphOutputs, APictureIsThatOfTheViewToTheBit) {
  const auto server = serveGraphs(2);
  const auto& folder = server->folder().path();
  GraphClient c(*server);
  c.say(importBall("ball"));
  json view = viewOf("v", {"ball"});
  view["operators"].push_back({{"type", "Particles"}, {"dataset", "seeds"}, {"radius0", 0.1}});
  c.say(graphWith({liveVolume("ball"), kLine}, {output("Pictures", "v", "v.png")}, json::array({view})));
  c.untilState("v.png", "done", "output");
  c.say("make " + kLine.dump());
  json plain = view, camera = view.at("camera");
  camera["dimensions"] = view.at("size");
  for (const char* key : {"name", "camera", "size"}) plain.erase(key);
  c.say("batch " + json{{"state", {{"Visualization", plain}, {"Camera", camera}}}, {"prefix", "b"}}.dump());
  EXPECT_GT(contentOf(folder / "v.png").size(), 500u);
  EXPECT_EQ(contentOf(folder / "v.png"), contentOf(folder / "b_00000.png"));
}

TEST(GraphOutputs, APublishedNameMeansWhatTheNodeWasMadeLast) {
  const auto server = serveGraphs(2);
  GraphClient c(*server);
  c.say(importBall("ball"));
  c.say(graphWith({liveVolume("ball"), copyOf("copy", "ball")}, {output("Publish", "copy", "named")}));
  c.untilState("named", "done", "output");
  EXPECT_TRUE(lists(c, "named"));
  EXPECT_FALSE(lists(c, "g/copy"));
  const double first = c.say("range named").at("range").at(1);
  writeBall(server->folder().path().string(), "ball", 16, 2);
  c.say(importBall("ball"));
  until([&] { return c.say("range named").at("range").at(1) == 2 * first; }, "the name means the newer one");
  EXPECT_NE(c.error("drop named").find("graph"), std::string::npos);
  c.say("make " + madeBy("Seeds", "points", {{"domain", "named"}}).dump());  // it is data like others
  c.edit({{{"set", {"Outputs", 0, "to"}}, {"to", "other"}}});
  until([&] { return lists(c, "other"); }, "another name");
  EXPECT_FALSE(lists(c, "named"));
  c.say("graph.drop g");
  EXPECT_FALSE(lists(c, "other"));
  c.say("drop points");
  c.say("drop ball");
  for (int rank = 0; rank < 2; rank++) EXPECT_EQ(server->serverRank(rank).ledger.total("user"), 0) << rank;
}

TEST(GraphOutputs, AnEditOfAnOutputMakesItAnew) {
  const auto server = serveGraphs(2);
  const auto& folder = server->folder().path();
  GraphClient c(*server);
  c.say(importBall("ball"));
  json file = output("Data file", "seeds", "a.vti"), name = output("Publish", "copy", "a");
  file["name"] = "file";
  name["name"] = "name";
  c.say(graphWith({liveVolume("ball"), kLine, copyOf("copy", "ball")}, {file, name}));
  c.untilState("name", "done", "output");
  c.say("graph.wait g");
  EXPECT_EQ(c.state("file", "output"), "failed") << "a volume's ending";
  c.edit({{{"set", {"Outputs", "file", "to"}}, {"to", "a.vtp"}},
          {{"set", {"Outputs", "name", "to"}}, {"to", "b"}}});
  c.untilState("file", "done", "output");
  until([&] { return lists(c, "b"); }, "the other name");
  EXPECT_FALSE(lists(c, "a"));
  EXPECT_TRUE(std::filesystem::exists(folder / "a.vtp"));
  std::filesystem::remove(folder / "a.vtp");
  c.say("graph.run g");
  until([&] { return std::filesystem::exists(folder / "a.vtp"); }, "run makes it again");
  c.say("graph.wait g");
}

TEST(GraphOutputs, OfDataThatComeWhileOneIsMadeTheNewestAreMadeNext) {
  const auto server = serveGraphs(2);
  const auto& folder = server->folder().path();
  GraphClient c(*server);
  c.say(graphWith({liveVolume("ball")}, {output("Data file", "ball", "{step}.vti")}));
  constexpr int kSteps = 12;
  for (int step = 1; step <= kSteps; step++) {
    writeBall(folder.string(), "ball", 64, float(step));
    importWhenThereIsRoom(c, "ball");
  }
  until([&] { return std::filesystem::exists(folder / "000012.vti"); }, "the last is made");
  c.say("graph.wait g");
  c.say("export ball expected.vti");
  EXPECT_EQ(contentOf(folder / "000012.vti"), contentOf(folder / "expected.vti"));
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() != ".vti") continue;
    EXPECT_EQ(std::filesystem::file_size(entry), std::filesystem::file_size(folder / "expected.vti"))
        << entry.path() << " is complete";
  }
}

TEST(GraphOutputs, WhatCannotBeMadeIsTheOutputsErrorAndOthersGoOn) {
  const auto server = serveGraphs(2);
  GraphClient c(*server);
  c.say(importBall("ball"));
  c.say(importBall("taken"));
  c.say(graphWith({liveVolume("ball"), kLine, copyOf("copy", "ball", 13)},
                  {output("Data file", "seeds", "a.vti"), output("Data file", "seeds", "../a.vtp"),
                   output("Publish", "ball", "b"), output("Publish", "seeds", "taken"),
                   output("Data file", "copy", "copy.vti"), output("Data file", "seeds", "good.vtp")}));
  c.say("graph.wait g");
  const auto expectFailed = [&](const std::string& name, const std::string& part) {
    const json node = c.node(name, "output");
    EXPECT_EQ(node.at("state"), "failed") << node;
    EXPECT_NE(node.value("text", "").find(part), std::string::npos) << node;
  };
  expectFailed("a.vti", "which is Particles: expected a name that ends with one of .vtp, .vtu, .csv");
  expectFailed("../a.vtp", "cannot be written");
  expectFailed("b", "expected one that a filter of this graph makes");
  expectFailed("taken", "the name \"taken\" is in use");
  EXPECT_NE(c.state("copy.vti", "output"), "done");
  EXPECT_EQ(c.state("good.vtp", "output"), "done");
  EXPECT_EQ(c.say("info taken").at("datasets").at(0).at("type"), "Volume");
  const auto errorOf = [&](const json& outputs) {
    return c.error("graph.new h " + json{{"Datasets", {liveVolume("ball")}}, {"Outputs", outputs}}.dump());
  };
  EXPECT_NE(errorOf({output("Film", "ball", "a")}).find("expected Data file, Pictures or Publish"),
            std::string::npos);
  EXPECT_NE(errorOf({output("Pictures", "ball", "a.png")}).find("expected a view, found \"ball\""),
            std::string::npos);
  const auto withView = [&](const json& o) {
    return c.error("graph.new h " + json{{"Datasets", {liveVolume("ball")}},
                                         {"Visualizations", json::array({viewOf("v", {"ball"})})},
                                         {"Outputs", json::array({o})}}
                                        .dump());
  };
  EXPECT_NE(withView(output("Data file", "v", "a.vti")).find("expected a dataset, found \"v\""),
            std::string::npos);
  EXPECT_NE(errorOf({output("Publish", "seeds", "a/b")}).find("expected a name without /"),
            std::string::npos);
  EXPECT_NE(errorOf({output("Publish", "seeds", "ball")}).find("is what this graph reads"),
            std::string::npos);
  EXPECT_NE(errorOf({{{"type", "Publish"}, {"of", "ball"}}}).find("`to`"), std::string::npos);
  EXPECT_NE(errorOf({output("Data file", "ball", "a.vti"), output("Data file", "ball", "a.vti")})
                .find("two of this name"),
            std::string::npos);
}

TEST(GraphNumbers, AreKeptByGenerationUntilTheFilterIsAnother) {
  const auto server = serveGraphs(2);
  GraphClient c(*server);
  c.say("graph.new g " +
        json{{"Datasets",
              {liveVolume("ball"), madeBy("Number", "most", {{"b", "ball"}}, {{"expression", "max(b)"}})}}}
            .dump());
  EXPECT_EQ(c.say("graph.numbers g most").at("numbers"), json::array());
  std::vector<double> expected;
  for (int step = 1; step <= 4; step++) {
    writeBall(server->folder().path().string(), "ball", 16, float(step));
    c.say(importBall("ball"));
    expected.push_back(c.say("range ball").at("range").at(1));
    c.say("graph.run g");
    c.say("graph.wait g");
  }
  const json numbers = c.say("graph.numbers g most").at("numbers");
  ASSERT_EQ(numbers.size(), 4u);
  for (size_t i = 0; i < 4; i++) {
    EXPECT_EQ(numbers[i].at("value"), expected[i]);
    EXPECT_EQ(numbers[i].at("generation"), i + 1);
    EXPECT_EQ(numbers[i].at("step"), i + 1);
  }
  EXPECT_EQ(c.say("graph.numbers g most 3").at("numbers").size(), 2u);
  c.edit({{{"set", {"Datasets", "most", "expression"}}, {"to", "min(b)"}}});
  EXPECT_EQ(c.say("graph.numbers g most").at("numbers").size(), 0u);
  EXPECT_NE(c.error("graph.numbers g none").find("there is no dataset \"none\""), std::string::npos);
  EXPECT_NE(c.error("graph.numbers g most 0").find("a generation is an integer from 1 up"),
            std::string::npos);
}

TEST(GraphSharing, OthersLookAtAPublishedGraphAndChangeItOnlyIfTheyMay) {
  const auto server = serveGraphs(2);
  GraphClient owner(*server), other(*server, "other");
  owner.say(importBall("ball"));
  owner.say(newGraph({liveVolume("ball"), copyOf("copy", "ball")}, json::array({viewOf("v", {"copy"})})));
  EXPECT_NE(other.error("graph.get g").find("there is none"), std::string::npos);
  owner.say("graph.publish g");
  const json listed = other.say("graph.list").at("graphs").at(0);
  EXPECT_EQ(listed.at("owner"), "user");
  EXPECT_EQ(listed.at("scope"), "shared");
  EXPECT_EQ(listed.at("read only"), true);
  other.say(R"(viewer.show 1 {"graph": "g", "view": "v"})");
  other.untilState("v", "done", "view");
  EXPECT_EQ(other.screen.waitFor(1, other.say("render 1").at("frame")).status, "complete");
  for (const std::string verb : {"run g", "pause g", "resume g", "cancel g", "edit g {\"edits\": []}"})
    EXPECT_NE(other.error("graph." + verb).find("it belongs to user, who lets others look at it"),
              std::string::npos)
        << verb;
  EXPECT_NE(other.error("graph.drop g").find("there is none"), std::string::npos);
  EXPECT_NE(other.error("graph.publish g").find("there is none"), std::string::npos);
  owner.say("graph.publish g writable");
  other.edit({{{"set", {"Datasets", "copy", "number"}}, {"to", 3}}});
  owner.untilState("v", "done", "view");
  EXPECT_EQ(owner.node("copy").at("told").at("number"), 3);
  other.say("graph.new g");
  EXPECT_NE(other.error("graph.publish g").find("user has published one of this name"), std::string::npos);
  EXPECT_EQ(other.say("graph.get g").at("nodes").size(), 0u) << "one's own goes before";
  other.say("graph.drop g");
  owner.say("graph.unpublish g");
  EXPECT_NE(other.error("graph.get g").find("there is none"), std::string::npos);
  owner.say("graph.publish g");
  owner.say("graph.drop g");
  EXPECT_EQ(other.say("graph.list").at("graphs").size(), 0u);
}

}  // namespace
}  // namespace gxy::test

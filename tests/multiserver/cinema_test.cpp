// SPDX-License-Identifier: Apache-2.0
// Module viewer: databases of the pictures of a sweep.
#include <filesystem>
#include <fstream>
#include <future>
#include <iterator>

#include "core/comm/error.h"
#include "core/image/image.h"
#include "core/scene/check_cinema.h"
#include "core/scene/cinema_table.h"
#include "core/scene/state_file.h"
#include "core/scene/swept_pictures.h"
#include "tests/multiserver/viewer_client.h"

namespace gxy::test {
namespace {

using nlohmann::json;

std::string bytesOfFile(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

struct CinemaClient {
  explicit CinemaClient(const TestServer& server) : folder(server.folder().path()) {
    auto options = server.options();
    options.onEvent = [this](const json& event) { progress.take(event); };
    client = std::make_unique<Client>(options);
    client->expect("load data");
    client->expect("load viewer");
    client->expect(importBall("ball"));
  }
  static json documentOf(const json& axes, const std::string& to = "a.cdb") {
    return {{"state", json::parse(stateOf("ball"))}, {"sweep", {{"axes", axes}}}, {"to", to}};
  }
  json cinema(const json& document) { return client->expect("cinema " + document.dump()); }
  std::string error(const json& document) { return client->request("cinema " + document.dump()).error; }
  CinemaTable table(const std::string& name = "a.cdb") const {
    return CinemaTable::read(bytesOfFile(folder / name / "data.csv"), name);
  }
  void expectValid(const std::string& name = "a.cdb") const {
    const CinemaCheck check = checkCinema(folder / name);
    EXPECT_TRUE(check.problems.empty()) << check.problems.front();
  }

  const std::filesystem::path folder;
  Progress progress;
  std::unique_ptr<Client> client;
};

const json kAngles{{"axis", "phi"}, {"values", {0, 40}}};
const json kSurfaces{{"axis", "isovalue"}, {"values", {0.6, 0.9}}};

TEST(Cinema, EachPictureIsThatOfABatch) {
  const auto server = serve();
  CinemaClient c(*server);
  json document = CinemaClient::documentOf(
      {kAngles, kSurfaces, {{"axis", "key"}, {"path", "/Renderer/tolerance"}, {"values", {0.01, 0.1}}}});
  document["depth"] = true;
  const json reply = c.cinema(document);
  EXPECT_EQ(reply.at("pictures"), 8);
  EXPECT_EQ(reply.at("rows"), 8);
  c.expectValid();
  const CinemaTable table = c.table();
  EXPECT_EQ(table.columns(), (CinemaTable::Row{"phi", "isovalue", "tolerance", "FILE", "FILE_depth"}));
  const SweptPictures swept =
      sweptPictures(readSweep(document["sweep"].dump(), "sweep"), readState(stateOf("ball"), "state").state,
                    [](const std::string& text) { return readState(text, "state"); });
  for (size_t p = 0; p < 8; p++) {
    const SweptScene& scene = swept.scenes[swept.pictures[p].scene];
    const State one{{}, scene.settings, {scene.visualization}, {swept.pictures[p].camera}, scene.annotations,
                    {}};
    c.client->expect("batch " + json{{"state", json::parse(writeState(one))}, {"prefix", "one"}}.dump());
    const auto& row = table.rows()[p];
    EXPECT_EQ(bytesOfFile(c.folder / "a.cdb" / row[3]), bytesOfFile(c.folder / "one_00000.png")) << row[3];
    EXPECT_EQ(readImage((c.folder / "a.cdb" / row[4]).string()).width, 96) << row[4];
  }
  EXPECT_NE(bytesOfFile(c.folder / "a.cdb/index.html").find("0.0_0.6_0.01.png"), std::string::npos);
}

TEST(Cinema, IsEstimatedBeforeItIsMade) {
  const auto server = serve();
  CinemaClient c(*server);
  json document = CinemaClient::documentOf({kAngles, kSurfaces});
  document["estimate"] = true;
  const json reply = c.cinema(document);
  EXPECT_EQ(reply.at("pictures"), 4);
  EXPECT_EQ(reply.at("scenes"), 2);
  EXPECT_EQ(reply.at("columns"), (json{"phi", "isovalue"}));
  EXPECT_FALSE(std::filesystem::exists(c.folder / "a.cdb"));
}

TEST(Cinema, TellsItsProgress) {
  const auto server = serve();
  CinemaClient c(*server);
  std::promise<Reply> ended;
  const uint32_t id = c.client->send("cinema " + CinemaClient::documentOf({kAngles, kSurfaces}).dump(),
                                     [&](const Reply& r) { ended.set_value(r); });
  const std::vector<json> events = c.progress.waitFor(id);
  EXPECT_EQ(events.back().at("of"), 4);
  EXPECT_EQ(events.back().at("done"), 4);
  EXPECT_TRUE(ended.get_future().get().ok);
}

TEST(Cinema, GrowsWithEachGeneration) {
  const auto server = serve();
  writeBall(server->folder().path().string(), "twice", 16, 2);
  CinemaClient c(*server);
  const json document = CinemaClient::documentOf({{{"axis", "time"}}, kAngles});
  c.cinema(document);
  c.expectValid();
  EXPECT_EQ(c.table().rows(), (std::vector<CinemaTable::Row>{{"1.0", "0.0", "time=1.0/0.0.png"},
                                                             {"1.0", "40.0", "time=1.0/40.0.png"}}));
  c.client->expect(importBall("ball", "twice.vol"));
  EXPECT_EQ(c.cinema(document).at("rows"), 4);
  c.expectValid();
  EXPECT_EQ(c.table().rows()[2], (CinemaTable::Row{"2.0", "0.0", "time=2.0/0.0.png"}));
  EXPECT_NE(bytesOfFile(c.folder / "a.cdb/time=2.0/0.0.png"),
            bytesOfFile(c.folder / "a.cdb/time=1.0/0.0.png"));
  EXPECT_EQ(c.cinema(document).at("rows"), 4) << "the same generation again";
}

TEST(Cinema, WaitsForMoreStepsUntilThereAreEnough) {
  const auto server = serve();
  writeBall(server->folder().path().string(), "twice", 16, 2);
  CinemaClient c(*server);
  json document = CinemaClient::documentOf({{{"axis", "time"}}, kAngles});
  for (const bool cancels : {false, true}) {
    document["to"] = cancels ? "cancelled.cdb" : "whole.cdb";
    document["steps"] = cancels ? 100 : 2;
    std::promise<Reply> ended;
    auto reply = ended.get_future();
    const uint32_t id =
        c.client->send("cinema " + document.dump(), [&](const Reply& r) { ended.set_value(r); });
    const std::string name = document["to"];
    until([&] { return std::filesystem::exists(c.folder / name / "data.csv"); }, "the first step");
    EXPECT_EQ(c.table(name).rows().size(), 2u);
    c.client->expect(importBall("other", "twice.vol"));
    c.client->expect(importBall("ball", "twice.vol"));
    until([&] { return c.table(name).rows().size() == 4; }, "the second step");
    if (cancels) c.client->expect("cancel " + std::to_string(id));
    const Reply end = reply.get();
    EXPECT_EQ(end.ok, !cancels) << end.error;
    if (cancels) {
      EXPECT_EQ(end.error, "cancelled");
    }
    c.expectValid(name);
    EXPECT_EQ(c.table(name).rows().size(), 4u);
  }
}

TEST(Cinema, AllScenesShowTheDataOfOneMoment) {
  const auto server = serve();
  writeBall(server->folder().path().string(), "twice", 16, 2);
  CinemaClient c(*server);
  json document = CinemaClient::documentOf(
      {{{"axis", "time"}}, {{"axis", "key"}, {"path", "/Renderer/rays per pixel"}, {"values", {128, 1}}}});
  document["concurrent"] = 1;
  std::promise<Reply> ended;
  auto reply = ended.get_future();
  c.client->send("cinema " + document.dump(), [&](const Reply& r) { ended.set_value(r); });
  const auto frames = [&] { return c.client->expect("stat").at("ranks").at(0).at("frames"); };
  until([&] { return frames() == 1; }, "the first picture, which takes a while");
  c.client->expect(importBall("ball", "twice.vol"));
  const Reply end = reply.get();
  EXPECT_TRUE(end.ok) << end.error;
  c.expectValid();
  EXPECT_EQ(c.table().rows(), (std::vector<CinemaTable::Row>{{"1.0", "128.0", "time=1.0/128.0.png"},
                                                             {"1.0", "1.0", "time=1.0/1.0.png"}}));
  EXPECT_EQ(c.cinema(document).at("rows"), 4) << "of the newer data";
}

TEST(Cinema, ThatIsCancelledLeavesWhatIsDone) {
  const auto server = serve();
  CinemaClient c(*server);
  json document = CinemaClient::documentOf(
      {{{"axis", "key"}, {"path", "/Renderer/rays per pixel"}, {"values", {1, 65536}}}});
  document["concurrent"] = 1;
  std::promise<Reply> ended;
  auto reply = ended.get_future();
  const uint32_t id =
      c.client->send("cinema " + document.dump(), [&](const Reply& r) { ended.set_value(r); });
  until([&] { return std::filesystem::exists(c.folder / "a.cdb/pictures/1.0.png"); }, "the first picture");
  const auto frames = [&] { return c.client->expect("stat").at("ranks").at(0).at("frames"); };
  until([&] { return frames() == 1; }, "the second one, which would take minutes");
  c.client->expect("cancel " + std::to_string(id));
  EXPECT_EQ(reply.get().error, "cancelled");
  c.expectValid();
  EXPECT_EQ(c.table().rows(), (std::vector<CinemaTable::Row>{{"1.0", "pictures/1.0.png"}}));
}

TEST(Cinema, WrongRequestsSayWhatWasExpected) {
  const auto server = serve();
  CinemaClient c(*server);
  const auto expect = [&](const char* key, const json& value, const std::string& why) {
    json document = CinemaClient::documentOf(json::array({kAngles}));
    document[key] = value;
    const std::string said = c.error(document);
    EXPECT_NE(said.find(why), std::string::npos) << said;
  };
  expect("state", 5, "cinema: `state`: expected a state document");
  expect("sweep", 5, "cinema: `sweep`: expected a sweep");
  const auto expectAxis = [&](const json& axis, const std::string& why) {
    expect("sweep", {{"axes", json::array({axis})}}, why);
  };
  expectAxis({{"axis", "phi"}}, "sweep:1:10: axis without `values`");
  expectAxis({{"axis", "isovalue"}, {"operator", 1}, {"values", {1, 2}}},
             "`operator`: there is no operator 1");
  expectAxis({{"axis", "phi"}, {"from", 0}, {"to", 1}, {"count", 10001}}, "expected an integer 2 to 10000");
  expect("to", "", "cinema: `to`: expected the name of a database");
  expect("to", "../a.cdb", "it cannot be made");
  expect("to", "/tmp/a.cdb", "it cannot be made");
  expect("to", "none/a.cdb", "it cannot be made");
  expect("format", "raw", "`format`: expected \"png\" or \"exr\"");
  expect("depth", 1, "`depth`: expected true or false");
  expect("steps", 0, "`steps`: expected an integer from 1 to 1000000");
  expect("steps", 2, "`steps`: expected 1, or an axis \"time\"");
  expect("concurrent", 65, "`concurrent`: expected an integer from 1 to 64");
  expect("prefix", "a", "keys that mean nothing here");
  json none = CinemaClient::documentOf(json::array({kAngles}));
  none["state"] = json::parse(stateOf("nothing"));
  EXPECT_NE(c.error(none).find("nothing"), std::string::npos);
  json data =
      CinemaClient::documentOf({{{"axis", "key"}, {"path", "/Datasets/0/array"}, {"values", {"a", "b"}}}});
  data["state"]["Datasets"] = {{"name", "ball"}, {"type", "Volume"}, {"filename", "ball.vol"}};
  EXPECT_NE(c.error(data).find("varies keys of `Datasets`"), std::string::npos);
  data["sweep"]["axes"][0]["values"] = {"a"};
  EXPECT_NE(c.error(data).find("varies keys of `Datasets`"), std::string::npos);
  data["sweep"]["axes"] = json::array({kSurfaces});
  data["to"] = "data.cdb";
  EXPECT_EQ(c.cinema(data).at("rows"), 2) << "other sweeps may have `Datasets`";
  c.cinema(CinemaClient::documentOf(json::array({kAngles})));
  EXPECT_NE(c.error(CinemaClient::documentOf(json::array({kSurfaces})))
                .find("its columns are phi, FILE, expected isovalue, FILE"),
            std::string::npos);
  const auto labelled = [](const std::string& name, const std::string& label) {
    return json{{"axis", "key"},
                {"path", "/Renderer/tolerance"},
                {"name", name},
                {"values", {0.5}},
                {"labels", {label}}};
  };
  EXPECT_NE(c.error(CinemaClient::documentOf(json::array({labelled("phi", "low")})))
                .find("a.cdb/data.csv: column \"phi\": \"low\" is a text, expected a number with a point"),
            std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(c.folder / "a.cdb/pictures/low.png")) << "nothing was rendered";
  json longest = CinemaClient::documentOf(
      {labelled("name", std::string(64, '_')), {{"axis", "phi"}, {"values", {0.12345}}}}, "longest.cdb");
  longest["depth"] = true;
  EXPECT_EQ(c.cinema(longest).at("rows"), 1) << "the longest name that is allowed";
  std::filesystem::create_symlink("/tmp", c.folder / "link.cdb");
  expect("to", "link", "it is there and not a folder");
  c.expectValid();
}

TEST(Cinema, WhatItKeepsIsCharged) {
  ServerSetup setup;
  setup.ranks = 1;
  setup.modules = GALAXY_MODULES;
  setup.serverRank.tenantMemory = 16 << 20;
  const TestServer server(std::move(setup));
  CinemaClient c(server);
  // Each scene has a text of 100 kB, which an axis writes into a state without any.
  json document =
      CinemaClient::documentOf({{{"axis", "isovalue"}, {"from", 0.1}, {"to", 0.9}, {"count", 200}},
                                {{"axis", "key"},
                                 {"path", "/Annotations/text"},
                                 {"values", {std::string(100000, 'a')}},
                                 {"labels", {"long"}}}});
  const std::string said = c.error(document);
  EXPECT_NE(said.find("memory: "), std::string::npos) << said;
  EXPECT_FALSE(std::filesystem::exists(c.folder / "a.cdb")) << "nothing was begun";
  // A table of one MiB, which takes more to read.
  document = CinemaClient::documentOf(json::array({kAngles}));
  std::filesystem::create_directory(c.folder / "a.cdb");
  std::ofstream(c.folder / "a.cdb/data.csv") << "phi,FILE\n" << std::string(1 << 20, '\n');
  EXPECT_TRUE(c.error(document).starts_with("memory: ")) << c.error(document);
  EXPECT_FALSE(std::filesystem::exists(c.folder / "a.cdb/pictures"));
}

}  // namespace
}  // namespace gxy::test

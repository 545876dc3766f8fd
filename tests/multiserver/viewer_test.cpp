// SPDX-License-Identifier: Apache-2.0
// Module viewer: the pictures that clients get.
#include <atomic>
#include <filesystem>
#include <fstream>
#include <future>
#include <set>

#include "core/comm/error.h"
#include "core/image/image.h"
#include "tests/multiserver/viewer_client.h"

namespace gxy::test {
namespace {

using nlohmann::json;

std::vector<uint8_t> flippedRows(const std::vector<uint8_t>& rgba, size_t width) {
  std::vector<uint8_t> out;
  for (size_t row = rgba.size() / (4 * width); row-- > 0;)
    out.insert(out.end(), rgba.begin() + std::ptrdiff_t(row * width * 4),
               rgba.begin() + std::ptrdiff_t((row + 1) * width * 4));
  return out;
}

TEST(ViewerModule, AFrameIsTheSameToTheBitForAnyNumberOfRanksAndInABatch) {
  std::vector<uint8_t> expected;
  for (const int ranks : {1, 2, 4}) {
    const auto server = serve(ranks);
    Viewer viewer(*server);
    const Screen::Picture picture = viewer.frame();
    EXPECT_EQ(picture.covered, 96u * 80u);
    if (expected.empty()) expected = picture.rgba;
    EXPECT_EQ(picture.rgba, expected) << ranks;
    viewer.client->expect(R"(batch {"prefix": "out", "state": )" + stateOf("ball") + "}");
    const Image file = readImage(server->folder() / "out_00000.png");
    std::vector<uint8_t> levels = eightBits(file.rgba);
    EXPECT_EQ(levels, expected) << "the file of a batch on " << ranks;
    EXPECT_EQ(viewer.screen.error(), "");
  }
  EXPECT_GT(std::set<uint8_t>(expected.begin(), expected.end()).size(), 50u) << "there is something to see";
  EXPECT_NE(flippedRows(expected, 96), expected) << "and up is not down";
}

std::string property(const std::string& name, const std::string& z) {
  return "<Property name=\"" + name + R"("><Element value="0"/><Element value="1"/><Element value=")" + z +
         "\"/></Property>";
}

TEST(ViewerModule, PresetsAndCameraFilesAreThoseOfTheDataFolders) {
  const auto server = serve();
  const TemporaryFolder outside;
  const auto write = [](const std::filesystem::path& folder) {
    std::ofstream(folder / "preset.json") << R"([{"RGBPoints": [0, 0.25, 0, 0, 1, 0.5, 1, 1]}])";
    std::ofstream(folder / "camera.pvcc")
        << "<PVCameraConfiguration>" << property("CameraPosition", "4") << property("CameraFocalPoint", "0")
        << property("CameraViewUp", "0") << "</PVCameraConfiguration>";
  };
  std::filesystem::create_directory(server->folder() / "sub");
  write(server->folder() / "sub");
  write(outside.path());
  std::filesystem::create_directory_symlink(outside.path(), server->folder() / "link");
  Viewer viewer(*server);
  const std::string operators = R"({"Visualization": {"operators": [{"type": "Volume", "dataset": "ball",
    "volume rendering": true, "colormap": "FILE"}]}, "Camera": {"dimensions": [8, 8]}})";
  const std::string cameras =
      stateOf("ball").substr(0, stateOf("ball").rfind("\"Camera\"")) + R"("Camera": "FILE"})";
  struct Case {
    std::string statement, file;
  };
  const std::vector<Case> cases{{"set 1 " + operators, "preset.json"},
                                {"batch {\"state\": " + operators + "}", "preset.json"},
                                {R"(set 1 {"Camera": "FILE"})", "camera.pvcc"},
                                {R"(render 1 {"Camera": "FILE"})", "camera.pvcc"},
                                {"batch {\"state\": " + cameras + "}", "camera.pvcc"},
                                {R"(import {"Camera": "FILE"})", "camera.pvcc"}};
  const std::string up = "../" + outside.path().filename().string() + "/";
  for (const Case& c : cases) {
    const auto statement = [&](const std::string& name) {
      std::string text = c.statement;
      return text.replace(text.find("FILE"), 4, name);
    };
    for (const std::string& name :
         {outside.path().string() + "/" + c.file, up + c.file, "link/" + c.file, std::string("/etc/passwd"),
          std::string("/nowhere/" + c.file), "no" + c.file}) {
      const std::string error = viewer.client->request(statement(name)).error;
      const std::string reason =
          "\"" + name + "\": there is no such file that may be read, expected a file in ";
      EXPECT_NE(error.find(reason.substr(name.size() > 60 ? 62 : 0)), std::string::npos) << error;
    }
    const Reply inside = viewer.client->request(statement("sub/" + c.file));
    if (c.statement.starts_with("import"))
      EXPECT_NE(inside.error.find("expected `Datasets` only"), std::string::npos) << inside.error;
    else
      EXPECT_TRUE(inside.ok) << c.statement << ": " << inside.error;
  }
  const json state = viewer.client->expect("state 1").at("state");
  EXPECT_EQ(state.at("Visualizations").at(0).at("operators").at(0).at("colormap").at(0),
            (json{0.0, 0.25, 0.0, 0.0}));
}

TEST(ViewerModule, CoarseLevelsComeFirstAndCoverThePicture) {
  const auto server = serve();
  Viewer viewer(*server);
  viewer.frame(R"({"levels": [8, 3, 1]})");
  EXPECT_EQ(viewer.screen.picture(1, 8).covered, 12u * 10u);
  EXPECT_EQ(viewer.screen.picture(1, 3).covered, 32u * 27u);
  EXPECT_EQ(viewer.screen.picture(1, 1).covered, 96u * 80u);
}

TEST(ViewerModule, EncodingsAgreeAndJpegIsNear) {
  const auto server = serve();
  Viewer viewer(*server);
  const auto zstd = viewer.frame(R"({"encoding": "zstd", "levels": [1]})");
  const auto raw = viewer.frame(R"({"encoding": "raw", "levels": [1]})");
  EXPECT_EQ(viewer.frame(R"({"encoding": "zlib", "levels": [1]})").rgba, raw.rgba);
  const auto jpeg = viewer.frame(R"({"encoding": "jpeg", "quality": 95, "levels": [1]})");
  EXPECT_EQ(zstd.rgba, raw.rgba);
  double sum = 0;
  for (size_t i = 0; i < raw.rgba.size(); i++) sum += std::abs(int(raw.rgba[i]) - int(jpeg.rgba[i]));
  EXPECT_LT(sum / double(raw.rgba.size()), 4) << "mean difference in 255ths";
}

TEST(ViewerModule, TilesHaveTheSizeThatIsAskedForAndTheSamePixels) {
  const auto server = serve();
  Viewer viewer(*server);
  std::mutex mutex;
  std::map<std::pair<uint32_t, uint32_t>, int> sizes;  // how many tiles have it
  auto options = server->options();
  Screen screen;
  options.onPixels = [&](const auto& header, auto data) {
    {
      const std::lock_guard lock(mutex);
      if (header.kind == protocol::PixelKind::Tile) sizes[{header.w, header.h}]++;
    }
    screen.take(header, data);
  };
  Client client(options);
  client.expect("load viewer");
  client.expect("window 1 {\"size\": [1100, 300]}");
  client.expect("set 1 " + stateOf("ball"));
  const auto picture = [&](const std::string& tile) {
    sizes.clear();
    const uint64_t frame = client.expect("render 1 {\"levels\": [1], \"passes\": 2" + tile + "}").at("frame");
    EXPECT_EQ(screen.waitFor(1, frame).status, "complete");
    EXPECT_EQ(screen.error(), "");
    return screen.picture(1).rgba;
  };
  const auto usual = picture("");
  using Sizes = std::map<std::pair<uint32_t, uint32_t>, int>;
  EXPECT_EQ(sizes, (Sizes{{{256, 256}, 8}, {{76, 256}, 2}, {{256, 44}, 8}, {{76, 44}, 2}}));
  EXPECT_TRUE(picture(", \"tile\": 1024, \"encoding\": \"raw\"") == usual);
  EXPECT_EQ(sizes, (Sizes{{{1024, 300}, 2}, {{76, 300}, 2}}));
  EXPECT_TRUE(picture(", \"tile\": 64") == usual);
  EXPECT_EQ(sizes.size(), 4u);
  EXPECT_EQ((sizes[{64, 64}]), 2 * 17 * 4);
  for (const char* wrong : {"63", "1025", "0", "\"64\"", "100.5"})
    EXPECT_NE(client.request(std::string("render 1 {\"tile\": ") + wrong + "}").error.find("from 64 to 1024"),
              std::string::npos)
        << wrong;
}

TEST(ViewerModule, PassesAddUpToAPictureOfAllTheirRaysToTheBit) {
  const auto server = serve(3);
  Viewer viewer(*server);
  viewer.client->expect(R"(set 1 {"Renderer": {"rays per pixel": 6, "background": [0.1, 0.2, 0.3, 0.5]}})");
  const auto whole = viewer.frame(R"({"levels": [1]})");
  const auto one = viewer.frame(R"({"levels": [1], "rays": 1})");
  EXPECT_NE(one.rgba, whole.rgba);
  for (const auto& [rays, passes] : {std::pair{1, 6}, {2, 3}, {3, 2}}) {
    const uint64_t frame = viewer.render(json{{"levels", {1}}, {"rays", rays}, {"passes", passes}}.dump());
    const auto end = viewer.screen.waitFor(1, frame);
    EXPECT_EQ(end.json.at("passes"), passes);
    const auto picture = viewer.screen.picture(1);
    EXPECT_EQ(picture.pass, uint32_t(passes - 1));
    EXPECT_EQ(picture.rgba, whole.rgba) << passes;
  }
}

TEST(ViewerModule, ANewerFrameSupersedesAndEachFrameEndsOnce) {
  const auto server = serve();
  Viewer viewer(*server);
  std::vector<uint64_t> frames;
  for (int i = 0; i < 20; i++) {
    const std::string x = std::to_string(3 - 0.05 * i);
    frames.push_back(
        viewer.render(R"({"Camera": {"viewpoint": [)" + x + R"(, 2, 4], "viewcenter": [0, 0, 0]}})"));
  }
  EXPECT_EQ(viewer.screen.waitFor(1, frames.back()).status, "complete");
  for (const uint64_t frame : frames) {
    const std::string status = viewer.screen.waitFor(1, frame).status;
    EXPECT_TRUE(status == "superseded" || status == "complete") << status;
  }
  viewer.client->expect("windows");
  for (const uint64_t frame : frames) EXPECT_EQ(viewer.screen.ends(1, frame), 1);
  EXPECT_EQ(viewer.screen.picture(1).frame, frames.back());
}

// The first is rendered and sent while the others come; each of those takes the place of the one that waits.
TEST(ViewerModule, FramesThatWaitLeaveTheOneUnderWayItsFirstPassAndTheNewestIsMade) {
  const auto server = serve();
  Viewer viewer(*server);
  viewer.client->expect("window 1 {\"size\": [800, 600]}");
  viewer.frame(R"({"levels": [1]})");
  std::vector<uint64_t> frames;
  for (int i = 0; i < 30; i++) {
    const json camera{{"viewpoint", {3 - 0.05 * i, 2, 4}}, {"viewcenter", {0, 0, 0}}};
    frames.push_back(viewer.render(json{{"levels", {1}}, {"wait", i > 0}, {"Camera", camera}}.dump()));
  }
  EXPECT_EQ(viewer.screen.waitFor(1, frames.front()).status, "complete");
  EXPECT_EQ(viewer.screen.waitFor(1, frames.back()).status, "complete");
  int complete = 0;
  for (const uint64_t frame : frames) {
    const std::string status = viewer.screen.waitFor(1, frame).status;
    EXPECT_TRUE(status == "superseded" || status == "complete") << status;
    EXPECT_EQ(viewer.screen.ends(1, frame), 1);
    complete += status == "complete";
  }
  EXPECT_LT(complete, 30) << "requests came faster than pictures of 800 x 600 are made";
  EXPECT_EQ(viewer.screen.picture(1).covered, 800u * 600u);
  EXPECT_EQ(viewer.screen.picture(1).frame, frames.back());
}

TEST(ViewerModule, AFrameThatWaitsIsCancelledWithTheOneBeforeIt) {
  const auto server = serve();
  Viewer viewer(*server);
  viewer.client->expect("window 1 {\"size\": [800, 600]}");
  const uint64_t first = viewer.render(R"({"levels": [1], "rays": 64})");
  const uint64_t second = viewer.render(R"({"levels": [1], "wait": true})");
  viewer.client->expect("cancel_frame 1");
  EXPECT_EQ(viewer.screen.waitFor(1, first).status, "cancelled");
  EXPECT_EQ(viewer.screen.waitFor(1, second).status, "cancelled");
  viewer.frame();
}

TEST(ViewerModule, SessionsThatSetOneStateAtOnceImportItOnceAndAllSeeIt) {
  const auto server = serve();
  json state = json::parse(stateOf("ball"));
  state["Datasets"] = {{{"name", "ball"}, {"filename", "ball.vol"}, {"type", "Volume"}}};
  std::vector<std::unique_ptr<Client>> clients;
  for (int i = 0; i < 4; i++) {
    clients.push_back(server->client());
    clients.back()->expect("load data");
    clients.back()->expect("load viewer");
    clients.back()->expect("window 1 {\"size\": [8, 8]}");
  }
  for (int round = 0; round < 5; round++) {
    std::vector<std::future<Reply>> replies;
    for (auto& client : clients)
      for (const std::string& statement : {"set 1 " + state.dump(), std::string("render 1")}) {
        auto promise = std::make_shared<std::promise<Reply>>();
        replies.push_back(promise->get_future());
        client->send(statement, [promise](const Reply& r) { promise->set_value(r); });
      }
    for (auto& reply : replies) {
      const Reply r = reply.get();
      EXPECT_TRUE(r.ok) << r.error;
    }
    EXPECT_EQ(clients[0]->expect("list").at("datasets").at(0).at("generation"), 1);
    clients[0]->expect("drop ball");
  }
}

TEST(ViewerModule, FramesFollowANameThatIsReplacedMeanwhile) {
  const auto server = serve();
  Viewer viewer(*server);
  const auto other = server->client();
  other->expect("load data");
  std::atomic<bool> done = false;
  const std::jthread publisher([&] {
    for (int n = 0; n < 30; n++) {
      const Reply r = other->request(importBall("ball"));
      EXPECT_TRUE(r.ok || r.error.find("left out") != std::string::npos) << r.error;
    }
    done = true;
  });
  do {
    const Reply r = viewer.client->request("render 1");
    ASSERT_TRUE(r.ok) << r.error;
    EXPECT_EQ(viewer.screen.waitFor(1, r.value.at("frame")).status, "complete");
  } while (!done);
}

TEST(ViewerModule, ACancelledFrameSaysSo) {
  const auto server = serve();
  Viewer viewer(*server);
  const uint64_t frame = viewer.render(R"({"passes": 4096})");
  viewer.client->expect("cancel_frame 1");
  EXPECT_EQ(viewer.screen.waitFor(1, frame).status, "cancelled");
  viewer.frame();
  viewer.client->expect("close 1");
  EXPECT_FALSE(viewer.client->request("render 1").ok);
}

TEST(ViewerModule, TwoVisualizationsOfOneDatasetDoNotSeeEachOther) {
  const auto server = serve();
  Viewer a(*server), b(*server);
  const auto before = a.frame().rgba;
  b.client->expect(R"(set 1 {"Visualization": {"operators": [{"type": "Volume", "dataset": "ball",
      "isovalues": [0.3], "colormap": "Inferno"}]}})");
  EXPECT_NE(b.frame().rgba, before);
  EXPECT_EQ(a.frame().rgba, before);
}

TEST(ViewerModule, ScenesAreSharedAndGoWithTheirWindows) {
  const auto server = serve();
  {
    Viewer a(*server), b(*server);
    EXPECT_EQ(a.frame().rgba, b.frame().rgba);
    EXPECT_GT(server->serverRank().ledger.total("user"), 0);
    a.client->expect("close 1");
    b.client->expect("close 1");
    a.client->expect("drop ball");
  }
  server->stop();
}

TEST(ViewerModule, FramesOfAClientThatHasGoneEndAlsoBeforeItsRequestsDo) {
  const auto server = serve();
  auto viewer = std::make_unique<Viewer>(*server, "ann");
  const auto other = server->client("bob");
  std::promise<void> stored, goOn;
  const auto subscription = server->serverRank(1).observers.subscribe({}, [&](const ObjectEvent& event) {
    if (event.kind != ObjectEvent::Kind::Added) return;
    stored.set_value();
    goOn.get_future().wait();
  });
  viewer->client->expect("window 1 {\"size\": [1024, 1024]}");
  viewer->render(R"({"passes": 4096, "rays": 16, "levels": [1]})");  // it would take hours
  viewer->client->send(importBall("late"), [](const Reply&) {});
  stored.get_future().wait();
  viewer = nullptr;
  until([&] { return other->expect("stat").at("tenants").at(0).at("frames in flight") == 0; },
        "its frame ends");
  EXPECT_EQ(server->server().clients(), 2u) << "its session goes on";
  goOn.set_value();
  until([&] { return server->server().clients() == 1; }, "its session ends");
}

/// What the ledgers of all ranks have had of a tenant for a purpose, at most.
int64_t peakOf(TestServer& server, const std::string& tenant, const std::string& purpose) {
  int64_t bytes = 0;
  for (int rank = 0; rank < 2; rank++)
    for (const Ledger::Line& line : server.serverRank(rank).ledger.peaks())
      if (line.tenant == tenant && line.purpose == purpose) bytes += line.bytes;
  return bytes;
}

TEST(ViewerModule, ASceneOfSharedDataTakesMemoryOfEachTenantThatShowsIt) {
  const auto server = serve();
  Viewer ann(*server, "ann");
  const std::vector<uint8_t> picture = ann.frame().rgba;
  ann.client->expect("publish ball");
  Viewer bob(*server, "bob");
  EXPECT_EQ(bob.frame().rgba, picture);
  EXPECT_GT(peakOf(*server, "ann", "scene"), 0);
  EXPECT_EQ(peakOf(*server, "bob", "scene"), peakOf(*server, "ann", "scene"));
}

TEST(ViewerModule, RaysOfAFrameAreCountedAsThoseOfItsTenant) {
  const auto server = serve();
  Viewer ann(*server, "ann"), bob(*server, "bob");
  ann.render(R"({"passes": 4096, "rays": 4, "levels": [1]})");
  std::set<std::string> tenants;
  until(
      [&] {
        const json stat = bob.client->expect("stat");
        for (const json& rank : stat.at("ranks"))
          for (const json& line : rank.at("rays").at("by tenant"))
            if (line.at("in flight") > 0) tenants.insert(line.at("tenant"));
        return !tenants.empty();
      },
      "rays in flight");
  EXPECT_EQ(tenants, std::set<std::string>{"ann"});
  ann.client->expect("cancel_frame 1");
}

TEST(ViewerModule, ABatchTakesMemoryOfItsTenant) {
  const auto server = serve();
  const auto client = server->client("ann");
  client->expect("load data");
  client->expect("load viewer");
  client->expect(importBall("ball"));
  client->expect("batch {\"state\": " + stateOf("ball") + "}");
  EXPECT_EQ(peakOf(*server, "ann", "framebuffer"), 96 * 80 * 32);
}

TEST(ViewerModule, AFrameHasAtMost65536RaysOfAllItsPassesAndAPictureOfABatchAsManyPixelsAsAWindow) {
  const auto server = serve();
  Viewer viewer(*server);
  viewer.client->expect("window 1 {\"size\": [2, 2]}");
  const auto frame = viewer.render(R"({"rays": 4096, "passes": 16, "levels": [1]})");
  viewer.client->expect("cancel_frame 1");  // it is taken, and would take long
  const auto end = viewer.screen.waitFor(1, frame);
  EXPECT_NE(end.status, "failed") << end.json;
  EXPECT_NE(viewer.client->request(R"(render 1 {"rays": 4096, "passes": 17})").error.find("65536 rays"),
            std::string::npos);
  json state = json::parse(stateOf("ball"));
  state["Camera"]["dimensions"] = {7681, 4320};
  EXPECT_EQ(viewer.client->request("batch " + json{{"state", state}}.dump()).error,
            "batch: a picture of 33181920 pixels, expected at most 33177600");
}

TEST(ViewerModule, ABatchThatIsCancelledEndsThePictureUnderWay) {
  const auto server = serve();
  std::promise<Reply> ended;
  Viewer viewer(*server);
  json state = json::parse(stateOf("ball"));
  state["Renderer"] = {{"rays per pixel", 65536}};  // it would take minutes
  auto reply = ended.get_future();
  const uint32_t id = viewer.client->send("batch " + json{{"state", state}}.dump(),
                                          [&](const Reply& r) { ended.set_value(r); });
  const auto frames = [&] { return viewer.client->expect("stat").at("ranks").at(0).at("frames"); };
  until([&] { return frames() == 1; }, "it is rendered");
  viewer.client->expect("cancel " + std::to_string(id));
  ASSERT_EQ(reply.wait_for(std::chrono::minutes(1)), std::future_status::ready);
  EXPECT_EQ(reply.get().error, "cancelled");
  until([&] { return frames() == 0; }, "nothing is rendered");
}

TEST(ViewerModule, ABatchSendsItsPicturesBackOrIsCancelled) {
  const auto server = serve();
  auto options = server->options();
  std::map<std::string, size_t> files;
  options.onFile = [&](uint32_t, const json& header, std::span<const std::byte> content) {
    files[header.at("name")] = content.size();
  };
  Client client(options);
  client.expect("load data");
  client.expect("load viewer");
  client.expect(importBall("ball"));
  json state = json::parse(stateOf("ball"));
  json camera = state["Camera"];
  state.erase("Camera");
  for (int i = 0; i < 5; i++) {
    camera["viewpoint"][0] = 3 - i;
    state["Cameras"].push_back(camera);
  }
  const json reply =
      client.expect("batch " + json{{"state", state}, {"to", "client"}, {"format", "raw"}}.dump());
  EXPECT_EQ(reply.at("pictures").size(), 5u);
  EXPECT_EQ(files.size(), 5u) << "all come before the reply";
  for (const auto& [name, size] : files) EXPECT_EQ(size, 96u * 80 * 16) << name;

  for (int i = 0; i < 45; i++) state["Cameras"].push_back(camera);
  std::promise<Reply> ended;
  const uint32_t id = client.send("batch " + json{{"state", state}, {"prefix", "many"}}.dump(),
                                  [&](const Reply& r) { ended.set_value(r); });
  client.expect("cancel " + std::to_string(id));
  EXPECT_EQ(ended.get_future().get().error, "cancelled");
  const Reply outside = client.request("batch " + json{{"state", state}, {"prefix", "../escaped"}}.dump());
  EXPECT_FALSE(outside.ok);
}

TEST(ViewerModule, WindowsOfManyPassesLeaveABatchOfOthersItsTurn) {
  const auto server = serve();
  Viewer viewer(*server, "looks");
  for (int id = 1; id <= 16; id++) {
    const std::string window = std::to_string(id);
    viewer.client->expect("window " + window + " {\"size\": [96, 80]}");
    viewer.client->expect("set " + window + " " + stateOf("ball"));
    viewer.client->expect("render " + window + R"( {"passes": 4096, "rays": 4, "levels": [1]})");
  }
  const auto batch = server->client("batch");
  batch->expect("load data");
  batch->expect("load viewer");
  batch->expect(importBall("ball"));
  batch->expect("batch {\"prefix\": \"turn\", \"state\": " + stateOf("ball") + "}");
  for (uint32_t id = 1; id <= 16; id++) {
    EXPECT_EQ(viewer.screen.ends(id, 1), 0) << "they are still at it";
    viewer.client->expect("cancel_frame " + std::to_string(id));
  }
}

TEST(ViewerModule, TheProgressOfABatchIsToldToItsClient) {
  const auto server = serve();
  Progress progress;
  auto options = server->options();
  options.onEvent = [&](const json& event) { progress.take(event); };
  Client client(options);
  client.expect("load data");
  client.expect("load viewer");
  client.expect(importBall("ball"));
  json state = json::parse(stateOf("ball"));
  state["Cameras"] = json(5, state["Camera"]);
  state.erase("Camera");
  std::promise<Reply> ended;
  const uint32_t id =
      client.send("batch " + json{{"state", state}}.dump(), [&](const Reply& r) { ended.set_value(r); });
  EXPECT_TRUE(ended.get_future().get().ok);
  for (const json& event : progress.waitFor(id)) {
    EXPECT_EQ(event.at("of"), 5) << "pictures";
    EXPECT_EQ(event.at("text"), "rendered");
  }
}

TEST(ViewerModule, ABatchSaysWhatOfItsDocumentIsNotUsedAsSetDoes) {
  const auto server = serve();
  const auto client = server->client();
  client->expect("load data");
  client->expect("load viewer");
  client->expect(importBall("ball"));
  json state = json::parse(stateOf("ball"));
  state["nonsense"] = 1;
  state["Datasets"] = {{{"name", "other"}, {"type", "Volume"}, {"filename", "ball.vol"}}};
  client->expect("window 1 {\"size\": [20, 20]}");
  const json set = client->expect("set 1 " + state.dump()).at("warnings");
  const json batch = client->expect("batch " + json{{"state", state}}.dump());
  ASSERT_EQ(set.size(), 2u);
  ASSERT_EQ(batch.at("warnings").size(), 2u);
  for (const json* warnings : {&set, &batch.at("warnings")}) {
    std::string all;
    for (const json& w : *warnings) all += w.get<std::string>() + "\n";
    EXPECT_NE(all.find("`nonsense`"), std::string::npos) << all;
    EXPECT_NE(all.find("no dataset \"ball\" in this file"), std::string::npos) << all;
  }
  const std::string text = batch.at("text");
  EXPECT_EQ(text.substr(0, 20), "1 pictures\nwarning: ");
}

TEST(ViewerModule, ABatchThatIsCancelledCompilesNoMoreScenes) {
  Trace trace;
  ServerSetup setup;
  setup.ranks = 1;
  setup.modules = GALAXY_MODULES;
  setup.serverRank.trace = &trace;
  TestServer server(std::move(setup));
  const auto client = server.client();
  client->expect("load data");
  client->expect("load viewer");
  client->expect(importBall("ball"));
  json state = json::parse(stateOf("ball"));
  json visualization = state["Visualization"];
  state.erase("Visualization");
  constexpr int kVisualizations = 2000;
  for (int i = 0; i < kVisualizations; i++) {
    visualization["operators"][0]["isovalues"][0] = 0.2 + i * 1e-4;
    state["Visualizations"].push_back(visualization);
  }
  std::promise<Reply> ended;
  const uint32_t id =
      client->send("batch " + json{{"state", state}}.dump(), [&](const Reply& r) { ended.set_value(r); });
  client->expect("cancel " + std::to_string(id));
  EXPECT_EQ(ended.get_future().get().error, "cancelled");
  const std::string events = trace.events(0);
  int compiled = 0;
  for (size_t at = events.find("rendering.make_scene"); at != std::string::npos;
       at = events.find("rendering.make_scene", at + 1))
    compiled++;
  EXPECT_LT(compiled, kVisualizations);
}

TEST(ViewerModule, SharesScenesAndTheWayOfPicturesWithOtherModules) {
  const TemporaryFolder folder;
  for (const char* module : {"data", "viewer"})
    std::filesystem::copy_file(
        std::filesystem::path(GALAXY_MODULES) / ("galaxy_" + std::string(module) + ".so"),
        folder / ("galaxy_" + std::string(module) + ".so"));
  std::filesystem::copy_file(GALAXY_PICTURE_MODULE, folder / "galaxy_picture.so");
  for (const bool viewerFirst : {true, false}) {
    Trace trace;
    ServerSetup setup;
    setup.modules = folder.path().string();
    setup.serverRank.trace = &trace;
    TestServer server(std::move(setup));
    auto options = server.options();
    Screen screen;
    options.onPixels = [&](const auto& header, auto data) { screen.take(header, data); };
    Client client(options);
    client.expect("load data");
    client.expect(importBall("ball"));
    for (const char* module : {"viewer", "picture"})
      client.expect(std::string("load ") + (viewerFirst ? module : *module == 'v' ? "picture" : "viewer"));
    client.expect("window 1 {\"size\": [96, 80]}");
    client.expect("set 1 " + stateOf("ball"));
    const auto renders = [&] {
      EXPECT_EQ(screen.waitFor(1, client.expect("render 1").at("frame")).status, "complete");
    };
    renders();
    const json picture = client.expect("picture " + stateOf("ball"));
    EXPECT_EQ(picture.at("scene"), 1) << "the window's";
    EXPECT_EQ(picture.at("bytes"), 96 * 80 * 4 * sizeof(float));
    renders();
    const std::string events = trace.events(0);
    int made = 0;
    for (size_t at = events.find("rendering.make_scene"); at != std::string::npos;
         at = events.find("rendering.make_scene", at + 1))
      made++;
    EXPECT_EQ(made, 2) << "once on each rank";
  }
}

TEST(ViewerModule, PicturesCountAgainstTheMemoryOfTheirTenant) {
  ServerSetup setup;
  setup.modules = GALAXY_MODULES;
  setup.serverRank.tenantMemory = 2 << 20;  // pictures of 64 bytes a pixel, beside the ball and its scene
  TestServer server(std::move(setup));
  Viewer viewer(server);
  viewer.frame();
  int64_t framebuffer = 0;
  for (int rank = 0; rank < 2; rank++)
    for (const Ledger::Line& line : server.serverRank(rank).ledger.peaks())
      if (line.tenant == "user" && line.purpose == "framebuffer")
        framebuffer = std::max(framebuffer, line.bytes);
  EXPECT_EQ(framebuffer, 96 * 80 * 32);
  viewer.client->expect("window 1 {\"size\": [200, 200]}");
  const Reply reply = viewer.client->request("render 1");
  EXPECT_FALSE(reply.ok);
  EXPECT_TRUE(reply.error.starts_with("memory: the picture takes 2560000 bytes")) << reply.error;
  json state = json::parse(stateOf("ball"));
  state["Cameras"] = json::array();
  for (int i = 0; i < 12; i++) state["Cameras"].push_back(state["Camera"]);
  state.erase("Camera");
  const std::string batch = json{{"state", state}, {"concurrent", 12}}.dump();
  EXPECT_EQ(viewer.client->expect("batch " + batch).at("pictures").size(), 12u) << "they wait for room";
  const json stat = viewer.client->expect("stat");
  EXPECT_EQ(stat.at("tenants").at(0).at("picture bytes"), 0);
  for (int rank = 0; rank < 2; rank++) EXPECT_LE(server.serverRank(rank).ledger.peak(), 2 << 20);
}

TEST(ViewerModule, VisualizationsThatWouldTakeHoursToCompileAreRefused) {
  const auto server = serve();
  Viewer viewer(*server);
  viewer.client->expect("window 1 {\"size\": [8, 8]}");
  const auto refusal = [&](const json& document) {
    const Reply set = viewer.client->request("set 1 " + document.dump());
    if (set.ok) {
      EXPECT_EQ(viewer.client->request("render 1").error, "");
    }
    const Reply batch = viewer.client->request("batch " + json{{"state", document}}.dump());
    EXPECT_EQ(set.error, batch.error);
    return set.error;
  };
  const json state = json::parse(stateOf("ball"));
  const auto with = [&](const char* key, json value, int operators = 1) {
    json changed = state;
    changed["Camera"]["dimensions"] = {8, 8};
    changed["Visualization"]["operators"][0]["volume rendering"] = false;
    json& all = changed["Visualization"]["operators"];
    all[0][key] = std::move(value);
    for (int i = 1; i < operators; i++) all.push_back(all[0]);
    return changed;
  };
  const auto values = [](int count) {
    json list = json::array();
    for (int i = 0; i < count; i++) list.push_back(2 + i);  // beyond the data: nothing to show
    return list;
  };
  const auto points = [](int count) {
    json list = json::array();
    for (int i = 0; i < count; i++) list.push_back({i, 0.5});
    return list;
  };
  const json plane{1, 0, 0, -9};
  EXPECT_EQ(refusal(with("isovalues", values(5), 65)), "rendering: 65 operators, expected at most 64");
  EXPECT_EQ(refusal(with("isovalues", values(257))),
            "rendering: 257 isovalues and slices, expected at most 256");
  EXPECT_EQ(refusal(with("slices", json(128, plane), 2)),  // and an isovalue each
            "rendering: 258 isovalues and slices, expected at most 256");
  EXPECT_EQ(refusal(with("clip planes", json(33, plane), 2)),
            "rendering: 66 clip planes, expected at most 64");
  EXPECT_TRUE(refusal(with("extinctionmap", points(65536))).find("points of maps, expected at most 65536") !=
              std::string::npos);
  EXPECT_EQ(refusal(with("isovalues", values(4), 64)), "");
}

TEST(ViewerModule, WhatWindowsShowTakesMemoryOfTheirTenant) {
  ServerSetup setup;
  setup.modules = GALAXY_MODULES;
  setup.serverRank.tenantMemory = 27 << 19;  // of which reading what follows takes 12.5 * 10^6 bytes
  TestServer server(std::move(setup));
  Viewer viewer(server);
  json state = json::parse(stateOf("ball"));
  json& map = state["Visualization"]["operators"][0]["extinctionmap"];
  map = json::array();
  for (int i = 0; i < 30000; i++) map.push_back({i, 0.5});
  int windows = 0;
  std::string error;
  while (error.empty() && windows < 16) {
    viewer.client->expect("window " + std::to_string(++windows));
    error = viewer.client->request("set " + std::to_string(windows) + " " + state.dump()).error;
  }
  EXPECT_TRUE(error.starts_with("memory: ")) << error;
  EXPECT_GT(windows, 2);
  EXPECT_LT(windows, 6);
  viewer.client->expect("close 1");
  viewer.client->expect("set " + std::to_string(windows) + " " + state.dump());
}

TEST(ViewerModule, WrongRequestsAreErrorsWithWhatWasExpected) {
  const auto server = serve();
  Viewer viewer(*server);
  for (const char* statement : {"window",
                                "window 0",
                                "window 1.5",
                                "window 2 {\"size\": [0, 5]}",
                                "window 2 {\"size\": [60000, 60000]}",
                                "window 2 {\"sise\": [5, 5]}",
                                "render 7",
                                "render 1 {\"levels\": [1, 4]}",
                                "render 1 {\"levels\": []}",
                                "render 1 {\"wait\": 1}",
                                "render 1 {\"rays\": 0}",
                                "render 1 {\"rays\": 4096, \"passes\": 17}",
                                "render 1 {\"passes\": 0}",
                                "render 1 {\"encoding\": \"gif\"}",
                                "render 1 {\"Camera\": 3}",
                                "render 1 {\"Camera\": {\"viewpoint\": [0, 0]}}",
                                "set 1",
                                "set 1 {\"Camera\": {\"aov\": 999}}",
                                "batch {}",
                                "batch {\"state\": {}}",
                                "state 9",
                                "close x"}) {
    const Reply reply = viewer.client->request(statement);
    EXPECT_FALSE(reply.ok) << statement;
    EXPECT_NE(reply.error.find("expected"), std::string::npos) << statement << ": " << reply.error;
  }
  const Reply unknown = viewer.client->request(
      R"(set 1 {"Visualization": {"operators": [{"type": "Volume", "dataset": "b"}]}})");
  EXPECT_TRUE(unknown.ok) << "data may come later";
  EXPECT_FALSE(viewer.client->request("render 1").ok);
}

}  // namespace
}  // namespace gxy::test

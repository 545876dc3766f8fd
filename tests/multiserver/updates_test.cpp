// SPDX-License-Identifier: Apache-2.0
// Module viewer: what windows and batches show of data that change.
#include <filesystem>
#include <future>
#include <map>

#include "tests/multiserver/viewer_client.h"

namespace gxy::test {
namespace {

using nlohmann::json;

TEST(Updates, AWindowShowsWhatItsNamesMeanNow) {
  const auto server = serve();
  writeBall(server->folder().path().string(), "twice", 16, 2);
  const auto ann = server->client("ann");
  ann->expect("load data");
  ann->expect(importBall("ball"));
  ann->expect("publish ball");
  ann->expect(importBall("other", "twice.vol"));
  ann->expect("publish other");
  Viewer viewer(*server, "bob");
  const auto first = viewer.frame().rgba;
  ann->expect("rename ball old");
  ann->expect("rename other ball");
  const auto second = viewer.frame().rgba;
  EXPECT_NE(second, first) << "another under its name";
  viewer.client->expect(importBall("ball"));
  EXPECT_EQ(viewer.frame().rgba, first) << "its own counts";
  viewer.client->expect("drop ball");
  EXPECT_EQ(viewer.frame().rgba, second) << "its own has gone";
  ann->expect("unpublish ball");
  const Reply taken = viewer.client->request("render 1");
  EXPECT_NE(taken.error.find("there is none that you see"), std::string::npos) << taken.error;
}

TEST(Updates, AWindowThatFollowsRendersWhateverComesUnderItsName) {
  const auto server = serve();
  writeBall(server->folder().path().string(), "twice", 16, 2);
  Viewer viewer(*server);
  viewer.client->expect("window 1 {\"follow\": true}");
  const auto first = viewer.frame().rgba;
  viewer.client->expect("drop ball");
  viewer.client->expect(importBall("ball", "twice.vol"));
  EXPECT_EQ(viewer.screen.waitFor(1, 2).status, "complete");
  const auto second = viewer.screen.picture(1).rgba;
  EXPECT_NE(second, first);
  viewer.client->expect("rename ball old");
  viewer.client->expect(importBall("new"));
  viewer.client->expect("rename new ball");
  EXPECT_EQ(viewer.screen.waitFor(1, 3).status, "complete");
  EXPECT_EQ(viewer.screen.picture(1).rgba, first);
  viewer.client->expect("publish ball");
  EXPECT_EQ(viewer.client->expect("windows").at("windows").at(0).at("frame"), 3) << "the same object";
}

TEST(Updates, AWindowThatFollowsRendersNewGenerations) {
  const auto server = serve();
  writeBall(server->folder().path().string(), "twice", 16, 2);
  Viewer viewer(*server);
  viewer.client->expect("window 1 {\"follow\": true}");
  const auto before = viewer.frame().rgba;
  viewer.client->expect(importBall("ball", "twice.vol"));
  const auto end = viewer.screen.waitFor(1, 2);
  EXPECT_EQ(end.status, "complete");
  EXPECT_EQ(end.json.at("generations"), (json{{"ball", 2}}));
  EXPECT_NE(viewer.screen.picture(1).rgba, before);
}

TEST(Updates, AWindowThatBeginsToFollowRendersWhatHasComeBefore) {
  const auto server = serve();
  Viewer viewer(*server);
  viewer.frame();
  viewer.client->expect(importBall("ball"));
  const auto newest = [&] { return viewer.client->expect("windows").at("windows").at(0).at("frame"); };
  EXPECT_EQ(newest(), 1);
  viewer.client->expect("window 1 {\"follow\": true}");
  EXPECT_EQ(viewer.screen.waitFor(1, 2).json.at("generations"), (json{{"ball", 2}}));
  viewer.client->expect("window 1 {\"follow\": false}");
  viewer.client->expect("window 1 {\"follow\": true}");
  EXPECT_EQ(newest(), 2) << "it shows what there is";
}

TEST(Updates, AWindowThatFollowsRendersWhatCameBeforeItsFrameWasCancelled) {
  const auto server = serve();
  Viewer viewer(*server);
  viewer.client->expect("window 1 {\"follow\": true}");
  const uint64_t frame = viewer.render(R"({"rays": 65536, "levels": [1]})");
  viewer.client->expect(importBall("ball"));
  viewer.client->expect("cancel_frame 1");
  EXPECT_EQ(viewer.screen.waitFor(1, frame).status, "cancelled");
  const auto newest = [&] { return viewer.client->expect("windows").at("windows")[0].at("frame"); };
  for (int i = 0; i < 1000 && newest() == frame; i++)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  ASSERT_EQ(newest(), frame + 1);
  viewer.client->expect("cancel_frame 1");
  EXPECT_EQ(viewer.screen.waitFor(1, frame + 1).json.at("generations"), (json{{"ball", 2}}));
}

// Minutes of refining, of which nobody waits for more than the first pass.
constexpr const char* kLong = R"({"passes": 4096, "rays": 16, "levels": [1]})";

const std::string kShared = "import shared " + importBall("ball").substr(7);

// What lets go of a generation may take more than the second for which an import waits.
void importAgain(Client& client, const std::string& statement) {
  until(
      [&] {
        const Reply reply = client.request(statement);
        EXPECT_TRUE(reply.ok || reply.error.find("both its generations are in use") != std::string::npos)
            << reply.error;
        return reply.ok;
      },
      "the import has room");
}

TEST(Updates, APictureThatRefinesGivesWayToNewerData) {
  const auto server = serve();
  Viewer viewer(*server);
  viewer.client->expect("window 1 {\"follow\": true}");
  const uint64_t frame = viewer.render(kLong);
  for (uint64_t newer = 1; newer < 4; newer++) {
    until([&] { return viewer.screen.picture(1).frame == frame + newer - 1; }, "something is shown");
    importAgain(*viewer.client, importBall("ball"));
    const auto end = viewer.screen.waitFor(1, frame + newer - 1);
    EXPECT_EQ(end.status, "superseded");
    EXPECT_GE(end.json.at("passes"), 1);
    EXPECT_EQ(end.json.at("generations"), (json{{"ball", newer}}));
  }
  until([&] { return viewer.screen.picture(1).frame == frame + 3; }, "the newest is shown");
  viewer.client->expect("cancel_frame 1");
  EXPECT_EQ(viewer.screen.waitFor(1, frame + 3).status, "cancelled");
}

TEST(Updates, AWindowThatFollowsRendersAsItWasAskedToAlsoBeforeThereWereData) {
  const auto server = serve();
  Viewer viewer(*server);
  viewer.client->expect("window 1 {\"follow\": true}");
  viewer.client->expect("set 1 " + stateOf("later"));
  EXPECT_FALSE(viewer.client->request(R"(render 1 {"levels": [2], "encoding": "jpeg"})").ok);
  viewer.client->expect(importBall("later"));
  EXPECT_EQ(viewer.screen.waitFor(1, 1).status, "complete");
  EXPECT_EQ(viewer.screen.picture(1, 2).covered, 48u * 40u);
  EXPECT_EQ(viewer.screen.picture(1).covered, 0u);
  viewer.client->expect("drop later");
  EXPECT_FALSE(viewer.client->request(R"(render 1 {"levels": [1], "passes": 2})").ok);
  viewer.client->expect(importBall("later"));
  EXPECT_EQ(viewer.screen.waitFor(1, 2).json.at("passes"), 2);
  EXPECT_EQ(viewer.screen.picture(1).covered, 96u * 80u) << "as it was asked to last";
}

// Windows 1 to 3 follow; window 4, with the small window 5, takes all that the tenant may have.
void expectFollowersToTryAgain(ServerRankOptions limits, int size, int large, const std::string& refusal) {
  ServerSetup setup;
  setup.modules = GALAXY_MODULES;
  setup.serverRank = std::move(limits);
  const TestServer server(std::move(setup));
  Viewer viewer(server);
  viewer.client->expect(importBall("still"));
  for (const std::string id : {"1", "2", "3"}) {
    viewer.makeWindow(id, json{{"size", {size, size}}, {"follow", true}}.dump(), "ball");
    viewer.client->expect("render " + id + R"( {"levels": [1]})");
    EXPECT_EQ(viewer.screen.waitFor(uint32_t(std::stoi(id)), 1).status, "complete");
  }
  for (const std::string id : {"4", "5"}) {
    viewer.makeWindow(id, json{{"size", {id == "4" ? large : 16, id == "4" ? large : 16}}}.dump(), "still");
    viewer.client->expect("render " + id + " " + kLong);
  }
  viewer.client->expect(importBall("ball"));
  std::map<int, int> told;
  until(
      [&] {
        for (const json& event : viewer.takeErrors()) {
          told[event.at("window")]++;
          EXPECT_NE(event.at("text").get<std::string>().find(refusal), std::string::npos) << event;
        }
        return told.size() == 3;
      },
      "they are refused");
  const Reply asked = viewer.client->request(R"(render 1 {"levels": [1]})");
  EXPECT_NE(asked.error.find(refusal), std::string::npos) << asked.error;
  for (size_t window = 1; window <= 3; window++) EXPECT_EQ(viewer.newestFrame(window), 1);
  viewer.client->expect("cancel_frame 4");
  for (uint32_t window = 1; window <= 3; window++) {
    const auto end = viewer.screen.waitFor(window, 2);
    EXPECT_EQ(end.status, "complete");
    EXPECT_EQ(end.json.at("generations"), (json{{"ball", 2}}));
  }
  EXPECT_EQ(viewer.frame().frame, 3u) << "and what is asked for is made again";
  viewer.client->expect("cancel_frame 5");
}

TEST(Updates, FollowersThatHadNoRenderingLeftTryAgainWhenThereIsOne) {
  ServerRankOptions limits;
  limits.tenantFrames = 2;
  expectFollowersToTryAgain(limits, 96, 96, "tenant user: 2 renderings are in flight");
}

TEST(Updates, FollowersThatHadNoMemoryTryAgainWhenThereIsSome) {
  ServerRankOptions limits;
  limits.tenantMemory =
      32 << 20;  // 24 of them for the refined picture, of 128 bytes a pixel; 10 for a follower's, of 64
  expectFollowersToTryAgain(limits, 400, 433, "memory: ");
}

TEST(Updates, WhoMayOnlyReadDataKeepsNobodyFromUpdatingThem) {
  const auto server = serve();
  const auto ann = server->client("ann");
  ann->expect("load data");
  const auto update = [&] { importAgain(*ann, kShared); };
  update();
  Viewer viewer(*server, "bob");
  const uint64_t frame = viewer.render(kLong);
  until([&] { return viewer.screen.picture(1).frame == frame; }, "something is shown");
  update();
  viewer.client->expect("windows");
  EXPECT_EQ(viewer.screen.ends(1, frame), 0) << "the generation before stays";
  update();
  const auto end = viewer.screen.waitFor(1, frame);
  EXPECT_EQ(end.status, "failed");
  EXPECT_TRUE(end.json.at("error").get<std::string>().starts_with("dataset \"ball\": another update needs"))
      << end.json;
  EXPECT_GE(end.json.at("passes"), 1);
  for (int i = 0; i < 5; i++) update();
  EXPECT_EQ(viewer.client->expect("windows").at("windows").at(0).at("frame"), frame) << "it does not follow";
  EXPECT_EQ(viewer.screen.waitFor(1, viewer.render()).json.at("generations"), (json{{"ball", 8}}));
}

// Pictures of minutes.
TEST(Updates, WhoMayOnlyReadDataKeepsNobodyWaitingForAPictureThatTakesLong) {
  ServerSetup setup;
  setup.modules = GALAXY_MODULES;
  setup.serverRank.longestHold = std::chrono::milliseconds(1);
  TestServer server(std::move(setup));
  const auto ann = server.client("ann");
  ann->expect("load data");
  importAgain(*ann, kShared);
  Viewer viewer(server, "bob");
  const uint64_t frame = viewer.render(R"({"rays": 65536, "levels": [1]})");
  for (int updates = 0; updates < 2; updates++) importAgain(*ann, kShared);
  const auto end = viewer.screen.waitFor(1, frame);
  EXPECT_EQ(end.status, "failed");
  EXPECT_EQ(end.json.at("passes"), 0);
  EXPECT_TRUE(end.json.at("error").get<std::string>().starts_with("dataset \"ball\": another update needs"))
      << end.json;

  json state = json::parse(stateOf("ball"));
  state["Renderer"]["rays per pixel"] = 65536;
  std::promise<Reply> promise;
  auto ended = promise.get_future();
  viewer.client->send("batch " + json{{"state", state}}.dump(),
                      [&](const Reply& r) { promise.set_value(r); });
  until(
      [&] {
        for (const json& tenant : server.serverRank().tenants.statistics())
          if (tenant.at("tenant") == "bob") return tenant.at("frames in flight") == 1;
        return false;
      },
      "the picture is rendered");
  for (int updates = 0; updates < 2; updates++) importAgain(*ann, kShared);
  const std::string error = ended.get().error;
  EXPECT_TRUE(error.starts_with("batch: dataset \"ball\": an update needs the room of generation 3"))
      << error;
}

TEST(Updates, ADatasetThatIsDroppedIsRefinedNoFurther) {
  const auto server = serve();
  Viewer viewer(*server);
  const uint64_t frame = viewer.render(kLong);
  until([&] { return viewer.screen.picture(1).frame == frame; }, "something is shown");
  viewer.client->expect("publish ball");
  viewer.client->expect("rename ball new");
  EXPECT_EQ(viewer.screen.ends(1, frame), 0);
  viewer.client->expect("drop new");
  const auto end = viewer.screen.waitFor(1, frame);
  EXPECT_EQ(end.status, "failed");
  EXPECT_TRUE(end.json.at("error").get<std::string>().starts_with("dataset \"new\" was dropped")) << end.json;
}

TEST(Updates, ABatchOfDataOfOthersGoesOnWithNewerOnesOnceTheirRoomIsNeeded) {
  const auto server = serve();
  const auto ann = server->client("ann"), bob = server->client("bob");
  ann->expect("load data");
  importAgain(*ann, kShared);
  bob->expect("load viewer");
  json state = json::parse(stateOf("ball"));
  state["Cameras"] = json(10000, state["Camera"]);
  state.erase("Camera");
  std::promise<Reply> promise;
  auto ended = promise.get_future();
  const uint32_t batch =
      bob->send("batch " + json{{"state", state}}.dump(), [&](const Reply& r) { promise.set_value(r); });
  const auto begun = [&] { return std::filesystem::exists(server->folder() / "picture_00000.png"); };
  until(begun, "the first picture is there");
  for (int updates = 0; updates < 5; updates++) {
    importAgain(*ann, kShared);
    ASSERT_NE(ended.wait_for(std::chrono::seconds(0)), std::future_status::ready) << "the batch is at it";
  }
  bob->expect("cancel " + std::to_string(batch));
  EXPECT_EQ(ended.get().error, "cancelled");
}

}  // namespace
}  // namespace gxy::test

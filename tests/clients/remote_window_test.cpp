// SPDX-License-Identifier: Apache-2.0
// What gxyviewer shows of a server's window when data come, change and go, and when it is refused.
#include "tools/gxyviewer/remote_window.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <fstream>
#include <functional>
#include <string>
#include <thread>

#include "core/scene/state_file.h"
#include "tests/clients/stand_in.h"
#include "tests/multiserver/hang.h"
#include "tests/multiserver/holding.h"
#include "tests/multiserver/test_server.h"

namespace gxy::test {
namespace {

using nlohmann::json;

constexpr uint32_t kPasses = 3;

struct Shown {
  explicit Shown(ServerRankOptions limits = {}, BackendRegistry::Maker backend = {})
      : server(setup(std::move(limits), std::move(backend))), user(server.client()) {
    user->expect("load data");
    user->expect("load viewer");
  }
  static ServerSetup setup(ServerRankOptions limits, BackendRegistry::Maker backend) {
    ServerSetup setup;
    setup.modules = GALAXY_MODULES;
    setup.serverRank = std::move(limits);
    setup.backend = std::move(backend);
    return setup;
  }
  static State state() { return readState(stateOf("ball"), "the test's state").state; }
  // As the user's thread does; only a failure takes the whole minute.
  void until(const std::function<bool()>& condition, const char* what) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(1);
    while (!condition()) {
      ASSERT_LT(std::chrono::steady_clock::now(), end)
          << "after a minute, not yet: " << what << "; status: " << window.status();
      window.update(RemoteWindow::Clock::now());
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
  }
  void untilAllIsShown(uint64_t generation) {
    const std::string said = generation == 1 ? "s" : "ball: generation " + std::to_string(generation);
    until(
        [&] {
          const auto now = window.statistics();
          return now.ended && now.passes == kPasses && window.status().ends_with(said);
        },
        "all passes are shown, without an error");
  }
  void untilRefused(const std::string& why) {
    until([&] { return window.status().find("error: " + why) == 0; }, "it is refused");
  }
  void turn() {
    Camera camera = state().cameras[0];
    camera.viewpoint[0] -= turned += 0.5;
    window.setCamera(camera);
  }

  // Of a tenant that may have one rendering, so that the window's are refused until it ends.
  void renderLong() {
    user->expect("window 1");
    user->expect("set 1 " + stateOf("ball"));
    user->expect(R"(render 1 {"passes": 4096, "rays": 16})");
  }

  TestServer server;
  std::unique_ptr<Client> user;
  std::string warned;  // read once the window is loaded: it is told before
  RemoteWindow window{server.options(), state(), kPasses,
                      [this](const std::string& text) { warned += text; }};
  double turned = 0;
};

TEST(RemoteWindow, ShowsDataThatComeAfterItWasOpened) {
  Shown shown;
  shown.untilRefused("dataset \"ball\": there is none");
  EXPECT_FALSE(shown.window.box());
  EXPECT_EQ(shown.warned.find("dataset \"ball\": "), 0u) << shown.warned;
  shown.user->expect(importBall("ball"));
  shown.untilAllIsShown(1);
  shown.until([&] { return shown.window.box().has_value(); }, "where they are");
}

TEST(RemoteWindow, SaysThatItsSceneIsBeingMadeAsLongAsItIs) {
  const auto scenes = std::make_shared<Holding::Scenes>();
  scenes->held = true;
  Shown shown({}, holding(scenes));
  shown.user->expect(importBall("ball"));
  shown.until([&] { return shown.window.status() == "building the scene"; }, "it is told");
  scenes->held = false;
  shown.untilAllIsShown(1);
}

TEST(RemoteWindow, SaysThatARankIsMissingAsLongAsItIs) {
  ServerRankOptions impatient;
  impatient.rankPatience = std::chrono::milliseconds(100);
  Shown shown(impatient);
  shown.user->expect(importBall("ball"));
  shown.untilAllIsShown(1);
  {
    const Hang hang(shown.server, 1);
    shown.until([&] { return shown.window.status().find("rank 1 ") == 0; }, "it is told");
  }
  shown.untilAllIsShown(1);
}

TEST(RemoteWindow, HasNoWholePictureWhereOneIsRefinedNoFurther) {
  Shown shown;
  shown.user->expect(importBall("ball"));
  RemoteWindow window(shown.server.options(), shown.state(), 4096);
  const auto passes = [&] {
    window.update(RemoteWindow::Clock::now());
    return window.statistics().passes;
  };
  shown.until([&] { return passes() > 0 && !window.statistics().ended; }, "it is refined");
  shown.user->expect("drop ball");
  shown.until([&] { return window.statistics().ended; }, "it ends");
  EXPECT_EQ(window.status().find("error: dataset \"ball\" was dropped"), 0u) << window.status();
  EXPECT_FALSE(window.whole());
}

TEST(RemoteWindow, ForgetsAnErrorWhenDataAreBack) {
  Shown shown;
  shown.user->expect(importBall("ball"));
  shown.untilAllIsShown(1);
  shown.user->expect("drop ball");
  shown.turn();
  shown.untilRefused("dataset \"ball\": there is none");
  shown.until([&] { return !shown.window.box(); }, "there are none");
  shown.user->expect(importBall("ball"));
  shown.untilAllIsShown(1);
}

TEST(RemoteWindow, KnowsWhereNewerDataAre) {
  Shown shown;
  shown.user->expect(importBall("ball"));
  shown.untilAllIsShown(1);
  std::ofstream(shown.server.folder() / "moved.vol") << "float\n4 4 4\n16 16 16\n0.5 0.5 0.5\nball.raw\n";
  shown.user->expect(importBall("ball", "moved.vol"));
  shown.until([&] { return shown.window.box() && (*shown.window.box())[1][0] == 11.5; }, "the new box");
  EXPECT_EQ(shown.window.box()->at(0), (std::array<double, 3>{4, 4, 4}));
  shown.untilAllIsShown(2);
}

TEST(RemoteWindow, AsksForItsDataAnewAfterEachEventOfThemOrWhereSomeWereLost) {
  std::atomic<int> asked = 0;
  StandIn server([&](std::string_view statement) -> std::string {
    if (statement.starts_with("viewer.render")) return R"(ok {"frame": 1})";
    if (!statement.starts_with("data.info")) return "ok";
    asked++;
    return R"(ok {"datasets": []})";
  });
  Client::Options options;
  options.port = server.port();
  options.tokenFile = "-";
  RemoteWindow window(options, Shown::state(), kPasses);
  window.waitUntilLoaded();
  EXPECT_EQ(asked, 1);
  const auto untilAsked = [&](int times, const std::string& why) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(1);
    while (asked < times && std::chrono::steady_clock::now() < end) {
      window.update(RemoteWindow::Clock::now());
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    EXPECT_EQ(asked, times) << why;
  };
  const auto untilSaid = [&](const std::string& text) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(1);
    while (window.status() != text && std::chrono::steady_clock::now() < end)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    EXPECT_EQ(window.status(), text);
    window.update(RemoteWindow::Clock::now());  // it would ask now
  };
  int times = 1;
  for (const char* kind : {"added", "updated", "dropped", "renamed", "lost"}) {
    server.tell(json{{"event", kind}}.dump());
    untilAsked(++times, kind);
    server.tell(json{{"event", "skipped"}}.dump());  // which changes nothing
    server.tell(json{{"event", "progress"}, {"text", std::string("after ") + kind}}.dump());
    untilSaid(std::string("after ") + kind);
  }
  EXPECT_EQ(asked, times);
}

TEST(RemoteWindow, ImportsDataOfOtherFilesAndSaysWhenTheyAreSeen) {
  Shown shown;
  shown.user->expect(importBall("ball"));
  shown.untilAllIsShown(1);
  EXPECT_EQ(shown.window.generations(), (std::map<std::string, uint64_t>{{"ball", 1}}));
  EXPECT_FALSE(shown.window.imported());
  writeBall(shown.server.folder().path().string(), "next", 8, 0.5f);
  std::optional<RemoteWindow::Imported> outcome;
  const auto import = [&](const char* file) {
    shown.window.import({{"ball", DatasetType::Volume, file, "", {}}});
    shown.until([&] { return (outcome = shown.window.imported()).has_value(); }, "it has ended");
    return outcome->error;
  };
  EXPECT_EQ(import("next.vol"), "");
  EXPECT_EQ(outcome->generations, (std::map<std::string, uint64_t>{{"ball", 2}}));
  shown.until([&] { return shown.window.generations().at("ball") == 2; }, "they are seen");
  shown.untilAllIsShown(1);  // of what it has imported itself, generations are not told
  EXPECT_NE(import("none.vol").find("none.vol"), std::string::npos) << outcome->error;
  EXPECT_EQ(shown.window.generations().at("ball"), 2u) << "what was shown stays";
  EXPECT_FALSE(shown.window.refused());
  shown.window.drop({{"ball", DatasetType::Volume, "next.vol", "", {}}});
  EXPECT_TRUE(shown.user->expect("list").at("datasets").empty());
}

TEST(RemoteWindow, AsksAgainForWhatWasRefused) {
  ServerRankOptions limits;
  limits.tenantFrames = 1;
  Shown shown(limits);
  shown.user->expect(importBall("ball"));
  shown.untilAllIsShown(1);
  shown.renderLong();
  shown.turn();
  shown.untilRefused("tenant user: 1 renderings are in flight");
  // Long enough, as a rule, for the frame of the camera at rest to be refused, too.
  const auto later = std::chrono::steady_clock::now() + std::chrono::milliseconds(600);
  shown.until([&] { return std::chrono::steady_clock::now() > later; }, "time passes");
  shown.untilRefused("tenant user: 1 renderings are in flight");
  shown.user->expect("cancel_frame 1");
  shown.untilAllIsShown(1);
}

TEST(RemoteWindow, MakesAWholePictureBesideACameraThatMoves) {
  Shown shown;
  shown.user->expect(importBall("ball"));
  shown.untilAllIsShown(1);
  EXPECT_TRUE(shown.window.whole());
  const Canvas expected = shown.window.picture();
  const auto still = shown.window.still(shown.state());
  const uint64_t before = shown.window.statistics().frames;
  uint32_t passes = 0;
  shown.until(
      [&] {
        shown.turn();
        EXPECT_FALSE(shown.window.whole());
        EXPECT_GE(still->progress().passes, passes);
        passes = still->progress().passes;
        return still->progress().ended && shown.window.statistics().frames > before;
      },
      "it is made, and others meanwhile");
  EXPECT_EQ(still->progress().error, "");
  EXPECT_EQ(still->progress().passes, kPasses);
  EXPECT_TRUE(std::ranges::equal(still->canvas().rgba(), expected.rgba()));
  EXPECT_FALSE(std::ranges::equal(shown.window.picture().rgba(), expected.rgba()));
  shown.until([&] { return shown.user->expect("stat").at("ranks").at(0).at("frames") == 0; },
              "all has ended");
}

TEST(RemoteWindow, TellsWhatIsAtAPixel) {
  Shown shown;
  shown.user->expect(importBall("ball"));
  shown.untilAllIsShown(1);
  const glm::ivec2 size = shown.state().cameras[0].dimensions;
  std::optional<std::string> text;
  const auto picked = [&](glm::ivec2 pixel) {
    shown.window.pick(pixel);
    shown.until([&] { return (text = shown.window.picked()).has_value(); }, "the answer");
    return *text;
  };
  EXPECT_EQ(picked(size / 2).find("operator 1, Volume ball, at "), 0u) << *text;
  EXPECT_TRUE(text->ends_with(": 0.6")) << *text;
  EXPECT_EQ(picked({0, 0}), "there is no surface");
  EXPECT_EQ(picked({-1, 0}).find("error: pick: pixel -1 0: expected"), 0u) << *text;
}

TEST(RemoteWindow, SaysWhyThereIsNoWholePicture) {
  ServerRankOptions limits;
  limits.tenantFrames = 1;
  Shown shown(limits);
  shown.user->expect(importBall("ball"));
  shown.untilAllIsShown(1);
  shown.renderLong();
  const auto still = shown.window.still(shown.state());
  shown.until([&] { return still->progress().ended; }, "it ends");
  EXPECT_EQ(still->progress().error.find("tenant user: 1 renderings are in flight"), 0u)
      << still->progress().error;
  shown.user->expect("cancel_frame 1");
}

}  // namespace
}  // namespace gxy::test

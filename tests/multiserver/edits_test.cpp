// SPDX-License-Identifier: Apache-2.0
// Module viewer: what an edit of what a window shows has to wait for, and scenes that are given up while they are made.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "backends/embree/embree_backend.h"
#include "core/io/write_geometry.h"
#include "tests/multiserver/holding.h"
#include "tests/multiserver/raw_client.h"
#include "tests/multiserver/test_server.h"

namespace gxy::test {
namespace {

using nlohmann::json;

// Embree, and for each scene made whether the one before it was still there: compileScene takes plans from those only.
class Watching final : public Backend {
 public:
  struct Seen {
    std::weak_ptr<const CompiledScene> last;
    std::vector<bool> hadLast;
    std::vector<const GeometryInPartition*> primitives;  // of the first operator; null if a volume
  };
  explicit Watching(std::shared_ptr<Seen> seen) : seen_(std::move(seen)) {}
  std::string name() const override { return embree_->name(); }
  std::string device() const override { return embree_->device(); }
  std::unique_ptr<DeviceScene> makeScene(std::shared_ptr<const CompiledScene> scene, int rank,
                                         const Advance& advance) const override {
    seen_->hadLast.push_back(!seen_->last.expired());
    seen_->last = scene;
    seen_->primitives.push_back(scene->operators.at(0).parts.at(0).geometry.get());
    return embree_->makeScene(std::move(scene), rank, advance);
  }

 private:
  std::unique_ptr<Backend> embree_ = makeEmbreeBackend();
  std::shared_ptr<Seen> seen_;
};

// A server of one rank.
ServerSetup watchedBy(const std::shared_ptr<Watching::Seen>& seen) {
  ServerSetup setup;
  setup.ranks = 1;
  setup.modules = GALAXY_MODULES;
  setup.backend = [seen](Ledger*) { return std::make_unique<Watching>(seen); };
  return setup;
}

TEST(ViewerModule, WhatIsShownIsThereUntilAnEditOfItIsCompiled) {
  const auto seen = std::make_shared<Watching::Seen>();
  TestServer server(watchedBy(seen));
  Screen screen;
  auto options = server.options();
  options.onPixels = [&](const auto& header, auto data) { screen.take(header, data); };
  Client client(options);
  client.expect("load data");
  client.expect("load viewer");
  client.expect(importBall("ball"));
  client.expect("window 1 {\"size\": [48, 40]}");
  const auto show = [&](const std::string& map, const std::string& settings) {
    client.expect(R"(set 1 {"Visualization": {"operators": [{"type": "Volume", "dataset": "ball",
                      "isovalues": [0.5], "colormap": ")" +
                  map + "\"}]}" + settings + "}");
    EXPECT_EQ(screen.waitFor(1, client.expect("render 1").at("frame")).status, "complete");
  };
  show("Viridis", "");
  show("Inferno", "");                                     // an edit of the map
  show("Inferno", R"(, "Renderer": {"tolerance": 0.1})");  // and of settings
  client.expect(
      "set 1 {\"Visualization\": {\"operators\": [{\"type\": \"Volume\", \"dataset\": \"ball\", "
      "\"isovalues\": [0.4]}]}}");
  client.expect("close 1");
  EXPECT_EQ(seen->hadLast, (std::vector<bool>{false, true, true}));
  // a window that is closed lets go of what it showed before its last edit
  for (int i = 0; i < 1000 && !seen->last.expired(); i++)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  EXPECT_TRUE(seen->last.expired());
}

TEST(ViewerModule, GeometryIsMadeReadyOnceForEditsThatLeaveIt) {
  const auto seen = std::make_shared<Watching::Seen>();
  TestServer server(watchedBy(seen));
  GeometryBlock balls;
  balls.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  balls.ids = {0, 1, 2};
  writeGeometry(server.folder() / "balls.vtp", balls, GeometryKind::Particles);
  Screen screen;
  auto options = server.options();
  options.onPixels = [&](const auto& header, auto data) { screen.take(header, data); };
  Client client(options);
  client.expect("load data");
  client.expect("load viewer");
  client.expect(R"(import {"Datasets": {"name": "balls", "filename": "balls.vtp", "type": "Particles"}})");
  const auto show = [&](int window, const std::string& radius, const std::string& light) {
    const std::string id = std::to_string(window);
    client.expect("window " + id + " {\"size\": [48, 40]}");
    client.expect(
        "set " + id +
        R"( {"Visualization": {"operators": [{"type": "Particles", "dataset": "balls", "radius": )" + radius +
        R"(}], "Lighting": {"Sources": [[)" + light + "]]}}}");
    EXPECT_EQ(screen.waitFor(window, client.expect("render " + id).at("frame")).status, "complete");
  };
  show(1, "0.25", "1, 1, 1, 0");
  show(1, "0.25", "1, 0, 0, 0");
  show(2, "0.25", "0, 1, 0, 0");
  show(2, "0.5", "0, 1, 0, 0");
  ASSERT_EQ(seen->primitives.size(), 4u);
  EXPECT_EQ(seen->primitives[1], seen->primitives[0]) << "another light";
  EXPECT_EQ(seen->primitives[2], seen->primitives[0]) << "another window";
  EXPECT_NE(seen->primitives[3], seen->primitives[0]) << "other radii";
}

// A server of two ranks whose scenes may be held.
struct HoldingServer {
  std::shared_ptr<Holding::Scenes> scenes = std::make_shared<Holding::Scenes>();
  TestServer server{[this] {
    ServerSetup setup;
    setup.modules = GALAXY_MODULES;
    setup.backend = holding(scenes);
    return setup;
  }()};
};

// A client whose window 1 shows a ball.
struct Looks {
  explicit Looks(const TestServer& server) {
    auto options = server.options();
    options.onPixels = [this](const auto& header, auto data) { screen.take(header, data); };
    options.onEvent = [this](const json& event) {
      if (event.at("event") != "progress") return;
      const std::lock_guard lock(mutex);
      progress.push_back(event);
    };
    client = std::make_unique<Client>(options);
    client->expect("load data");
    client->expect("load viewer");
    if (client->expect("list").at("datasets").empty()) client->expect(importBall("ball"));
    client->expect("window 1 {\"size\": [48, 40]}");
    client->expect("set 1 " + stateOf("ball"));
    const std::lock_guard lock(mutex);
    progress.clear();  // of the import
  }
  std::future<Reply> ask(const std::string& statement) {
    const auto promise = std::make_shared<std::promise<Reply>>();
    request = client->send(statement, [promise](const Reply& r) { promise->set_value(r); });
    return promise->get_future();
  }
  void cancel() { client->expect("cancel " + std::to_string(request)); }
  // Of the last request.
  std::vector<json> told() const {
    const std::lock_guard lock(mutex);
    std::vector<json> its;
    for (const json& event : progress)
      if (event.at("request") == request) its.push_back(event);
    return its;
  }

  Screen screen;
  mutable std::mutex mutex;
  std::vector<json> progress;
  uint32_t request = 0;
  std::unique_ptr<Client> client;  // after what it uses, so that it goes first
};

// Waits for what others do; only a failure takes the whole minute.
void until(const std::function<bool()>& condition, const char* what) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(1);
  while (!condition()) {
    ASSERT_LT(std::chrono::steady_clock::now(), end) << "after a minute, not yet: " << what;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

int64_t bytesOfScenes(TestServer& server) {
  int64_t bytes = 0;
  for (int rank = 0; rank < 2; rank++)
    for (const auto& line : server.serverRank(rank).ledger.snapshot())
      if (line.purpose == "scene") bytes += line.bytes;
  return bytes;
}

TEST(Scenes, ThatNobodyWantsAnyMoreAreGivenUpOnAllRanks) {
  HoldingServer holding;
  const auto& scenes = holding.scenes;
  Looks ann(holding.server);
  const std::string document = "{\"state\": " + stateOf("ball") + ", \"prefix\": \"late\"}";
  int given = 0;
  for (const std::string& statement : {std::string("render 1"), "batch " + document}) {
    scenes->held = true;
    auto reply = ann.ask(statement);
    until([&] { return scenes->begun == given + 2; }, "both ranks are at it");
    ann.cancel();
    EXPECT_EQ(reply.get().error, "cancelled") << statement;
    EXPECT_EQ(scenes->givenUp, given += 2) << "before the reply";
    EXPECT_EQ(scenes->made, 0);
    EXPECT_EQ(bytesOfScenes(holding.server), 0);
  }
  {
    Looks leaves(holding.server);
    leaves.ask("render 1");
    until([&] { return scenes->begun == given + 2; }, "both ranks are at it");
  }
  until([&] { return scenes->givenUp == given + 2; }, "nobody is there any more");
  scenes->held = false;
  EXPECT_EQ(ann.screen.waitFor(1, ann.client->expect("render 1").at("frame")).status, "complete");
  EXPECT_EQ(scenes->made, 2);
}

TEST(Scenes, ThatOthersStillWantAreMadeForThemWhoAreToldTheProgress) {
  HoldingServer holding;
  const auto& scenes = holding.scenes;
  Looks ann(holding.server), bob(holding.server);
  scenes->held = true;
  auto anns = ann.ask("render 1"), bobs = bob.ask("render 1");
  until([&] { return !ann.told().empty() && !bob.told().empty(); }, "both wait for it");
  ann.cancel();
  EXPECT_EQ(anns.get().error, "cancelled") << "at once";
  EXPECT_EQ(bobs.wait_for(std::chrono::seconds(0)), std::future_status::timeout);
  EXPECT_EQ(scenes->givenUp, 0);
  std::this_thread::sleep_for(std::chrono::milliseconds(110));  // progress is told ten times a second at most
  scenes->held = false;
  EXPECT_EQ(bob.screen.waitFor(1, bobs.get().value.at("frame")).status, "complete");
  EXPECT_EQ(scenes->begun, 2) << "once on each rank";
  const std::vector<json> told = bob.told();
  const auto isTold = [&](const char* text, int64_t done) {
    return std::any_of(told.begin(), told.end(), [&](const json& event) {
      return event.at("text") == text && event.at("done") == done && event.at("of") == 2 * Exchanges::kUnits;
    });
  };
  EXPECT_TRUE(isTold("building the scene", Exchanges::kUnits * 3 / 2)) << json(told);
  EXPECT_TRUE(isTold("done", 2 * Exchanges::kUnits)) << json(told);
}

TEST(Scenes, OfFramesThatWindowsBeginThemselvesGoWithTheWindow) {
  HoldingServer holding;
  const auto& scenes = holding.scenes;
  Looks ann(holding.server);
  ann.client->expect("window 1 {\"follow\": true}");
  EXPECT_EQ(ann.screen.waitFor(1, ann.client->expect("render 1").at("frame")).status, "complete");
  scenes->held = true;
  ann.client->expect(importBall("ball"));
  until([&] { return scenes->begun == 4; }, "its next picture is being made ready");
  ann.client->expect("close 1");
  EXPECT_EQ(scenes->givenUp, 2);
}

// A frame that waited until its client had read the one before, of data that were updated meanwhile.
TEST(Scenes, OfFramesThatAreCancelledAreGivenUp) {
  HoldingServer holding;
  const auto& scenes = holding.scenes;
  const auto ann = holding.server.client();
  ann->expect("load data");
  ann->expect(importBall("ball"));
  RawClient slow(holding.server.port(), 4096);
  slow.greet();
  uint32_t id = 1;
  for (const std::string& statement :
       {std::string("load viewer"), std::string("window 1 {\"size\": [1024, 1024]}"),
        "set 1 " + stateOf("ball"), std::string("render 1 {\"encoding\": \"raw\", \"levels\": [1]}"),
        std::string("render 1 {\"wait\": true, \"levels\": [4]}")})
    ASSERT_TRUE(slow.request(id++, statement));
  until(
      [&] {
        const json tenant = ann->expect("stat").at("tenants").at(0);
        return tenant.at("frames") == 1 && tenant.at("frames in flight") == 1;
      },
      "the second frame waits");
  scenes->held = true;
  ann->expect(importBall("ball"));
  json end;
  EXPECT_TRUE(slow.readUntil([&](const protocol::WireMessage& frame) {
    if (frame.channel != protocol::MessageChannel::Pixels) return false;
    const protocol::PixelHeader header = protocol::pixelHeader(frame.payload);
    if (header.kind == protocol::PixelKind::EndOfPass && header.frame == 1) {
      until([&] { return scenes->begun == 4; }, "the second frame gets its scene");
      EXPECT_TRUE(slow.request(id++, "cancel_frame 1"));
    }
    if (header.kind != protocol::PixelKind::EndOfFrame || header.frame != 2) return false;
    const auto data = protocol::pixelData(frame.payload);
    end = json::parse(std::string_view(reinterpret_cast<const char*>(data.data()), data.size()));
    return true;
  }));
  EXPECT_EQ(end.at("status"), "cancelled") << end;
  EXPECT_EQ(scenes->givenUp, 2);
}

// An edit that is cancelled has let go of nothing that the next may take over.
TEST(Scenes, ThatAreGivenUpLeaveToTheNextEditWhatThereWasBefore) {
  HoldingServer holding;
  const auto& scenes = holding.scenes;
  Looks ann(holding.server);
  EXPECT_EQ(ann.screen.waitFor(1, ann.client->expect("render 1").at("frame")).status, "complete");
  const auto shown = [&] { return bytesOfScenes(holding.server) > 0; };
  scenes->held = true;
  ann.client->expect("set 1 {\"Renderer\": {\"tolerance\": 0.1}}");
  auto reply = ann.ask("render 1");
  until([&] { return scenes->begun == 4; }, "both ranks are at it");
  ann.cancel();
  EXPECT_EQ(reply.get().error, "cancelled");
  ann.client->expect("stat");  // after the works that forget what nobody holds
  EXPECT_TRUE(shown());
  ann.client->expect("close 1");
  until([&] { return !shown(); }, "a window that is closed lets go of it");
}

}  // namespace
}  // namespace gxy::test

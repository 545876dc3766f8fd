// SPDX-License-Identifier: Apache-2.0
// Module viewer: what an edit of what a window shows has to wait for.
#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <thread>
#include <vector>

#include "gxy/embree/embree_backend.h"
#include "gxy/io/write_geometry.h"
#include "multiserver/test_server.h"

namespace gxy::test {
namespace {

// Embree, and for each scene made whether the one before it was still there: compileScene takes plans from those only.
class Watching final : public Backend {
 public:
  struct Seen {
    std::weak_ptr<const CompiledScene> last;
    std::vector<bool> hadLast;
    std::vector<const GeometryPart*> primitives;  // of the first operator; null if a volume
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

}  // namespace
}  // namespace gxy::test

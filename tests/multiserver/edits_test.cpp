// SPDX-License-Identifier: Apache-2.0
// Module viewer: what an edit of what a window shows has to wait for.
#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <thread>
#include <vector>

#include "gxy/embree/embree_backend.h"
#include "multiserver/test_server.h"

namespace gxy::test {
namespace {

// Embree, and for each scene made whether the one before it was still there: compileScene takes plans from those only.
class Watching final : public Backend {
 public:
  struct Seen {
    std::weak_ptr<const CompiledScene> last;
    std::vector<bool> hadLast;
  };
  explicit Watching(std::shared_ptr<Seen> seen) : seen_(std::move(seen)) {}
  std::string name() const override { return embree_->name(); }
  std::string device() const override { return embree_->device(); }
  std::unique_ptr<DeviceScene> makeScene(std::shared_ptr<const CompiledScene> scene,
                                         int rank) const override {
    seen_->hadLast.push_back(!seen_->last.expired());
    seen_->last = scene;
    return embree_->makeScene(std::move(scene), rank);
  }

 private:
  std::unique_ptr<Backend> embree_ = makeEmbreeBackend();
  std::shared_ptr<Seen> seen_;
};

TEST(ViewerModule, WhatIsShownIsThereUntilAnEditOfItIsCompiled) {
  const auto seen = std::make_shared<Watching::Seen>();
  ServerSetup setup;
  setup.ranks = 1;
  setup.modules = GALAXY_MODULES;
  setup.backend = [seen](Ledger*) { return std::make_unique<Watching>(seen); };
  TestServer server(std::move(setup));
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

}  // namespace
}  // namespace gxy::test

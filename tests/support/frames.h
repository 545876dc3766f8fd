// SPDX-License-Identifier: Apache-2.0
// Compiles scenes for simulated ranks, and renders frames on them.
#pragma once
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "core/comm/in_process.h"
#include "core/render/renderer.h"
#include "tests/support/difference.h"
#include "tests/support/partitionings.h"
#include "tests/support/scenes.h"

namespace gxy::test {

/// A scene as one rank renders it.
struct RankScene {
  std::shared_ptr<const CompiledScene> compiled;
  std::shared_ptr<const DeviceScene> device;
};

/// Returns the backend of a rank. It need not outlive the scenes that it makes.
using BackendOf = std::function<const Backend&(int rank)>;

/// Cuts the scene's data, compiles the scene on every rank, on testedBackend() unless `backendOf` is given,
/// and combines which partitions are visible over all ranks.
std::vector<RankScene> compiledOn(const Cut& cut, const TestScene& scene, const BackendOf& backendOf = {});

/// Options of running frames.
struct FrameRun {
  uint64_t seed = 1;
  bool threaded = false;  ///< real threads instead of the seeded scheduler
  int workers = 2;        ///< number of worker threads, if threaded
  Renderer::Options options{};
};

/// A Renderer on every rank of an in-process world. It collects errors that leave handlers or tasks, and
/// messages of the validation layers.
class Frames {
 public:
  Frames(int ranks, const FrameRun& run);

  void add(SceneId id, const std::vector<RankScene>& scene);

  /// Starts a frame; it runs in world().step() or run().
  FrameId start(const FrameRequest& request);

  /// Runs until nothing is under way.
  void run() { world_->run(); }

  struct Outcome {
    int finished = 0, superseded = 0, pictures = 0;
    std::string error;
    Picture picture;
  };
  /// The outcome of a frame.
  const Outcome& outcome(FrameId id) { return outcomes_[id]; }

  InProcessWorld& world() { return *world_; }
  Renderer& renderer(int rank) { return *renderers_[size_t(rank)]; }
  std::vector<std::string> errors();

 private:
  std::mutex mutex_;
  std::vector<std::string> errors_;
  std::unique_ptr<InProcessWorld> world_;
  std::vector<std::unique_ptr<Renderer>> renderers_;
  std::map<FrameId, Outcome> outcomes_;
};

/// Returns a request for a frame with depths of the scene, which was added as scene 1.
FrameRequest requestOf(const TestScene& scene);

/// Renders one frame of one scene.
Picture render(const TestScene& scene, const Cut& cut, const FrameRun& run = {});
Picture render(const TestScene& scene, int ranks, const std::vector<RankScene>& compiled,
               const FrameRun& run = {});

/// Renders one frame of the scene in one piece on Embree. All pictures of the scene are compared with it.
Picture wholeOnEmbree(const TestScene& scene);

}  // namespace gxy::test

// SPDX-License-Identifier: Apache-2.0
// Scenes compiled for simulated ranks, and frames rendered on them.
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

/// The backend of a rank, which need not outlive the scenes that it makes.
using BackendOf = std::function<const Backend&(int rank)>;

/// Cuts the scene's data, compiles it on every rank, on testedBackend() unless `backendOf` says otherwise,
/// and merges what ranks know of partitions.
std::vector<RankScene> compiledOn(const Cut& cut, const TestScene& scene, const BackendOf& backendOf = {});

/// How frames are run.
struct FrameRun {
  uint64_t seed = 1;
  bool threaded = false;  ///< real threads, instead of the seeded scheduler
  int workers = 2;        ///< when threaded
  Renderer::Options options{};
};

/// A Renderer on every rank of an in-process world. Errors that leave handlers or tasks are collected, and
/// what the validation layers say.
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
  /// What has become of a frame.
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

/// A frame of the scene that a rank knows as 1, with depths.
FrameRequest requestOf(const TestScene& scene);

/// One frame of one scene.
Picture render(const TestScene& scene, const Cut& cut, const FrameRun& run = {});
Picture render(const TestScene& scene, int ranks, const std::vector<RankScene>& compiled,
               const FrameRun& run = {});

/// One frame of the scene in one piece on Embree: what all its pictures are compared with.
Picture wholeOnEmbree(const TestScene& scene);

}  // namespace gxy::test

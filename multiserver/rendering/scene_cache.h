// SPDX-License-Identifier: Apache-2.0
// Visualizations with their data, compiled on all ranks and shared by all frames of a tenant that show them.
#pragma once
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "core/render/scene_builder.h"
#include "core/scene/resolve.h"
#include "multiserver/server/datasets.h"
#include "multiserver/server/module.h"

namespace gxy {

/// A scene that all ranks have, until the last who holds this lets go. Rank 0.
struct SceneHandle {
  SceneHandle(Node& node, SceneId id) : node(node), id(id) {}
  ~SceneHandle();
  SceneHandle(const SceneHandle&) = delete;
  SceneHandle& operator=(const SceneHandle&) = delete;

  Node& node;
  const SceneId id;
  std::vector<NamedDataset> data;  ///< with the generations that it shows

  /// What it calls that dataset, if it shows it; of that generation, if one is given.
  const NamedDataset* find(Key key, std::optional<Generation> generation = {}) const;
};
using ScenePtr = std::shared_ptr<const SceneHandle>;

/// One on each rank (Rendering). Thread safe.
class SceneCache {
 public:
  explicit SceneCache(Registration& registration);

  struct Pinned {
    ScenePtr scene;
    std::vector<Pin> pins;  ///< of its data
  };
  /// Rank 0: the scene of a visualization with the current generations of its data, as the tenant sees them; compiled
  /// unless that tenant has one of the same content, or one that is being made: then all who want it wait for that one, and
  /// are told its progress, and it is given up on all ranks when none of them wants it any more. `known`, if not null, is
  /// taken while its names mean its data. What the visualization asks of the data is said by these and by what it has shown
  /// so far, `shown`, which they widen; a scene that is `known` has widened it before. Waits; the asker lives as long. Throws
  /// Error for data that are not there or do not fit, and soon what `asker.check` throws, the last who waits once nothing of
  /// the scene is left.
  Pinned get(const std::string& tenant, const Visualization& visualization, const RenderSettings& settings,
             const Asker& asker, ShownSoFar& shown, const ScenePtr& known = nullptr);
  /// Rank 0: what get() would do to `shown`. Throws Error for data that are not there.
  void widen(const std::string& tenant, const Visualization& visualization, ShownSoFar& shown) const;
  /// Every rank: a scene that rank 0 has got. Throws Error once it has been let go.
  std::shared_ptr<const CompiledScene> compiled(SceneId id);
  /// Whether that is what these names mean to the tenant now.
  bool namesMean(const std::string& tenant, const std::vector<NamedDataset>& data) const;

 private:
  /// A visualization with its data, as the tenant sees them, and numbers for what it asks of them.
  struct Held {
    std::vector<NamedDataset> data;
    std::vector<Pin> pins;
    Visualization resolved;
  };
  Held hold(const std::string& tenant, const Visualization& visualization, ShownSoFar& shown) const;
  SceneSource sourceOf(const nlohmann::json& parameters, Collectives& ranks) const;
  nlohmann::json make(const nlohmann::json& parameters);
  nlohmann::json forget(const nlohmann::json& parameters);
  /// A scene that is being made, and who waits for it. Rank 0; under mutex_ but for `wanted`.
  struct Making {
    std::vector<const Asker*> askers;
    std::atomic<bool> wanted = true;  ///< by any of them; no more ask for it once nobody does
    uint64_t exchange = 0;
    bool ended = false;
    ScenePtr scene;     ///< then; null: failed
    std::string error;  ///< of that
    const std::chrono::steady_clock::time_point begin = std::chrono::steady_clock::now();
    int64_t told = 0;  ///< of how many units of progress
  };
  using MakingPtr = std::shared_ptr<Making>;
  void start(const MakingPtr& making, const std::string& content, const std::string& tenant,
             const std::string& text, std::vector<NamedDataset> data);
  void end(const MakingPtr& making, const std::string& content, ScenePtr scene, const std::string& error);
  void tell(Making& making, int64_t done, int64_t of, const std::string& text, bool phase);
  ScenePtr waitFor(const MakingPtr& making, const std::string& content, const Asker& asker);
  ScenePtr getOf(const std::string& tenant, const State& state, const std::vector<NamedDataset>& data,
                 const Asker& asker);

  Node& node_;
  std::mutex mutex_;
  std::map<std::string, std::weak_ptr<const SceneHandle>> known_;  ///< rank 0: by content
  std::map<std::string, MakingPtr> underWay_;                      ///< rank 0: by content
  std::condition_variable ended_;                                  ///< of one of these
  SceneId next_ = 1;                                               ///< rank 0
  SceneBuilder builder_;
  std::map<SceneId, BuiltScene> built_;  ///< every rank: those that rank 0 has not let go
};

}  // namespace gxy

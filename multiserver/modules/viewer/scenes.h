// SPDX-License-Identifier: Apache-2.0
// Visualizations with their data, compiled on all ranks and shared by all frames of a tenant that show them.
#pragma once
#include <array>
#include <future>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "gxy/rays/scene_memory.h"
#include "gxy/scene/scene.h"
#include "gxy/server/datasets.h"
#include "gxy/server/module.h"
#include "gxy/space/shared_by.h"

namespace gxy::viewer {

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

/// Throws Error for what would take more of the server than any client may have (docs/protocol.md section 8).
void checkCost(const Visualization& visualization);
void checkCost(const RenderSettings& settings, glm::ivec2 size);

/// Memory that these take, or somewhat less.
int64_t bytesOf(const Visualization& visualization);
int64_t bytesOf(const State& state);

/// One on each rank. Thread safe.
class Scenes {
 public:
  explicit Scenes(Registration& registration);

  struct Pinned {
    ScenePtr scene;
    std::vector<Pin> pins;  ///< of its data
  };
  /// Rank 0: the scene of a visualization with the current generations of its data, as the tenant sees them; compiled
  /// unless that tenant has one of the same content. `known`, if not null, is taken while its names mean its data. Waits.
  /// Throws Error for data that are not there or do not fit.
  Pinned get(const std::string& tenant, const Visualization& visualization, const RenderSettings& settings,
             const ScenePtr& known = nullptr);
  /// Whether that is what these names mean to the tenant now.
  bool namesMean(const std::string& tenant, const std::vector<NamedDataset>& data) const;

 private:
  nlohmann::json make(const nlohmann::json& parameters);
  nlohmann::json forget(const nlohmann::json& parameters);
  ScenePtr build(const std::string& tenant, const std::string& text, std::vector<NamedDataset> data);
  ScenePtr getOf(const std::string& tenant, const State& state, const std::vector<NamedDataset>& data);

  Node& node_;
  std::mutex mutex_;
  std::map<std::string, std::weak_ptr<const SceneHandle>> known_;  ///< rank 0: by content
  std::map<std::string, std::shared_future<ScenePtr>> underWay_;   ///< rank 0
  SceneId next_ = 1;                                               ///< rank 0
  /// Geometry in every partition that it touches, of a tenant's scenes.
  struct Distributed {
    std::shared_ptr<const Geometry> geometry;
    LedgerEntry memory;
  };
  using Distribution =
      std::tuple<std::string, uint64_t, Generation, std::array<double, 4>>;  ///< tenant, key... radii
  struct Made {
    SceneMemory::Entries memory;
    std::vector<std::shared_ptr<const Distributed>> geometry;
    std::weak_ptr<const CompiledScene> scene;
  };
  std::map<SceneId, Made> made_;
  SharedBy<Distribution, Distributed> distributed_;
  SceneMemory memory_;
};

}  // namespace gxy::viewer

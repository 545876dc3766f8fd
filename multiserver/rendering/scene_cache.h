// SPDX-License-Identifier: Apache-2.0
// The cache of scenes. All ranks build a scene once, and all frames of a tenant that show it share it.
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
#include "multiserver/rendering/kept_data.h"
#include "multiserver/server/datasets.h"
#include "multiserver/server/module.h"

namespace gxy {

/// Rank 0's handle of a scene that all ranks hold. When the last handle goes, all ranks forget the scene.
struct SceneHandle {
  SceneHandle(ServerRank& serverRank, SceneId id) : serverRank(serverRank), id(id) {}
  ~SceneHandle();
  SceneHandle(const SceneHandle&) = delete;
  SceneHandle& operator=(const SceneHandle&) = delete;

  ServerRank& serverRank;
  const SceneId id;
  std::vector<NamedDataset> data;  ///< by operator, with the generations that the scene shows

  /// The dataset with this key, and of this generation if one is given. Null if the scene does not show it.
  const NamedDataset* find(Key key, std::optional<Generation> generation = {}) const;
};
using ScenePtr = std::shared_ptr<const SceneHandle>;

/// Why one picture cannot show two datasets whose domain is cut in different ways.
std::string textOfTwoPartitionings(const std::string& first, const std::string& other);

/// Builds scenes and keeps track of those that there are. There is one on each rank (Rendering). Thread safe.
class SceneCache {
 public:
  explicit SceneCache(Registration& registration);

  struct Pinned {
    ScenePtr scene;
    std::vector<Pin> pins;  ///< of its data
  };
  /// The data of an operator that its name does not say.
  struct Given {
    std::shared_ptr<const KeptData> data;
    glm::dvec4 color{0.8, 0.8, 0.8, 1};  ///< of geometry without values, whatever the dataset says
    bool operator==(const Given&) const = default;
  };
  using GivenData = std::vector<Given>;  ///< by operator
  /// Rank 0: returns a scene of a visualization of the tenant's data, and pins the generations that the scene
  /// shows.
  ///
  /// `known`, if not null, is a scene that get() has returned for the same visualization and settings. It is
  /// returned with the generations that it shows, pinned, if they are still there and its names still mean
  /// its objects. get() does not look whether there are newer generations: whoever keeps a `known` scene
  /// decides when to let go of it.
  ///
  /// Otherwise a scene of the current generations is returned: one of the same tenant and content if there is
  /// one. If that scene is still being built, all callers wait for it and are told its progress; when none of
  /// them wants it any more, all ranks give it up. Otherwise all ranks build a new scene.
  ///
  /// `pinned`, if not null, holds the generations that a new scene shows of the datasets that it has; of others it shows the newest.
  ///
  /// Ranges and radii that the visualization takes from its data follow the data and all that was shown before. `shown` holds
  /// what was shown before, and the data widen it. A `known` scene has widened it already.
  ///
  /// `given`, if not null, are the data of the operators, whatever their names mean. A `known` scene is returned if it shows these.
  ///
  /// Waits; the asker must live as long. Throws Error for data that do not exist or do not fit. Throws soon what
  /// `asker.check` throws; the last caller who waits throws it once no rank holds anything of the scene.
  Pinned get(const std::string& tenant, const Visualization& visualization, const RenderSettings& settings,
             const Asker& asker, ShownSoFar& shown, const ScenePtr& known = nullptr,
             const PinnedData* pinned = nullptr, const GivenData* given = nullptr);
  /// Rank 0: pins the generations that a scene shows. Nothing if they have gone, or if its names do not mean its objects any more.
  std::optional<Pinned> pin(const std::string& tenant, const ScenePtr& scene) const;
  /// Rank 0: widens `shown` as get() would. Throws Error for data that do not exist.
  void widen(const std::string& tenant, const Visualization& visualization, ShownSoFar& shown,
             const GivenData* given = nullptr) const;
  /// Every rank: returns a scene that rank 0 has a handle of. Throws Error if all handles have gone.
  std::shared_ptr<const CompiledScene> compiled(SceneId id);
  /// Rank 0: whether these names mean these objects to the tenant now, of whatever generation.
  bool namesMean(const std::string& tenant, const std::vector<NamedDataset>& data) const;

 private:
  /// A visualization with the data that it shows, pinned, and with numbers where it takes ranges and radii from them.
  struct HeldData {
    std::vector<NamedDataset> data;
    std::vector<ObjectGeneration> where;  ///< they are now
    std::vector<Pin> pins;
    Visualization resolved;
  };
  std::pair<std::vector<ObjectGeneration>, std::vector<Pin>> pinnedOf(const GivenData& given) const;
  HeldData hold(const std::string& tenant, const Visualization& visualization, ShownSoFar& shown,
                const PinnedData* pinned, const GivenData* given) const;
  SceneSource sourceOf(const nlohmann::json& parameters) const;
  nlohmann::json make(const nlohmann::json& parameters);
  nlohmann::json forget(const nlohmann::json& parameters);
  /// Rank 0: a scene that is being built, and the callers that wait for it. mutex_ guards all but `wanted`.
  struct Making {
    std::vector<const Asker*> askers;
    std::atomic<bool> wanted =
        true;  ///< by any asker; false: the building ends, and nobody else may wait for it
    uint64_t exchange = 0;
    bool ended = false;
    ScenePtr scene;     ///< when it has ended; null: it has failed
    std::string error;  ///< why it has failed
    const std::chrono::steady_clock::time_point begin = std::chrono::steady_clock::now();
    int64_t told = 0;  ///< units of progress that the askers were told of; 0: none so far
  };
  using MakingPtr = std::shared_ptr<Making>;
  void start(const MakingPtr& making, const std::string& content, const std::string& tenant,
             const std::string& text, const HeldData& held, const GivenData* given);
  void end(const MakingPtr& making, const std::string& content, ScenePtr scene, const std::string& error);
  void tell(Making& making, int64_t done, int64_t of, const std::string& text, bool phase);
  ScenePtr waitFor(const MakingPtr& making, const std::string& content, const Asker& asker);
  ScenePtr getOf(const std::string& tenant, const State& state, const HeldData& held, const GivenData* given,
                 const Asker& asker);

  ServerRank& serverRank_;
  std::mutex mutex_;
  std::map<std::string, std::weak_ptr<const SceneHandle>> known_;  ///< rank 0: by content
  std::map<std::string, MakingPtr> underWay_;                      ///< rank 0: by content
  std::condition_variable ended_;  ///< notified when one of underWay_ has ended
  SceneId next_ = 1;               ///< rank 0
  SceneBuilder builder_;
  std::map<SceneId, BuiltScene> built_;  ///< every rank: the scenes that rank 0 has handles of
};

}  // namespace gxy

// SPDX-License-Identifier: Apache-2.0
// Loads the data of a state, partitions them and compiles scenes, on all ranks together.
#pragma once
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/analysis/filter.h"
#include "core/comm/collectives.h"
#include "core/io/import_volume.h"
#include "core/look/loaded_facts.h"
#include "core/render/scene_builder.h"
#include "core/scene/state_pictures.h"
#include "core/space/ledger.h"
#include "tools/gxyrender/options.h"

namespace gxy {

inline constexpr const char* kTenant = "batch";  ///< tenant in the ledger

/// The loaded data of a state's visualizations.
struct LoadedState {
  std::shared_ptr<const Partitioning> partitioning;
  std::vector<std::vector<OperatorData>> data;  ///< by visualization, then operator
  /// By volume: the components of its file that were loaded. Volumes with all components are not listed.
  std::map<std::string, std::vector<int>> components;
  std::map<std::string, DataFacts> facts;  ///< by dataset
  std::vector<ShownSoFar> shown;           ///< by visualization
  std::map<std::string, std::shared_ptr<const Dataset>>
      datasets;                                  ///< all that were read or made, with their memory
  std::vector<DistributedGeometryPtr> geometry;  ///< that `data` show
  LeftOut leftOut;

  /// Returns visualization v of a state after resolved(), with component numbers that refer to the loaded
  /// components. The state must not show more than the one that was loaded.
  Visualization visualization(const State& state, size_t v) const;
  /// Returns the camera of a picture of such a state, after fitted().
  Camera camera(const StatePicture& picture) const {
    return fitted(picture.camera, shown[picture.visualization].box);
  }

 private:
  Visualization withKeptComponents(Visualization visualization) const;
  std::vector<DataFacts> factsFor(const Visualization& visualization) const;
  friend LoadedState loadData(const State&, const std::string&, const RenderOptions&, Collectives&, Ledger&,
                              std::vector<ShownSoFar>, const Filters&, const FilterServices&);
};

/// Loads the datasets that operators show, and evaluates the filters that they need; of volumes that no filter reads it keeps only
/// the components that are shown. File names are relative to `directory`. `shown` is what earlier time steps of the same
/// visualizations have shown. `services` are what filters are given; without `takeMemory`, memory is entered in the ledger.
/// Collective: all ranks call it. Throws the same Error on all ranks.
LoadedState loadData(const State& state, const std::string& directory, const RenderOptions& options,
                     Collectives& ranks, Ledger& ledger, std::vector<ShownSoFar> shown = {},
                     const Filters& filters = standardFilters(), const FilterServices& services = {});

/// Collective: what visualization v of such a state is built of. Throws the same Error on all ranks.
SceneSource sceneSource(const State& state, const LoadedState& loaded, size_t v, Collectives& ranks);

}  // namespace gxy

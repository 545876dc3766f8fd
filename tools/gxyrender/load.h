// SPDX-License-Identifier: Apache-2.0
// From a state to scenes on a backend: data imported, partitioned and compiled, on all ranks together.
#pragma once
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/io/collectives.h"
#include "core/io/import_volume.h"
#include "core/look/loaded_facts.h"
#include "core/rays/backend.h"
#include "core/rays/compiled_scene.h"
#include "core/space/ledger.h"
#include "tools/gxyrender/options.h"

namespace gxy {

inline constexpr const char* kTenant = "batch";  ///< in the ledger

/// The data of a state's visualizations, by operator.
struct LoadedState {
  std::shared_ptr<const Partitioning> partitioning;
  std::vector<std::vector<OperatorData>> data;  ///< by visualization, then operator
  /// By volume: those of its file's components that it has, where these are not all.
  std::map<std::string, std::vector<int>> components;
  std::map<std::string, DataFacts> facts;  ///< by dataset
  std::vector<ShownSoFar> shown;           ///< by visualization
  std::vector<LedgerEntry> memory;
  LeftOut leftOut;

  /// Visualization v of a state that shows no more than the one that was loaded, its components counted among
  /// those that there are, with numbers for what it asks of the data.
  Visualization visualization(const State& state, size_t v) const;
  /// Camera c of such a state, as it sees visualization v.
  Camera camera(const State& state, size_t v, size_t c) const {
    return fitted(state.cameras[c], shown[v].box);
  }

 private:
  Visualization withKeptComponents(Visualization visualization) const;
  std::vector<DataFacts> factsFor(const Visualization& visualization) const;
  friend LoadedState loadData(const State&, const std::string&, const RenderOptions&, Collectives&, Ledger&,
                              std::vector<ShownSoFar>);
};

/// Collective. File names are relative to `directory`. Only what some operator shows is read, and of
/// volumes only the components that are shown are kept. `shown`: what earlier steps of the same visualizations have shown.
/// Throws the same Error on all ranks.
LoadedState loadData(const State& state, const std::string& directory, const RenderOptions& options,
                     Collectives& ranks, Ledger& ledger, std::vector<ShownSoFar> shown = {});

/// Collective: compiles visualization v, taking plans from `others` (compileScene), and agrees on which partitions
/// can be seen.
std::shared_ptr<const CompiledScene> makeScene(
    const State& state, const LoadedState& loaded, size_t v, Collectives& ranks,
    std::span<const std::shared_ptr<const CompiledScene>> others = {});

}  // namespace gxy

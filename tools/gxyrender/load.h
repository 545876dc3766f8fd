// SPDX-License-Identifier: Apache-2.0
// From a state to scenes on a backend: data imported, partitioned and compiled, on all ranks together.
#pragma once
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "gxy/io/collectives.h"
#include "gxy/io/import_volume.h"
#include "gxy/rays/backend.h"
#include "gxy/rays/compiled_scene.h"
#include "gxy/space/ledger.h"
#include "options.h"

namespace gxy {

inline constexpr const char* kTenant = "batch";  ///< in the ledger

/// The data of a state's visualizations, by operator.
struct LoadedState {
  std::shared_ptr<const Partitioning> partitioning;
  std::vector<std::vector<OperatorData>> data;  ///< by visualization, then operator
  /// By volume: those of its file's components that it has, where these are not all.
  std::map<std::string, std::vector<int>> components;
  std::vector<LedgerEntry> memory;
  LeftOut leftOut;

  /// Visualization v of a state that shows no more than the one that was loaded, its components counted among
  /// those that there are.
  Visualization visualization(const State& state, size_t v) const;
};

/// Collective. File names are relative to `directory`. Only what some operator shows is read, and of
/// volumes only the components that are shown are kept. Throws the same Error on
/// all ranks.
LoadedState loadData(const State& state, const std::string& directory, const RenderOptions& options,
                     Collectives& ranks, Ledger& ledger);

/// Collective: compiles visualization v, taking plans from `others` (compileScene), and agrees on which partitions
/// can be seen.
std::shared_ptr<const CompiledScene> makeScene(
    const State& state, const LoadedState& loaded, size_t v, Collectives& ranks,
    std::span<const std::shared_ptr<const CompiledScene>> others = {});

}  // namespace gxy

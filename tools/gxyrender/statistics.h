// SPDX-License-Identifier: Apache-2.0
// What --stats writes.
#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/comm/transport.h"
#include "core/io/import_volume.h"
#include "core/render/renderer.h"
#include "core/space/ledger.h"

namespace gxy {

/// Seconds of the phases of a run, on one rank.
struct Phases {
  double load = 0, compile = 0, render = 0, total = 0;
  double cpuRender = 0;    ///< processor time of all threads
  double cpuPictures = 0;  ///< of that, of writing pictures' files
  std::vector<double>
      compileEach;  ///< of `compile`, by visualization: those behind the first find the data there
};

double wallSeconds();
double cpuSeconds();
double threadCpuSeconds();

/// What was left out before anything was traced.
struct LeftBefore {
  LeftOut data;
  uint64_t isoCells = 0;  ///< CompiledScene::isoCellsSkipped
};

/// Counters of this rank. `residentBefore`: memory of the process before it read any data.
nlohmann::json statisticsOf(const Renderer::Counters& counters, const Transport::Counters& transport,
                            const Phases& phases, const LeftBefore& before, const Ledger& ledger,
                            int64_t residentBefore);

/// Writes {"run": ..., "ranks": [...]}. Throws Error when the file cannot be written.
void writeStatistics(const std::string& path, const nlohmann::json& run,
                     const std::vector<nlohmann::json>& ranks);

}  // namespace gxy

// SPDX-License-Identifier: Apache-2.0
// The statistics that the option --stats writes.
#pragma once
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/comm/mpi_transport.h"
#include "core/comm/transport.h"
#include "core/io/import_volume.h"
#include "core/render/renderer.h"
#include "core/space/ledger.h"

namespace gxy {

/// Seconds of the phases of a run on one rank.
struct Phases {
  double load = 0, compile = 0, render = 0, total = 0;
  double cpuRender = 0;    ///< processor time of all threads in `render`
  double cpuPictures = 0;  ///< the part of cpuRender that was spent on writing files of pictures
  /// The parts of `compile`, by visualization. Those after the first reuse its data.
  std::vector<double> compileEach;
};

double wallSeconds();
double cpuSeconds();
double threadCpuSeconds();

/// Data and cells that were left out before tracing.
struct LeftBefore {
  LeftOut data;
  uint64_t isoCells = 0;  ///< CompiledScene::isoCellsSkipped
};

/// Returns the statistics of this rank. `residentBefore` is the memory of the process in bytes before it read data.
nlohmann::json statisticsOf(const Renderer::Counters& counters, const Transport::Counters& transport,
                            const Phases& phases, const LeftBefore& before, const Ledger& ledger,
                            int64_t residentBefore);

/// Returns, for `messages` of the statistics, what this rank has sent to others and received, by kind, and the number of ranks that it
/// has exchanged messages with.
nlohmann::json trafficOf(const std::map<Channel, MpiTransport::Traffic>& byChannel, int partners);

/// Writes {"run": ..., "ranks": [...]}. Throws Error if the file cannot be written.
void writeStatistics(const std::string& path, const nlohmann::json& run,
                     const std::vector<nlohmann::json>& ranks);

}  // namespace gxy

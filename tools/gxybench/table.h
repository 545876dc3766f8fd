// SPDX-License-Identifier: Apache-2.0
// What gxybench measures, one row a run, and its CSV.
#pragma once
#include <cstdint>
#include <fstream>
#include <string>
#include <vector>

namespace gxy::bench {

/// One scene with one method at one setting, on one backend and number of ranks. Times are of a frame, from
/// its start to its delivered picture, after all is loaded and compiled; counters are of one frame, over all
/// ranks.
struct Row {
  std::string scene, method, setting, backend;
  int64_t ranks = 1, threads = 1;  ///< threads of each rank
  int64_t width = 0, height = 0;
  double tolerance = 0;  ///< that the picture is held to, or flips told by
  int64_t repeats = 0;
  double wall = 0, wallSpread = 0;  ///< seconds: median of the repeats; largest - smallest
  double cpu = 0, cpuSpread = 0;    ///< processor seconds of all threads of all ranks
  int64_t samples = 0, macrocells = 0, cells = 0,
          rays = 0;        ///< cells: of the isosurface walk; rays: with secondaries
  int64_t bytesSent = 0;   ///< rays and contributions, to other ranks
  int64_t bytesHeld = 0;   ///< data and compiled scene, of all ranks
  int64_t peakMemory = 0;  ///< of the process that had most
  double maxError = 0, rmsError = 0,
         p999Error = 0;  ///< over RGB, flips left out; p999: of the pixels' worst channel
  int64_t flips = 0;
  /// Scenes of isosurfaces alone; hits is -1 for others. dt: distance along the ray from the true hit, in
  /// cells.
  int64_t hits = -1, missed = 0, extra = 0, wrongSheet = 0;
  double dtRms = 0, dtMax = 0;

  /// Which curve of its scene the row is on.
  std::string curve() const {
    return method + ", " + backend + ", " + std::to_string(ranks) + (ranks == 1 ? " rank" : " ranks");
  }
  bool operator==(const Row&) const = default;
};

/// Calls f(column, member) for every column, in order.
template <class AnyRow, class F>
void forEachColumn(AnyRow& r, F f) {
  f("scene", r.scene), f("method", r.method), f("setting", r.setting), f("backend", r.backend);
  f("ranks", r.ranks), f("threads", r.threads), f("width", r.width), f("height", r.height);
  f("tolerance", r.tolerance), f("repeats", r.repeats);
  f("wall_s", r.wall), f("wall_spread_s", r.wallSpread), f("cpu_s", r.cpu), f("cpu_spread_s", r.cpuSpread);
  f("samples", r.samples), f("macrocells", r.macrocells), f("cells", r.cells), f("rays", r.rays);
  f("bytes_sent", r.bytesSent), f("bytes_held", r.bytesHeld), f("peak_memory", r.peakMemory);
  f("max_error", r.maxError), f("rms_error", r.rmsError), f("p999_error", r.p999Error), f("flips", r.flips);
  f("hits", r.hits), f("missed", r.missed), f("extra", r.extra), f("wrong_sheet", r.wrongSheet);
  f("dt_rms_cells", r.dtRms), f("dt_max_cells", r.dtMax);
}

/// Writes rows as they come: what has been measured is in the file whenever a run is interrupted.
class TableWriter {
 public:
  explicit TableWriter(const std::string& path);
  void add(const Row& row);

 private:
  std::string path_;
  std::ofstream out_;
};

/// Throws Error "PATH:LINE: ..." for what is not such a table. Columns may stand in any order; others are
/// ignored.
std::vector<Row> readTable(const std::string& path);

}  // namespace gxy::bench

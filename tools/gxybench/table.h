// SPDX-License-Identifier: Apache-2.0
// The table of what gxybench measures, one row per run, and its CSV file.
#pragma once
#include <cstdint>
#include <fstream>
#include <string>
#include <vector>

namespace gxy::bench {

/// One scene with one method at one setting, on one backend and number of ranks. Times are of a frame, from
/// its start to its delivered picture, after everything is loaded and compiled. Counters are of one frame,
/// over all ranks.
struct Row {
  std::string scene, method, setting, backend;
  int64_t ranks = 1, threads = 1;  ///< threads of each rank
  int64_t width = 0, height = 0;
  double tolerance = 0;  ///< what the picture must keep, or what flips are judged by
  int64_t repeats = 0;
  double wall = 0, wallSpread = 0;  ///< seconds: median of the repeats, and largest - smallest
  double cpu = 0, cpuSpread = 0;    ///< processor seconds of all threads of all ranks, likewise
  /// `cells` are of the isosurface walk; `rays` include secondaries.
  int64_t samples = 0, macrocells = 0, cells = 0, rays = 0;
  int64_t bytesSent = 0;   ///< bytes of rays and contributions sent to other ranks
  int64_t bytesHeld = 0;   ///< bytes of data and compiled scene, on all ranks
  int64_t peakMemory = 0;  ///< bytes, of the process that had most
  /// Over RGB, without flips; p999: 99.9 % of the pixels' worst channels are below it.
  double maxError = 0, rmsError = 0, p999Error = 0;
  int64_t flips = 0;
  /// Only for scenes of isosurfaces alone; hits is -1 for others. dt is the distance along the ray from the
  /// true hit, in cells.
  int64_t hits = -1, missed = 0, extra = 0, wrongSheet = 0;
  double dtRms = 0, dtMax = 0;

  /// The curve of its scene that the row is on.
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

/// Writes rows as they arrive, so that an interrupted run leaves in the file what it has measured.
class TableWriter {
 public:
  explicit TableWriter(const std::string& path);
  void add(const Row& row);

 private:
  std::string path_;
  std::ofstream out_;
};

/// Reads a table. Columns may stand in any order, and unknown ones are ignored. Throws Error "PATH:LINE: ..."
/// for what is not such a table.
std::vector<Row> readTable(const std::string& path);

}  // namespace gxy::bench

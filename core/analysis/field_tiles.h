// SPDX-License-Identifier: Apache-2.0
// Runs a pass over the points of one rank, tile by tile, on the threads of the task arena. Used inside core/analysis only.
#pragma once
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "core/analysis/field_passes.h"
#include "core/comm/collectives.h"
#include "core/data/volume.h"

namespace gxy {

/// The points of a grid that have data of their own. In a grid with a rim, the outermost points repeat their neighbours, and are
/// not among them.
struct DataPoints {
  Index3 first, last;
  explicit DataPoints(const Grid& grid);
  int64_t nearest(int axis, int64_t i) const;
  bool contain(int axis, int64_t i) const { return i >= first[size_t(axis)] && i <= last[size_t(axis)]; }
};

/// What is told about the results of a pass, of the points that are owned and have data of their own.
struct FieldResults {
  FieldStatistics statistics;  ///< of Float32, as completeBricks() wants them
  int64_t noData = 0;          ///< points where a component has no data
};

/// One pass over this rank's blocks.
class FieldTiles {
 public:
  /// `fields` are the sources of the pass. `target` has a block, in bricks, of type Float32, Float64 or UInt8, for each of theirs;
  /// `owned` are the points of each that are computed: owned points, moved to the nearest DataPoints. All outlive the object.
  FieldTiles(const FieldPass& pass, std::span<const Volume* const> fields, Volume& target,
             const std::map<int, Extent>& computed, const std::map<int, Extent>& owned,
             const std::function<void(int64_t)>& memory);
  ~FieldTiles();

  /// Computes everything. Does not communicate. Calls ranks.check() after each plane of a tile, and advance(done).
  FieldResults run(const Advance& advance);

 private:
  struct Tile;
  class Workspace;

  std::unique_ptr<Workspace> take();
  void give(std::unique_ptr<Workspace> workspace);

  const FieldPass& pass_;
  const std::span<const Volume* const> fields_;
  Volume& target_;
  const std::map<int, Extent>&computed_, &owned_;
  const std::function<void(int64_t)>& memory_;
  const DataPoints data_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<Workspace>> free_;
  int64_t workspaceBytes_ = 0;  ///< told to memory_
  FieldResults results_;
};

/// Has the processor round to nearest and keep denormal numbers, on this thread, as long as it lives.
class PlainArithmetic {
 public:
  PlainArithmetic();
  ~PlainArithmetic();
  PlainArithmetic(const PlainArithmetic&) = delete;
  PlainArithmetic& operator=(const PlainArithmetic&) = delete;

 private:
  unsigned before_;
};

}  // namespace gxy

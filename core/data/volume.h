// SPDX-License-Identifier: Apache-2.0
// Structured volumes: samples on the points of a regular grid, kept in one block per local partition.
#pragma once
#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "core/data/box.h"
#include "core/data/partitioning.h"
#include "core/data/scalar.h"

namespace gxy {

using Index3 = std::array<int64_t, 3>;

/// A regular grid: point (i, j, k) lies at origin + spacing * (i, j, k); spacing is positive; points >= 2 per
/// axis, or 3 with a rim.
struct Grid {
  glm::dvec3 origin{0};
  glm::dvec3 spacing{1};
  Index3 points{2, 2, 2};
  /// The points are centres of cells, and one layer more outside: what there is ends with the cells, half a spacing inside the
  /// outermost points.
  bool rim = false;

  Box box() const;  ///< what there is
  Index3 cells() const { return {points[0] - 1, points[1] - 1, points[2] - 1}; }
  bool operator==(const Grid&) const = default;
};

/// A box of grid points: `first` is the global index of its first point, `points` its size.
struct Extent {
  Index3 first{0, 0, 0};
  Index3 points{0, 0, 0};
  int64_t count() const { return points[0] * points[1] * points[2]; }
  bool operator==(const Extent&) const = default;
};

/// The points that partition box `part` needs of `grid`: all corners of the cells that it touches, and
/// `ghosts` more layers on each side, clipped to the grid. Empty (count 0) where the partition does not touch
/// the grid. A face within rounding (8 ulp of the coordinates) of a grid plane is on it, and does not touch
/// the cells beyond; but with ghosts, a partition less than a cell away from the grid gets the layers at its
/// end: rays round in float, and what they meet on the end of the grid may belong to that partition.
Extent extentOf(const Grid& grid, const Box& part, int ghosts);

/// The points of `grid` that count as the partition's own when something is summed over the grid, so that
/// each is counted once: those of extentOf(..., 0), the upper end left to the next partition except at the
/// domain's end.
Extent ownedPoints(const Grid& grid, const Partitioning& partitioning, int partition);

/// `parts` blocks of a grid, as decompose() shapes them, cut on grid points and shared among `ranks`.
Partitioning decomposed(const Grid& grid, int parts, int ranks);

inline constexpr int kGhostLayers = 4;  ///< see decisions/0001: a segment's sample and a gradient stay inside
inline constexpr int kMacrocellSize = 8;  ///< cells per macrocell and axis, aligned to the global grid

/// What is known of the samples of one macrocell (all corners of its 8^3 cells), in stored values per cell. Differences
/// that a sample without data takes part in do not count.
struct Macrocell {
  float min, max;  ///< over finite samples; min > max when there are none
  float steep;     ///< largest |first difference| along an axis
  float bend;      ///< largest |second difference|, along an axis or mixed (the twist of a cell's face)
  bool noData;     ///< holds a NaN or an infinity
  bool operator==(const Macrocell&) const = default;
};

/// The samples of one partition: ghosts included, stored type, the components of a point together. Points come x fastest;
/// completeBlock (macrocells.h) puts them into bricks (bricks.h), where they stay.
struct VolumeBlock {
  Extent extent;
  Samples samples;

  /// Macrocells that the extent touches: global index of the first and their number per axis, x fastest.
  /// Summaries are those of the *whole* macrocell, merged over all partitions that it crosses; one array per
  /// component, then, for more than one component, one of the magnitude.
  Index3 firstMacrocell{0, 0, 0};
  Index3 macrocells{0, 0, 0};
  std::vector<std::vector<Macrocell>> summaries;
};

/// A structured volume. `stored` is what the blocks hold: narrow types as in the file, Float32 for float
/// and wide types; values are shift + scale * stored (encodingOf()). Immutable once complete; safe to read from any
/// thread.
struct Volume {
  std::string name;
  Grid grid;
  ScalarType stored = ScalarType::Float32;
  int components = 1;
  double shift = 0, scale = 1;
  std::vector<Range>
      ranges;  ///< per component, of true values over the whole grid; then magnitude if components > 1
  int64_t noDataSamples = 0;          ///< samples that are NaN or infinite, over the whole grid
  std::map<int, VolumeBlock> blocks;  ///< by local partition
};

/// Memory of the local blocks: samples and macrocells.
int64_t bytesOf(const Volume& volume);

/// Statistics of a field, of values as they are in `samples` (interleaved); they merge by Range::extend and
/// addition.
struct FieldStatistics {
  std::vector<Range> ranges;  ///< per component; then of the magnitude if components > 1
  int64_t noDataSamples = 0;  ///< points with a NaN or infinite component
  void merge(const FieldStatistics& other);
};
FieldStatistics statisticsOf(std::span<const std::byte> samples, ScalarType type, int components);

/// The same over the points of `part` (inside `extent`) of samples that cover `extent`.
FieldStatistics statisticsOf(std::span<const std::byte> samples, ScalarType type, int components,
                             const Extent& extent, const Extent& part);

/// The same over all points of a complete block.
FieldStatistics statisticsOf(const VolumeBlock& block, ScalarType stored, int components);

}  // namespace gxy

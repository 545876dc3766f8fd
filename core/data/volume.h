// SPDX-License-Identifier: Apache-2.0
// Structured volumes: samples on the points of a regular grid, stored in one block per local partition.
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

/// A regular grid. Point (i, j, k) lies at origin + spacing * (i, j, k) in world coordinates. Spacing is
/// positive. There are at least 2 points per axis, or 3 with a rim.
struct Grid {
  glm::dvec3 origin{0};
  glm::dvec3 spacing{1};
  Index3 points{2, 2, 2};
  /// The points are the centres of the file's cells, and one additional layer around them. The data end where
  /// those cells do, half a spacing inside the outermost points.
  bool rim = false;

  Box box() const;  ///< bounding box of the data, world coordinates
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

/// Returns the points of `grid` that a partition with box `part` needs: all corners of the cells that it
/// touches, and `ghosts` more layers on each side, clipped to the grid. The extent is empty (count 0) if the
/// partition does not touch the grid. A face of the partition within rounding (8 ulp of the coordinates) of a
/// grid plane lies on the plane and does not touch the cells beyond. With ghosts, a partition less than a
/// cell away from the grid gets the layers at the grid's end: rays round in float, so a hit on the end of the
/// grid may belong to that partition.
Extent extentOf(const Grid& grid, const Box& part, int ghosts);

/// Returns the points of `grid` that belong to the partition in sums over the grid, so that each point is
/// counted once: those of extentOf(..., 0) without the upper end, which belongs to the next partition except
/// at the end of the domain or of the grid.
Extent ownedPoints(const Grid& grid, const Partitioning& partitioning, int partition);

/// Returns `parts` blocks of a grid, as decompose() shapes them, cut on grid points and distributed over
/// `ranks` ranks.
Partitioning decomposed(const Grid& grid, int parts, int ranks);

/// Enough for the samples and gradients of every segment that ends in the partition (docs/decisions/0001).
inline constexpr int kGhostLayers = 4;
inline constexpr int kMacrocellSize = 8;  ///< cells per macrocell and axis, aligned to the global grid

/// A summary of the samples of one macrocell (all corners of its 8^3 cells), in stored values. Differences
/// are per cell; those that involve a NaN or an infinity do not count.
struct Macrocell {
  float min, max;  ///< over finite samples; min > max if there are none
  float steep;     ///< largest |first difference| along an axis
  float bend;      ///< largest |second difference|, along an axis or mixed (the twist of a cell's face)
  bool noData;     ///< a sample is a NaN or an infinity
  bool operator==(const Macrocell&) const = default;
};

/// The samples of one partition, including ghosts, in the stored type. The components of a point stand
/// together. Points of a complete block lie in bricks (bricks.h).
struct VolumeBlock {
  Extent extent;
  Samples samples;

  /// The macrocells that the extent touches: global index of the first, and their number per axis.
  /// `summaries` has one array for each component, then one for the magnitude if there are several
  /// components. Each array has its macrocells x fastest. A summary is that of the *whole* macrocell, merged
  /// over all partitions that it crosses.
  Index3 firstMacrocell{0, 0, 0};
  Index3 macrocells{0, 0, 0};
  std::vector<std::vector<Macrocell>> summaries;
};

/// A structured volume. `stored` is the type of samples in blocks: narrow types as in the file, Float32 for
/// float and wide types. Values are shift + scale * stored (encodingOf()). It is immutable once complete; any
/// thread may read it.
struct Volume {
  std::string name;
  Grid grid;
  ScalarType stored = ScalarType::Float32;
  int components = 1;
  double shift = 0, scale = 1;
  /// Ranges of values (not stored values) over the whole grid: one for each component, then one for the
  /// magnitude if there are several.
  std::vector<Range> ranges;
  /// Whether they are the ranges of the values as they are stored, where those of the values themselves are not known.
  bool rangesOfStored = false;
  int64_t noDataSamples = 0;          ///< points with a NaN or infinite component, over the whole grid
  std::map<int, VolumeBlock> blocks;  ///< by local partition
};

/// Memory of the local blocks in bytes: samples and macrocells.
int64_t bytesOf(const Volume& volume);

/// Statistics of the values in `samples`, where the components of a point stand together. Statistics of parts
/// merge by Range::extend() and addition.
struct FieldStatistics {
  std::vector<Range> ranges;  ///< one per component, then one for the magnitude if components > 1
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

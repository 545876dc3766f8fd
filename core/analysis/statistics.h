// SPDX-License-Identifier: Apache-2.0
// Numbers of whole fields: extremes with their places, sums, moments, histograms and exact quantiles.
//
// Every point counts once. A grid's rim does not count: it repeats other points. Numbers have the same bits whatever the
// partitions, ranks, threads and order of points are: a sum is that of 128-bit integers in units of 2^-80 of the largest size that
// a value of the field has, and each value is rounded once.
#pragma once
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "core/comm/collectives.h"
#include "core/data/geometry.h"
#include "core/data/mesh.h"
#include "core/data/partitioning.h"
#include "core/data/volume.h"

namespace gxy {

struct StatisticsOptions {
  /// Which component of a volume; as many as it has: their magnitude, rounded to float.
  int component = 0;
  int bins = 0;                   ///< of the histogram, at most kMostBins; 0: there is none
  std::optional<Range> binRange;  ///< absent: from the least value to the largest
  std::vector<double> quantiles;  ///< fractions from 0 to 1
  static constexpr int kMostBins = 65536;
};

/// A value and where it is. Among equal values it is that at the lowest index: of a grid's points x + nx (y + ny z), of geometry the
/// lowest id, of a mesh the first along Morton's curve and then by x, y and z.
struct ExtremeValue {
  double value = 0;
  int64_t index = -1;
  glm::dvec3 position{0};  ///< world
};

struct Statistics {
  int64_t count = 0;            ///< values
  int64_t noData = 0;           ///< points without data, among those where the condition holds
  ExtremeValue least, largest;  ///< index -1 if there are no values
  double sum = 0;
  double mean = 0;  ///< NaN if there are no values
  double variance =
      0;  ///< mean square of the distance to the mean (divided by count); NaN if there are no values
  /// Of a volume: over the world, by the trapezoid rule; a point at an end of the grid counts half along that axis, and a cell's
  /// datum (Grid::rim) its whole cell. Of path lines: along the lines, by the trapezoid rule. Else 0.
  double integral = 0;
  double length = 0;  ///< of path lines: of all segments
  /// How many values are in each bin; a value on the edge between two is in the upper one, and the last bin has its upper end.
  std::vector<int64_t> histogram;
  Range binRange;
  /// Values at the fractions of the options, linear between neighbours in order (as numpy's default). NaN if there are no values.
  std::vector<double> quantiles;
};

/// Collective. Returns the numbers of a volume's component, on every rank. `where`, if it is not null, has a byte for each point,
/// and only points where it is not 0 count (conditionOf()); its blocks are the volume's. Calls ranks.check(). All ranks throw the
/// same Error if any fails: for a component that there is not, for too many bins, a range of bins without width, a fraction that is
/// not from 0 to 1, and a `where` with another grid.
Statistics fieldStatistics(const Volume& volume, const Partitioning& partitioning, Collectives& ranks,
                           const StatisticsOptions& options = {}, const Volume* where = nullptr);

/// Collective. The same of an unstructured volume: of its values at points, each point once on whichever partitions and ranks it is, or, if its data
/// are those of cells, of those, each cell once. There is no integral, and extremes have the index 0.
Statistics meshStatistics(const Mesh& mesh, const Partitioning& partitioning, Collectives& ranks,
                          const StatisticsOptions& options = {});

/// Collective. The same of the values at points of geometry, of which each rank gives what it owns. Path lines: each point once
/// among the segments of a rank's block; `length` and `integral` are those of segments.
Statistics geometryStatistics(const GeometryBlock& block, GeometryKind kind, Collectives& ranks,
                              const StatisticsOptions& options = {});

}  // namespace gxy

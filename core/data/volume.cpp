// SPDX-License-Identifier: Apache-2.0
#include "core/data/volume.h"

#include <cmath>
#include <cstring>

#include "core/comm/error.h"
#include "core/data/bricks.h"

namespace gxy {
namespace {

/// Returns world coordinate x in units of the grid's points. A coordinate on a grid plane within rounding
/// gives the exact number of the plane.
double planeOf(const Grid& grid, int axis, double x) {
  const double origin = grid.origin[axis], spacing = grid.spacing[axis];
  const double index = (x - origin) / spacing;
  const double plane = std::round(index);
  const double ulps = 8 * std::numeric_limits<double>::epsilon();
  const double rounding = ulps * (std::max(std::abs(x), std::abs(origin)) / spacing + std::abs(index));
  // Coordinates so far from the origin that a cell is a few ulp wide are not snapped across half a cell.
  return std::abs(index - plane) <= std::min(rounding, 0.25) ? plane : index;
}

/// Statistics of rows of points. Samples from a file may be unaligned, so they are read by memcpy.
template <typename T>
class RowStatistics {
 public:
  explicit RowStatistics(int components) : components_(components) {
    statistics_.ranges.resize(components > 1 ? size_t(components) + 1 : 1);
  }

  void add(const std::byte* samples, int64_t points) {
    if (components_ == 1) return addScalars(samples, points);
    for (int64_t x = 0; x < points; ++x) {
      double squares = 0;
      bool finite = true;
      for (int c = 0; c < components_; ++c, samples += sizeof(T)) {
        T sample;
        std::memcpy(&sample, samples, sizeof(T));
        const double value = double(sample);
        statistics_.ranges[size_t(c)].extend(value);
        squares += value * value;
        finite &= value - value == 0;
      }
      statistics_.ranges.back().extend(std::sqrt(squares));
      if (!finite) ++statistics_.noDataSamples;
    }
  }

  FieldStatistics take() { return std::move(statistics_); }

 private:
  /// Adds points with one component, in lanes without branches, so that compilers vectorise the loop.
  void addScalars(const std::byte* samples, int64_t points) {
    constexpr int64_t kLanes = 16;
    using Limits = std::numeric_limits<T>;
    std::array<T, kLanes> lo, hi;
    std::array<int64_t, kLanes> bad{};
    lo.fill(Limits::has_infinity ? Limits::infinity() : Limits::max());
    hi.fill(Limits::has_infinity ? -Limits::infinity() : Limits::lowest());
    const T none[2] = {lo[0], hi[0]};
    int64_t x = 0;
    for (; x + kLanes <= points; x += kLanes) {
      std::array<T, kLanes> v;
      std::memcpy(v.data(), samples + size_t(x) * sizeof(T), sizeof v);
      for (size_t i = 0; i < kLanes; ++i) {
        const bool finite = v[i] - v[i] == 0;
        const T below = finite ? v[i] : none[0], above = finite ? v[i] : none[1];
        lo[i] = below < lo[i] ? below : lo[i];
        hi[i] = above > hi[i] ? above : hi[i];
        bad[i] += finite ? 0 : 1;
      }
    }
    Range& range = statistics_.ranges[0];
    for (size_t i = 0; i < kLanes && x > 0; ++i) {
      range.extend(double(lo[i]));
      range.extend(double(hi[i]));
      statistics_.noDataSamples += bad[i];
    }
    for (; x < points; ++x) {
      T v;
      std::memcpy(&v, samples + size_t(x) * sizeof(T), sizeof(T));
      range.extend(double(v));
      if (!(v - v == 0)) ++statistics_.noDataSamples;
    }
  }

  const int components_;
  FieldStatistics statistics_;
};

}  // namespace

Box Grid::box() const {
  const double inside = rim ? 0.5 : 0;
  Box b;
  for (int a = 0; a < 3; ++a) {
    b.lo[a] = origin[a] + spacing[a] * inside;
    b.hi[a] = origin[a] + spacing[a] * (double(points[a] - 1) - inside);
  }
  return b;
}

Extent extentOf(const Grid& grid, const Box& part, int ghosts) {
  const double nearby = ghosts > 0 ? 1 : 0;
  Extent extent;
  for (int a = 0; a < 3; ++a) {
    const double lo = planeOf(grid, a, part.lo[a]), hi = planeOf(grid, a, part.hi[a]);
    const int64_t end = grid.points[a] - 1;
    if (!(lo < double(end) + nearby && hi > -nearby)) return {};
    const double first = std::floor(std::clamp(lo, -1.0, double(end))) - ghosts;
    const double last = std::ceil(std::clamp(hi, 0.0, double(end) + 1)) + ghosts;
    extent.first[a] = std::clamp<int64_t>(int64_t(first), 0, end - 1);
    extent.points[a] = std::clamp<int64_t>(int64_t(last), 1, end) - extent.first[a] + 1;
  }
  return extent;
}

Extent ownedPoints(const Grid& grid, const Partitioning& partitioning, int partition) {
  const Box& part = partitioning.box(partition);
  Extent owned = extentOf(grid, part, 0);
  if (owned.count() == 0) return {};
  for (int a = 0; a < 3; ++a) {
    const double lo = planeOf(grid, a, part.lo[a]), hi = planeOf(grid, a, part.hi[a]);
    int64_t first = owned.first[a], end = first + owned.points[a];
    if (part.lo[a] > partitioning.domain().lo[a]) first = std::max(first, int64_t(std::ceil(lo)));
    const bool last = part.hi[a] >= partitioning.domain().hi[a] || hi >= double(grid.points[a] - 1);
    if (!last) end = std::min(end, int64_t(std::ceil(hi)));
    if (first >= end) return {};
    owned.first[a] = first;
    owned.points[a] = end - first;
  }
  return owned;
}

Partitioning decomposed(const Grid& grid, int parts, int ranks) {
  const Box box = grid.box();
  Index3 cells = grid.cells();
  if (grid.rim)
    for (int64_t& n : cells) --n;
  const std::array<int, 3> blocks = decompose(parts, cells);
  std::array<std::vector<double>, 3> faces;
  for (int a = 0; a < 3; ++a) faces[a] = evenFaces(box.lo[a], box.hi[a], blocks[a], cells[a]);
  return Partitioning::lattice(std::move(faces), ranks);
}

void FieldStatistics::merge(const FieldStatistics& other) {
  if (ranges.size() < other.ranges.size()) ranges.resize(other.ranges.size());
  for (size_t r = 0; r < other.ranges.size(); ++r) ranges[r].extend(other.ranges[r]);
  noDataSamples += other.noDataSamples;
}

FieldStatistics statisticsOf(std::span<const std::byte> samples, ScalarType type, int components) {
  const size_t point = bytesOf(type) * size_t(std::max(components, 1));
  const Extent line{{0, 0, 0}, {int64_t(samples.size() / point), 1, 1}};
  return statisticsOf(samples, type, components, line, line);
}

FieldStatistics statisticsOf(std::span<const std::byte> samples, ScalarType type, int components,
                             const Extent& extent, const Extent& part) {
  if (components < 1 || samples.size() != size_t(extent.count()) * size_t(components) * bytesOf(type)) {
    throw Error("samples: " + std::to_string(samples.size()) + " bytes, expected " +
                std::to_string(extent.count()) + " points of " + std::to_string(components) + " x " +
                nameOf(type));
  }
  FieldStatistics statistics;
  statistics.ranges.resize(components > 1 ? size_t(components) + 1 : 1);
  if (part.count() == 0) return statistics;
  withType(type, [&](auto t) {
    using T = decltype(t);
    RowStatistics<T> rows(components);
    for (int64_t z = part.first[2]; z < part.first[2] + part.points[2]; ++z) {
      for (int64_t y = part.first[1]; y < part.first[1] + part.points[1]; ++y) {
        const int64_t row =
            ((z - extent.first[2]) * extent.points[1] + y - extent.first[1]) * extent.points[0] +
            part.first[0] - extent.first[0];
        rows.add(samples.data() + size_t(row) * size_t(components) * sizeof(T), part.points[0]);
      }
    }
    statistics = rows.take();
  });
  return statistics;
}

FieldStatistics statisticsOf(const VolumeBlock& block, ScalarType stored, int components) {
  const Bricks bricks(block.extent.points);
  const Index3& n = block.extent.points;
  return withType(stored, [&](auto t) {
    using T = decltype(t);
    RowStatistics<T> rows(components);
    const size_t point = sizeof(T) * size_t(components);
    for (int64_t z = 0; z < n[2]; ++z)
      for (int64_t y = 0; y < n[1]; ++y)
        bricks.alongX(0, y, z, n[0], [&](size_t place, int64_t, int64_t count) {
          rows.add(block.samples.data() + place * point, count);
        });
    return rows.take();
  });
}

int64_t bytesOf(const Volume& volume) {
  size_t bytes = 0;
  for (const auto& [partition, block] : volume.blocks) {
    bytes += block.samples.size();
    for (const auto& summary : block.summaries) bytes += summary.size() * sizeof(Macrocell);
  }
  return int64_t(bytes);
}

}  // namespace gxy

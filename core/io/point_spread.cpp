// SPDX-License-Identifier: Apache-2.0
#include "core/io/point_spread.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <span>
#include <vector>

#include "core/comm/parallel_for.h"

namespace gxy {
namespace {

constexpr size_t kBins = 1024;
constexpr int kRounds = 3;  // Each round divides the inner interval of the previous one into bins.

/// The numbers of points below, in and above the bins of an interval, on one axis.
struct Counts {
  double lo = 0, hi = 0;
  std::array<uint64_t, kBins + 2> bins{};

  void add(double x) {
    if (x < lo) return void(bins.front()++);
    if (x > hi) return void(bins.back()++);
    const double place = hi > lo ? (x - lo) / (hi - lo) * double(kBins) : 0;
    bins[1 + std::min(size_t(place), kBins - 1)]++;
  }
  /// The interval of the bins that contain the points without the lowest and the highest hundredth.
  std::array<double, 2> hundredths() const {
    uint64_t all = 0;
    for (const uint64_t n : bins) all += n;
    const uint64_t skipped = all / 100;
    size_t first = 1, last = kBins;
    for (uint64_t below = bins.front(); first < kBins && below + bins[first] <= skipped; first++)
      below += bins[first];
    for (uint64_t above = bins.back(); last > first && above + bins[last] <= skipped; last--)
      above += bins[last];
    const double width = (hi - lo) / double(kBins);
    return {lo + width * double(first - 1), last == kBins ? hi : lo + width * double(last)};
  }
};
using Axes = std::array<Counts, 3>;

Counts sumOf(Counts a, const Counts& b) {
  std::ranges::transform(a.bins, b.bins, a.bins.begin(), std::plus<>());
  return a;
}

void count(const LoadedGeometry& loaded, Collectives& ranks, Axes& axes) {
  const GeometryBlock& block = loaded.geometry.block;
  // Each of some threads counts a part of the primitives for itself. Sums of integers are the same in any order.
  constexpr size_t kParts = 64;
  const size_t all = block.ids.size(), parts = all < (size_t(1) << 16) ? 1 : kParts;
  std::vector<Axes> counted(parts, axes);
  parallelFor(size_t(0), parts, [&](size_t part) {
    for (size_t p = all * part / parts; p < all * (part + 1) / parts; p++)
      for (const uint32_t point : primitivePoints(block, loaded.geometry.kind, p))
        for (size_t a = 0; a < 3; a++) counted[part][a].add(block.points[point][int(a)]);
  });
  for (const Axes& some : counted) std::ranges::transform(axes, some, axes.begin(), sumOf);
  reduceValues(ranks, std::span<Counts>(axes), sumOf);
}

}  // namespace

PointSpread spreadOf(const LoadedGeometry& loaded, Collectives& ranks) {
  const OwnedGeometry& geometry = loaded.geometry;
  PointSpread spread{geometry.box, 0};
  const Box& box = geometry.box;
  if (box.empty()) return spread;
  Box inner = box;
  for (int round = 0; round < kRounds; round++) {
    Axes axes;
    for (int a = 0; a < 3; a++) axes[size_t(a)].lo = inner.lo[a], axes[size_t(a)].hi = inner.hi[a];
    count(loaded, ranks, axes);
    for (int a = 0; a < 3; a++) {
      const auto [lo, hi] = axes[size_t(a)].hundredths();
      inner.lo[a] = lo, inner.hi[a] = hi;
    }
  }
  double longest = 0, size = 1;
  for (int a = 0; a < 3; a++) {
    const double all = box.hi[a] - box.lo[a], most = inner.hi[a] - inner.lo[a];
    longest = std::max(longest, most);
    if (all <= 2 * most) continue;
    spread.middle.lo[a] = std::max(box.lo[a], inner.lo[a] - most / 4);
    spread.middle.hi[a] = std::min(box.hi[a], inner.hi[a] + most / 4);
  }
  int dimensions = 0;
  for (int a = 0; a < 3; a++) {
    constexpr double kFlat = 1e-3;  // A side up to this fraction of the longest one is no dimension.
    const double side = inner.hi[a] - inner.lo[a];
    if (side > kFlat * longest) size *= side, dimensions++;
  }
  if (dimensions > 0 && geometry.primitives > 1)
    spread.spacing = std::pow(size / double(geometry.primitives), 1.0 / dimensions);
  return spread;
}

}  // namespace gxy

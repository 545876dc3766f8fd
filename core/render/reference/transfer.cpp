// SPDX-License-Identifier: Apache-2.0
#include "gxy/reference/transfer.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gxy::reference {
namespace {

/// Moves the ends of a map to the ends of `range`, and what is between with them.
template <class Point>
void moveTo(std::vector<Point>& points, const std::array<double, 2>& range) {
  const double first = points.front().value, span = points.back().value - first;
  for (Point& p : points)
    p.value = span != 0 ? range[0] + (p.value - first) / span * (range[1] - range[0]) : range[0];
  if (span != 0) points.back().value = range[1];
}

/// Linear between the points, clamped outside; of points with equal values the last holds from that value on.
template <class Point, class Get>
auto evaluate(const std::vector<Point>& points, double value, Get get) {
  const auto above = std::upper_bound(points.begin(), points.end(), value,
                                      [](double v, const Point& p) { return v < p.value; });
  if (above == points.begin() || std::isnan(value)) return get(points.front());
  if (above == points.end()) return get(points.back());
  const Point &a = *(above - 1), &b = *above;
  const double w = (value - a.value) / (b.value - a.value);
  return get(a) + w * (get(b) - get(a));
}

}  // namespace

Transfer::Transfer(const Vis& vis, double referenceLength)
    : colours_(vis.colormap.points),
      opacities_(vis.opacitymap.points),
      perLength_(vis.opacitymap.extinction),
      referenceLength_(referenceLength) {
  if (colours_.empty()) colours_ = {{0, glm::dvec3(0.4)}, {1, glm::dvec3(1)}};
  if (opacities_.empty()) opacities_ = {{0, 1}};
  if (vis.dataRange) {
    moveTo(colours_, *vis.dataRange);
    moveTo(opacities_, *vis.dataRange);
  }
  for (const ColorPoint& p : colours_) breaks_.push_back(p.value);
  for (const OpacityPoint& p : opacities_) breaks_.push_back(p.value);
  std::sort(breaks_.begin(), breaks_.end());
  breaks_.erase(std::unique(breaks_.begin(), breaks_.end()), breaks_.end());
}

glm::dvec3 Transfer::colour(double value) const {
  return evaluate(colours_, value, [](const ColorPoint& p) { return p.rgb; });
}

double Transfer::extinction(double value) const {
  const double entry = evaluate(opacities_, value, [](const OpacityPoint& p) { return p.opacity; });
  if (perLength_) return std::max(0.0, entry);
  if (entry >= 1) return std::numeric_limits<double>::infinity();
  return entry > 0 ? -std::log1p(-entry) / referenceLength_ : 0;
}

bool Transfer::transparent(double lo, double hi) const {
  if (extinction(lo) > 0 || extinction(hi) > 0) return false;
  return std::none_of(opacities_.begin(), opacities_.end(),
                      [&](const OpacityPoint& p) { return p.value >= lo && p.value <= hi && p.opacity > 0; });
}

}  // namespace gxy::reference

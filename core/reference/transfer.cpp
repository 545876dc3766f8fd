// SPDX-License-Identifier: Apache-2.0
#include "core/reference/transfer.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gxy::reference {
namespace {

/// Moves the ends of a map to the ends of `range`, and the points between with them.
template <class Point>
void moveTo(std::vector<Point>& points, const std::array<double, 2>& range) {
  const double first = points.front().value, span = points.back().value - first;
  for (Point& p : points)
    p.value = span != 0 ? range[0] + (p.value - first) / span * (range[1] - range[0]) : range[0];
  if (span != 0) points.back().value = range[1];
}

/// origin + slope * (value - start)
template <class T>
struct Line {
  T origin, slope;
  double start;
};

/// The piece of a map that holds at `value`: linear between the points, constant outside. Of points with
/// equal values the last holds from that value on.
template <class T, class Point>
Line<T> lineAround(const std::vector<Point>& points, double value, T Point::*get) {
  const auto above = std::upper_bound(points.begin(), points.end(), value,
                                      [](double v, const Point& p) { return v < p.value; });
  if (above == points.begin() || std::isnan(value)) return {points.front().*get, T(0), 0};
  if (above == points.end()) return {points.back().*get, T(0), 0};
  const Point &a = *(above - 1), &b = *above;
  return {a.*get, (b.*get - a.*get) / (b.value - a.value), a.value};
}

template <class T, class Point>
T evaluate(const std::vector<Point>& points, double value, T Point::*get) {
  const Line<T> line = lineAround(points, value, get);
  return line.slope == T(0) ? line.origin : line.origin + (value - line.start) * line.slope;
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
  colourOfNan_ = vis.colormap.nan.value_or(colours_.front().rgb);
  for (const ColorPoint& p : colours_) breaks_.push_back(p.value);
  for (const OpacityPoint& p : opacities_) breaks_.push_back(p.value);
  std::sort(breaks_.begin(), breaks_.end());
  breaks_.erase(std::unique(breaks_.begin(), breaks_.end()), breaks_.end());
}

double LinearTransfer::extinction(double value) const {
  const double entry = std::max(0.0, entry_ + (value - entryStart_) * entrySlope_);
  if (referenceLength_ == 0) return entry;
  if (opaque_) return std::numeric_limits<double>::infinity();
  return -std::log1p(-std::min(entry, 1 - 0x1p-53)) / referenceLength_;
}

glm::dvec3 Transfer::colour(double value) const { return evaluate(colours_, value, &ColorPoint::rgb); }

double Transfer::extinction(double value) const {
  const double entry = evaluate(opacities_, value, &OpacityPoint::opacity);
  if (perLength_) return std::max(0.0, entry);
  if (entry >= 1) return std::numeric_limits<double>::infinity();
  return entry > 0 ? -std::log1p(-entry) / referenceLength_ : 0;
}

LinearTransfer Transfer::around(double value) const {
  const auto colour = lineAround(colours_, value, &ColorPoint::rgb);
  const auto entry = lineAround(opacities_, value, &OpacityPoint::opacity);
  LinearTransfer line;
  line.colour_ = colour.origin;
  line.colourSlope_ = colour.slope;
  line.colourStart_ = colour.start;
  line.entry_ = entry.origin;
  line.entrySlope_ = entry.slope;
  line.entryStart_ = entry.start;
  line.referenceLength_ = perLength_ ? 0 : referenceLength_;
  line.opaque_ = !perLength_ && entry.slope == 0 && entry.origin >= 1;
  return line;
}

bool Transfer::transparent(double lo, double hi) const {
  if (extinction(lo) > 0 || extinction(hi) > 0) return false;
  return std::none_of(opacities_.begin(), opacities_.end(),
                      [&](const OpacityPoint& p) { return p.value >= lo && p.value <= hi && p.opacity > 0; });
}

}  // namespace gxy::reference

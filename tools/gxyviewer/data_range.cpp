// SPDX-License-Identifier: Apache-2.0
#include "tools/gxyviewer/data_range.h"

#include <algorithm>

namespace gxy {

namespace {

using Ends = std::array<double, 2>;

template <class Points>
void include(std::optional<Ends>& range, const Points& points) {
  const double first = points.front().value, last = points.back().value;
  if (!(first < last)) return;
  range = range ? Ends{std::min((*range)[0], first), std::max((*range)[1], last)} : Ends{first, last};
}

// Extends a map's points to the range. A map is constant outside its ends, so this does not change its values.
template <class Points>
void extend(Points& points, const Ends& range) {
  if (!(points.front().value < points.back().value)) return;
  if (range[0] < points.front().value) {
    points.insert(points.begin(), points.front());
    points.front().value = range[0];
  }
  if (range[1] > points.back().value) {
    points.push_back(points.back());
    points.back().value = range[1];
  }
}

}  // namespace

std::optional<Ends> dataRangeOf(const Vis& vis) {
  std::optional<Ends> ends;
  include(ends, vis.colormap.points);
  include(ends, vis.opacitymap.points);
  return ends && vis.dataRange ? vis.dataRange : ends;
}

bool changeDataRange(Vis& vis, double factor, double shift) {
  const std::optional<Ends> range = dataRangeOf(vis);
  if (!range) return false;
  if (!vis.dataRange) {
    extend(vis.colormap.points, *range);
    extend(vis.opacitymap.points, *range);
  }
  const auto [low, high] = *range;
  const double half = 0.5 * (high - low) * factor, middle = 0.5 * (low + high) + 2 * half * shift;
  vis.dataRange = {middle - half, middle + half};
  return true;
}

}  // namespace gxy

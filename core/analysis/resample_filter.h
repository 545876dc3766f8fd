// SPDX-License-Identifier: Apache-2.0
// The filter Resample: a field on another grid.
#pragma once
#include <array>
#include <optional>
#include <vector>

#include "core/analysis/filter.h"

namespace gxy {

/// All components of the field at the points of another regular grid: that of the input `like`, or one of a box. Points outside the
/// field, and in its cells without data, have no data.
struct Resample {
  std::optional<Box> box;  ///< none: that of the field
  std::array<int, 3> dimensions{64, 64, 64};

  static FilterInfo info();
  static std::vector<KeyRow<Resample>> properties();
  FilterResult run(FilterRun& run) const;
};

/// Reads and writes the keys that are a box, [x0, x1, y0, y1, z0, z1], and three numbers of points.
Box readBox(const Found& found);
OrderedJson toJson(const Box& box);
std::array<int, 3> readDimensions(const Found& found, int least);

}  // namespace gxy

// SPDX-License-Identifier: Apache-2.0
// The filter Interpolate: values of a volume at the points of geometry.
#pragma once
#include <optional>
#include <vector>

#include "core/analysis/filter.h"

namespace gxy {

/// The points keep their order, ids and lines, and get the values of a field: NaN outside the field and where it has no data.
struct Interpolate {
  std::optional<int> component;  ///< none: the magnitude of several components

  static FilterInfo info();
  static std::vector<KeyRow<Interpolate>> properties();
  FilterResult run(FilterRun& run) const;
};

}  // namespace gxy

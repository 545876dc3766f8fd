// SPDX-License-Identifier: Apache-2.0
// The filter Interpolate: values of volumes at the points of geometry.
#pragma once
#include <optional>
#include <vector>

#include "core/analysis/filter.h"

namespace gxy {

/// The points keep their order, ids, lines and fields, and get those of volumes: NaN outside a volume and where it has no data. What
/// is shown is the first volume, or a component of it.
struct Interpolate {
  std::optional<int> component;  ///< of the first, which is shown; none: the magnitude of several

  static FilterInfo info();
  static std::vector<KeyRow<Interpolate>> properties();
  FilterResult run(FilterRun& run) const;
};

}  // namespace gxy

// SPDX-License-Identifier: Apache-2.0
// The filter IsosurfaceSampler: points on an isosurface, uniformly distributed by area.
#pragma once
#include <optional>
#include <vector>

#include "core/analysis/filter.h"

namespace gxy {

/// No mesh is made. Uniformly distributed lines through the volume's box meet the isosurface everywhere as often, by area (the
/// formula of Cauchy and Crofton, core/kernels/random_line.h). Each hit is a point. Of all hits, those with the smallest numbers of
/// their lines are taken, and lines are sent in rounds until there are enough. The mean number of hits tells the area.
struct IsosurfaceSampler {
  double isovalue = 0;
  std::optional<int> component;  ///< of the field; none: the magnitude, if it has several
  bool gradient = false;         ///< points get the field's gradient
  int count = 10000;
  int seed = 0;

  static FilterInfo info();
  static std::vector<KeyRow<IsosurfaceSampler>> properties();
  FilterResult run(FilterRun& run) const;
};

}  // namespace gxy

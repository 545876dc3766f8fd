// SPDX-License-Identifier: Apache-2.0
// The filter DensitySampler: points whose density in space is proportional to a field, or to a map of it.
#pragma once
#include <optional>
#include <vector>

#include "core/analysis/filter.h"
#include "core/scene/scene.h"

namespace gxy {

/// Rejection sampling with a bound for each macrocell. Candidate number k is a point in a macrocell, which is drawn in proportion to
/// its bound times its volume. It is accepted with the probability density / bound. The points are the first `count` accepted candidates.
/// So they follow the density exactly, whatever the bounds are. Candidates lie on the cumulative bounds at the van der Corput
/// numbers of k, shifted at random, so that each prefix of them is spread evenly.
struct DensitySampler {
  int count = 1000;
  int seed = 0;
  bool gradient = false;          ///< points get the field's gradient
  std::optional<int> component;   ///< none: the magnitude of several components
  std::vector<OpacityPoint> map;  ///< density by value; none: the value itself, and 0 where it is below 0

  static FilterInfo info();
  static std::vector<KeyRow<DensitySampler>> properties();
  FilterResult run(FilterRun& run) const;

  double densityAt(double value) const;
  /// The largest density of the values in [least, largest].
  double largestDensity(double least, double largest) const;
};

}  // namespace gxy

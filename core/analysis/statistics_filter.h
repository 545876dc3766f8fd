// SPDX-License-Identifier: Apache-2.0
// The filter Statistics: numbers of a field, or of the values of geometry.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "core/analysis/filter.h"

namespace gxy {

/// It tells numbers and makes no dataset. statistics.h says what they are.
struct StatisticsFilter {
  std::string array;             ///< of the points of geometry; empty: its values
  std::optional<int> component;  ///< none: the magnitude of several components
  std::string where;             ///< a logical expression of the inputs; empty: everywhere
  int histogram = 0;
  std::optional<Range> range;  ///< of the histogram
  std::vector<double> quantiles;

  static FilterInfo info();
  static std::vector<KeyRow<StatisticsFilter>> properties();
  FilterResult run(FilterRun& run) const;
};

}  // namespace gxy

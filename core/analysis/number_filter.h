// SPDX-License-Identifier: Apache-2.0
// The filter Number: a number that an expression computes of whole fields.
#pragma once
#include <string>
#include <vector>

#include "core/analysis/filter.h"

namespace gxy {

/// It tells `value` and makes no dataset. Each input is a field under the name that the expression uses (expression.h).
struct NumberFilter {
  std::string expression;

  static FilterInfo info();
  static std::vector<KeyRow<NumberFilter>> properties();
  FilterResult run(FilterRun& run) const;
};

}  // namespace gxy

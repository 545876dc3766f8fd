// SPDX-License-Identifier: Apache-2.0
// The filter StreamTracer: lines along a vector field.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "core/analysis/filter.h"
#include "core/analysis/lines.h"

namespace gxy {

struct StreamTracer {
  enum class ColorBy { Speed, Time, Length, Field };
  std::optional<double> time, length;  ///< of each direction; none: no limit, and 10 diagonals
  std::optional<int> steps;            ///< cells, of each direction; none: no limit
  TraceDirection direction = TraceDirection::Forward;
  double tolerance = 1e-3;
  bool normalised = false;
  PointsMode points = PointsMode::Cells;
  double interval = 0;  ///< of PointsMode::EqualTime and EqualLength
  double minimumSpeed = 0;
  std::optional<Range> where;  ///< of the input `field`
  ColorBy colorBy = ColorBy::Speed;
  std::vector<std::string> fields;  ///< of points, beside those of the input `fields`: kLineFields

  static FilterInfo info();
  static std::vector<KeyRow<StreamTracer>> properties();
  FilterResult run(FilterRun& run) const;

 private:
  TraceOptions options() const;
  TraceRequest request(const FilterRun& run) const;
};

}  // namespace gxy

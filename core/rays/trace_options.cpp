// SPDX-License-Identifier: Apache-2.0
#include "core/rays/trace_options.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/comm/error.h"
#include "core/rays/line_fields.h"

namespace gxy {

namespace {

void require(bool good, const char* option, double value, const char* expected) {
  if (!good)
    throw Error("trace: " + std::string(option) + " is " + std::to_string(value) + "; expected " + expected);
}

}  // namespace

void checkOptions(const TraceOptions& o, const LineFields& fields) {
  require(o.tolerance > 0, "tolerance", o.tolerance, "a number of cells above 0");
  require(o.time >= 0, "time", o.time, "0 or more: the direction says whether it goes backward");
  require(!o.length || *o.length >= 0, "length", o.length.value_or(0), "0 or more world units");
  require(o.steps >= 0, "steps", double(o.steps), "0 or more cells");
  require(o.minimumSpeed >= 0, "minimum speed", o.minimumSpeed, "0 or more");
  if (o.points == PointsMode::EqualTime || o.points == PointsMode::EqualLength)
    require(o.interval > 0 && std::isfinite(o.interval), "the interval of points", o.interval,
            "a finite number above 0");
  if (!o.condition) return;
  const auto recorded = int64_t(fields.recordedComponents());
  require(o.condition->field >= 0 && o.condition->field < recorded, "the condition's field",
          o.condition->field, "the number of a recorded component");
  require(o.condition->lo <= o.condition->hi, "the lower end of the condition", o.condition->lo,
          "at most its upper end");
}

TraceLimits limitsOf(const TraceOptions& o, double diagonal) {
  const double length = o.length.value_or(10 * diagonal);
  if (!o.normalised) return {o.time, length};
  return {std::numeric_limits<double>::infinity(), std::min(o.time, length)};
}

void settleAtLimit(const TraceOptions& o, const TraceLimits& limits, LineEnd& end) {
  if (o.normalised && end.reason == EndReason::Length && o.time <= limits.length)
    end.reason = EndReason::Time;
  if (end.reason == EndReason::Time) end.time = end.backward ? -o.time : o.time;
  if (end.reason == EndReason::Time && o.normalised) end.length = end.time;
  if (end.reason == EndReason::Length) end.length = end.backward ? -limits.length : limits.length;
  if (end.reason == EndReason::Length && o.normalised) end.time = end.length;
}

StepBounds stepBoundsOf(double tolerance) {
  // Measured over random cells of turbulence (tests/lines/turbulence_test.cpp): of 1000 cells, 999 add less than
  // a hundredth of the tolerance. Rounding in float leaves nothing to gain below a quarter of a cell.
  if (tolerance >= 1e-1) return {1.0f, 0.5f};
  if (tolerance >= 1e-2) return {0.5f, 0.3f};
  if (tolerance >= 1e-3) return {0.5f, 0.1f};
  return {0.25f, 0.05f};
}

}  // namespace gxy

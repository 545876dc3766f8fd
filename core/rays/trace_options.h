// SPDX-License-Identifier: Apache-2.0
// What is asked of lines through a field.
#pragma once
#include <cstdint>
#include <limits>
#include <optional>

namespace gxy {

class LineFields;
struct LineEnd;

enum class TraceDirection : uint8_t { Forward, Backward, Both };

/// Which points of a line are stored.
enum class PointsMode : uint8_t {
  Cells,        ///< the seed, each crossing of a face, and the end
  EqualTime,    ///< at exact multiples of `interval` of time
  EqualLength,  ///< at exact multiples of `interval` of length, world units
  Ends          ///< the seed and the end
};

/// Ends lines where the value of a recorded component is in [lo, hi]. It is looked at where a step ends, so a
/// line ends at most one step after it came into the range.
struct TraceCondition {
  int field = 0;  ///< which of the recorded components
  double lo = 0, hi = 0;
  bool operator==(const TraceCondition&) const = default;
};

struct TraceOptions {
  /// Cells of error that are added per 100 cells of way, without what the flow itself makes of errors. Less than
  /// 1e-4, or 1e-8 in a mesh, is taken for that, as rounding leaves no more.
  double tolerance = 1e-3;
  double time = std::numeric_limits<double>::infinity();  ///< of each direction
  std::optional<double> length =
      std::nullopt;  ///< world units, of each direction; unset: 10 diagonals of the grid's box
  int64_t steps = std::numeric_limits<int64_t>::max();  ///< cells, of each direction
  double minimumSpeed = 0;  ///< world units per unit of time: a line ends where it is slower
  bool normalised = false;  ///< time is length: a field line
  PointsMode points = PointsMode::Cells;
  double interval = 0;  ///< of EqualTime and EqualLength
  std::optional<TraceCondition> condition = std::nullopt;
  bool operator==(const TraceOptions&) const = default;
};

/// Throws Error (what, and what is expected) unless the options can be used with the fields.
void checkOptions(const TraceOptions& options, const LineFields& fields);

/// The greatest time and length of a line, in world units. A field line has no time of its own: its length is limited.
struct TraceLimits {
  double time, length;
};
/// `diagonal` is that of the fields' box.
TraceLimits limitsOf(const TraceOptions& options, double diagonal);
/// Makes the time and length of a line that has ended at a limit exactly that limit. Of field lines, a reason of Length
/// becomes Time where that was asked for.
void settleAtLimit(const TraceOptions& options, const TraceLimits& limits, LineEnd& end);

/// How the tolerance is kept: a step is at most `theta` cells long, and at most kappa / |J| of time, J being
/// the field's derivative in cell units.
struct StepBounds {
  float theta, kappa;
};
StepBounds stepBoundsOf(double tolerance);

}  // namespace gxy

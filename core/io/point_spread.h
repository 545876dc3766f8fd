// SPDX-License-Identifier: Apache-2.0
// Measures the spread of points without being misled by points far outside.
#pragma once
#include "core/io/import_geometry.h"

namespace gxy {

struct PointSpread {
  /// The box of the points without outliers, world coordinates. On each axis, the inner interval contains the
  /// points without the lowest and the highest hundredth. If the interval of all points is more than twice as
  /// long, `middle` has the inner interval, extended by a quarter of its length at each end; otherwise it has
  /// the interval of all points.
  Box middle;
  /// Mean distance of points: (size of the box of inner intervals / number of primitives) ^ (1 / its
  /// dimensions). 0: unknown.
  double spacing = 0;
};

/// Measures the corners of primitives; a point counts once for each primitive that it belongs to. Uses `box`
/// and `primitives` of `loaded`. Collective: all ranks call it. Points are counted in bins that all ranks
/// agree on, so the result does not depend on the number of ranks.
PointSpread spreadOf(const LoadedGeometry& loaded, Collectives& ranks);

}  // namespace gxy

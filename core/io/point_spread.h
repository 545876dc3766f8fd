// SPDX-License-Identifier: Apache-2.0
// How points are spread, whatever lies far outside.
#pragma once
#include "core/io/import_geometry.h"

namespace gxy {

struct PointSpread {
  /// Along each axis the box of all points, but where that is more than twice as long as what holds the points between the
  /// first and the last hundredth: that, a quarter longer at each end.
  Box middle;
  double spacing =
      0;  ///< (size of that hundredths' box / number of primitives) ^ (1 / its dimensions); 0: it has none
};

/// Collective. Of the corners of primitives, each counted for each primitive that it belongs to; needs `box` and
/// `primitives`. They are counted in bins that all ranks agree on, so the result does not depend on how many ranks there are.
PointSpread spreadOf(const LoadedGeometry& geometry, Collectives& ranks);

}  // namespace gxy

// SPDX-License-Identifier: Apache-2.0
// Cuts an extent into pieces of limited size, so that a long loop over its points can be ended between them.
#pragma once
#include <algorithm>
#include <cstdint>

#include "core/data/volume.h"

namespace gxy {

/// Splits an extent into boxes of at most `most` points, but at least a row. Calls use(box) for each.
template <class Use>
void forPieces(const Extent& extent, int64_t most, Use use) {
  const int64_t row = std::max<int64_t>(1, extent.points[0]),
                slice = row * std::max<int64_t>(1, extent.points[1]);
  const int64_t depth = std::max<int64_t>(1, most / slice),
                rows = depth > 1 ? extent.points[1] : std::max<int64_t>(1, most / row);
  for (int64_t z = 0; z < extent.points[2]; z += depth)
    for (int64_t y = 0; y < extent.points[1]; y += rows)
      use(Extent{
          {extent.first[0], extent.first[1] + y, extent.first[2] + z},
          {extent.points[0], std::min(rows, extent.points[1] - y), std::min(depth, extent.points[2] - z)}});
}

}  // namespace gxy

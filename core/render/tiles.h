// SPDX-License-Identifier: Apache-2.0
// Which pixels a rank has to look at.
#pragma once
#include <vector>

#include "gxy/rays/backend.h"

namespace gxy {

struct TileList {
  std::vector<Tile> tiles;  ///< in reverse order of rendering
  uint64_t skipped = 0;
};

/// The tiles (of all samples) that meet the projection of a visible partition of this rank. Conservative; whose a pixel
/// is, is decided by the ray itself.
TileList tilesOf(const CompiledScene& scene, const CompiledFrame& frame, int rank);

}  // namespace gxy

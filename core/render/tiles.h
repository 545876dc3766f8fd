// SPDX-License-Identifier: Apache-2.0
// Which pixels a rank has to look at.
#pragma once
#include <vector>

#include "core/rays/backend.h"

namespace gxy {

struct TileList {
  std::vector<Tile>
      tiles;  ///< of the frame's first sample, in order of rendering; those of the others are the same
  uint64_t skipped = 0;  ///< of one sample
};

/// The tiles that meet the projection of a visible partition of this rank, of so many pixels a side at most. Conservative;
/// whose a pixel is, is decided by the ray itself.
TileList tilesOf(const CompiledScene& scene, const CompiledFrame& frame, int rank, int side = kTile);

/// Pixels a side of tiles so that one takes a small part of all credits: as many as a device may be given, fewer where a primary
/// ray takes many.
int tileSide(int64_t credits, int64_t perPrimary);

}  // namespace gxy

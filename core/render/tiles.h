// SPDX-License-Identifier: Apache-2.0
// The tiles of a picture in which a rank may have to spawn rays.
#pragma once
#include <vector>

#include "core/rays/backend.h"

namespace gxy {

struct TileList {
  /// Tiles of the frame's first sample, in order of rendering. The other samples have the same tiles.
  std::vector<SpawnTile> tiles;
  uint64_t skipped = 0;  ///< tiles of one sample that are left out
};

/// Returns the tiles, of at most `side` x `side` pixels, that meet the projection of a visible partition of
/// `rank`. The list is conservative: the ray of a pixel decides itself which rank spawns it
/// (DeviceScene::spawn).
TileList tilesOf(const CompiledScene& scene, const CompiledFrame& frame, int rank, int side = kTile);

/// Returns the side of tiles in pixels, from 8 to kTile, so that a tile's rays take at most 1/32 of a rank's
/// `credits` where possible. A primary ray takes `perPrimary` credits.
int tileSide(int64_t credits, int64_t perPrimary);

}  // namespace gxy

// SPDX-License-Identifier: Apache-2.0
// Which cells of a mesh share which faces.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "core/data/mesh.h"

namespace gxy {

/// The neighbours of cells. Two faces are one if they have the same points, in the same order around the face or in the opposite one.
/// Points that follow each other and are the same count once, so that a side of a collapsed hexahedron may meet a triangle.
struct Connectivity {
  /// By type: for each face of each cell the face of the neighbour, or kNoFace.
  std::array<std::vector<FaceId>, kCellTypes> neighbours;
  /// The faces without a neighbour that have an area, in ascending order.
  std::vector<FaceId> shell;

  // Defects of the mesh.
  uint64_t crowded = 0;             ///< faces of three or more cells; these are on the shell
  std::vector<uint32_t> crowdedAt;  ///< the lowest point of each of them, ascending
  /// Pairs of faces that run the same way around: one of their cells is inverted, or they overlap.
  uint64_t sameSide = 0;
  uint64_t repeated = 0;  ///< cells with a point twice
  /// Cells all of whose faces are those of one other cell. Both have the same points, and no ray would find them from the shell.
  uint64_t twins = 0;
};

/// Finds the neighbours in time that grows as the number of cells does: faces are sorted by their lowest point, and then among those
/// of the same lowest point. It takes 16 bytes a face while it runs. Throws Error if there are too many points or cells, or if a cell
/// has a point that is not one of `points`.
Connectivity connect(const MeshCells& cells, uint64_t points);

}  // namespace gxy

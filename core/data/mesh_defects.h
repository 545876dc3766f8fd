// SPDX-License-Identifier: Apache-2.0
// What is wrong where cells of a mesh meet.
#pragma once
#include <cstdint>
#include <span>

#include "core/data/mesh.h"

namespace gxy {

/// Counts of MeshReport.
struct MeshDefects {
  uint64_t foldedFaces = 0, hangingPoints = 0, splitFaces = 0;
};

/// Counts the defects of a block that is connected. isHere[p]: whether point p, and each face whose lowest point is p, is counted in this
/// partition; all cells that have it, or touch it, are then in the block.
MeshDefects defectsOf(const MeshBlock& block, std::span<const uint8_t> isHere);

/// Whether the faces of a cell run clockwise, seen from outside: its volume, where faces of four points are bilinear, is negative.
bool isInverted(std::span<const glm::dvec3> points, CellType type, std::span<const uint32_t> cell);

}  // namespace gxy

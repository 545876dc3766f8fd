// SPDX-License-Identifier: Apache-2.0
// Hexahedra some of whose points are the same, as codes for finite elements write other cells, and as curvilinear grids have them
// around an axis.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "core/data/mesh.h"

namespace gxy {

struct CollapsedCell {
  CellType type;
  std::array<uint32_t, 6> points;  ///< the first of them, as many as the type has
};

/// Returns what a hexahedron with repeated points is: a wedge, if two opposite edges of one face have become points, a pyramid, if a face
/// has, or a tetrahedron, if a face and an edge of the opposite face have. The cell is inverted if the hexahedron is. Nothing if all
/// points differ, or for any other pattern.
std::optional<CollapsedCell> collapsed(std::span<const uint32_t, 8> hexahedron);

}  // namespace gxy

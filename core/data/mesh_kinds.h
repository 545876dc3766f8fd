// SPDX-License-Identifier: Apache-2.0
// Kinds of cells by their numbers in VTK, as meshes take them from files and from simulations.
#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "core/data/mesh.h"

namespace gxy {

/// How many cells there are of each kind.
using CellKinds = std::map<int, uint64_t>;

/// The kinds that meshes take, for messages.
inline constexpr const char* kMeshCellKinds = "tetrahedra, pyramids, wedges, hexahedra or voxels";

/// Which cell of a mesh one of a kind becomes; nothing if it becomes none.
std::optional<CellType> meshCellOf(int vtkType);

/// The place among the points of a cell of VTK's that point `i` of the cell of a mesh has there: voxels run through x, y and z.
size_t placeInFile(int vtkType, size_t i);

/// The dimension of cells of a kind, from 0 to 3; nothing for kinds that VTK does not know.
std::optional<int> dimensionOf(int vtkType);

/// What cells of a kind are called, for users: "quadratic tetrahedra". Null for kinds that VTK does not know.
const char* pluralOfKind(int vtkType);

/// Bits of VTK's arrays vtkGhostType, one for each cell and one for each point.
inline constexpr uint8_t kDuplicateCell = 1, kRefinedCell = 8, kHiddenCell = 32, kHiddenPoint = 2;
/// The name of these arrays.
inline constexpr const char* kGhostArray = "vtkGhostType";
/// Whether meshes leave out a cell with these bits.
constexpr bool isGhostCell(uint8_t bits) {
  return (bits & (kDuplicateCell | kRefinedCell | kHiddenCell)) != 0;
}
/// Whether that is because another piece has it, so that it serves averages at points nevertheless.
constexpr bool isDuplicateOnly(uint8_t bits) {
  return (bits & (kDuplicateCell | kRefinedCell | kHiddenCell)) == kDuplicateCell;
}

/// Returns a text such as "triangles (12), wedges (1)".
std::string describe(const CellKinds& kinds);

}  // namespace gxy

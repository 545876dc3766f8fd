// SPDX-License-Identifier: Apache-2.0
// The faces of VTK's cells of two and three dimensions, linear and quadratic, and how they are cut into triangles. Used inside
// core/io only, by files that see VTK.
#pragma once
#include <vtkPointSet.h>

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace gxy {

/// A face of a cell, as numbers of the cell's points: its corners in order around it, outwards by the right-hand rule; for each
/// corner the point in the middle of the edge that begins there (-1: none); the point at its centre (-1: none).
struct CellFace {
  std::vector<int> corners, middles;
  int centre = -1;
};

/// The faces of a type of cells; that of a flat cell is itself.
struct CellShape {
  int points = 0;  ///< that every cell of the type has
  bool solid = false;
  std::vector<CellFace> faces;
};
/// Null for types without faces, those whose cells have a number of points of their own, and those of more than second order.
const CellShape* shapeOf(int vtkType);

/// Appends the triangles of a face of a cell with these points, between its middles and its centre, too, where it has them.
void appendFace(vtkPointSet* set, const CellFace& face, std::span<const vtkIdType> cell,
                std::vector<std::array<uint32_t, 3>>& triangles);
/// The number of triangles that appendFace() appends.
size_t trianglesOf(const CellFace& face);

struct OuterFace {
  vtkIdType cell;
  int face;
};
/// The outer surface of the solid cells: their faces that no other of them has, in the order of cells and faces. Faces are
/// compared by their corners. Cells for which `isThere` answers no are taken as if they were not in the set. Takes
/// kBytesPerFace for each face of all cells; of a structured grid whose cells are all there, for each outer one.
std::vector<OuterFace> outerFaces(vtkPointSet* set, bool allThere,
                                  const std::function<bool(vtkIdType cell)>& isThere);
inline constexpr int64_t kBytesPerFace = 32;

}  // namespace gxy

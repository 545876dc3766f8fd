// SPDX-License-Identifier: Apache-2.0
// The faces of VTK's linear and quadratic cells of two and three dimensions, and their triangulation. Used
// inside core/io only, by files that include VTK.
#pragma once
#include <vtkPointSet.h>

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace gxy {

/// A face of a cell. All members are numbers of the cell's points; -1 means that there is none.
struct DrawnCellFace {
  /// Corners in order around the face, where the right-hand rule gives its outer side; for each corner, the
  /// point in the middle of the edge that begins there.
  std::vector<int> corners, middles;
  int centre = -1;
};

/// The faces of a type of cells. A flat cell has one face, itself.
struct DrawnCellShape {
  int points = 0;  ///< number of points of every cell of the type
  bool solid = false;
  std::vector<DrawnCellFace> faces;
};
/// Returns null for types without faces, types whose cells have different numbers of points, and types of
/// more than second order.
const DrawnCellShape* shapeOf(int vtkType);

/// Appends the triangles of a face of a cell with the points `cell`. They use the face's middles and
/// centre, if it has them.
void appendFace(vtkPointSet* set, const DrawnCellFace& face, std::span<const vtkIdType> cell,
                std::vector<std::array<uint32_t, 3>>& triangles);
/// Returns the number of triangles that appendFace() appends.
size_t trianglesOf(const DrawnCellFace& face);

struct OuterFace {
  vtkIdType cell;
  int face;
};
/// Returns the outer surface of the solid cells: the faces that belong to one of them only, in the order of
/// cells and faces. Faces are compared by their corners. Cells for which `isThere` returns false are ignored;
/// `allThere` says that there are none. Takes kBytesPerFace bytes for each face of all cells, or, for a
/// structured grid with all its cells, for each outer face.
std::vector<OuterFace> outerFaces(vtkPointSet* set, bool allThere,
                                  const std::function<bool(vtkIdType cell)>& isThere);
inline constexpr int64_t kBytesPerFace = 32;

}  // namespace gxy

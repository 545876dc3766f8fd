// SPDX-License-Identifier: Apache-2.0
#include "core/io/cell_faces.h"

#include <vtkCellType.h>
#include <vtkIdList.h>
#include <vtkSmartPointer.h>
#include <vtkStructuredGrid.h>

#include <algorithm>
#include <map>

#include "core/data/polygon.h"
#include "core/io/cell_list.h"

namespace gxy {
namespace {

using Faces = std::vector<std::vector<int>>;
using Edges = std::vector<std::array<int, 2>>;

const Faces kTetra{{0, 1, 3}, {1, 2, 3}, {2, 0, 3}, {0, 2, 1}};
const Faces kVoxel{{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
const Faces kHexahedron{{0, 4, 7, 3}, {1, 2, 6, 5}, {0, 1, 5, 4}, {3, 7, 6, 2}, {0, 3, 2, 1}, {4, 5, 6, 7}};
const Faces kWedge{{0, 1, 2}, {3, 5, 4}, {0, 3, 4, 1}, {1, 4, 5, 2}, {2, 5, 3, 0}};
const Faces kPyramid{{0, 3, 2, 1}, {0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};

/// The edges of cells with a point in the middle of each edge, in the order of these points, which come
/// after the corners.
const Edges kTetraEdges{{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};
const Edges kHexahedronEdges{{0, 1}, {1, 2}, {2, 3}, {3, 0}, {4, 5}, {5, 6},
                             {6, 7}, {7, 4}, {0, 4}, {1, 5}, {2, 6}, {3, 7}};
const Edges kWedgeEdges{{0, 1}, {1, 2}, {2, 0}, {3, 4}, {4, 5}, {5, 3}, {0, 3}, {1, 4}, {2, 5}};
const Edges kWedgeEnds{{0, 1}, {1, 2}, {2, 0}, {3, 4}, {4, 5}, {5, 3}};
const Edges kPyramidEdges{{0, 1}, {1, 2}, {2, 3}, {3, 0}, {0, 4}, {1, 4}, {2, 4}, {3, 4}};
const Faces kTriangle{{0, 1, 2}}, kQuad{{0, 1, 2, 3}};
const Edges kTriangleEdges{{0, 1}, {1, 2}, {2, 0}}, kQuadEdges{{0, 1}, {1, 2}, {2, 3}, {3, 0}};

/// Returns the two ends and the sides of a prism over a polygon of n corners.
Faces prism(int n) {
  Faces faces(2);
  for (int i = 0; i < n; ++i) {
    faces[0].push_back((n - i) % n);
    faces[1].push_back(n + i);
    faces.push_back({i, (i + 1) % n, n + (i + 1) % n, n + i});
  }
  return faces;
}

/// Makes a shape. `centres` has the centre points of the faces from `firstCentred` on.
DrawnCellShape shape(int points, bool solid, const Faces& faces, const Edges& edges = {},
                     size_t firstCentred = 0, const std::vector<int>& centres = {}) {
  DrawnCellShape made{points, solid, {}};
  int corners = 0;
  for (const auto& face : faces) corners = std::max(corners, 1 + *std::max_element(face.begin(), face.end()));
  const auto middleOf = [&](int a, int b) {
    for (size_t e = 0; e < edges.size(); ++e)
      if (edges[e] == std::array{a, b} || edges[e] == std::array{b, a}) return corners + int(e);
    return -1;
  };
  for (size_t f = 0; f < faces.size(); ++f) {
    DrawnCellFace face{faces[f], {}, -1};
    for (size_t i = 0; i < face.corners.size(); ++i)
      face.middles.push_back(middleOf(face.corners[i], face.corners[(i + 1) % face.corners.size()]));
    if (f >= firstCentred && f - firstCentred < centres.size()) face.centre = centres[f - firstCentred];
    made.faces.push_back(std::move(face));
  }
  return made;
}

std::map<int, DrawnCellShape> allShapes() {
  return {
      {VTK_TETRA, shape(4, true, kTetra)},
      {VTK_VOXEL, shape(8, true, kVoxel)},
      {VTK_HEXAHEDRON, shape(8, true, kHexahedron)},
      {VTK_WEDGE, shape(6, true, kWedge)},
      {VTK_PYRAMID, shape(5, true, kPyramid)},
      {VTK_PENTAGONAL_PRISM, shape(10, true, prism(5))},
      {VTK_HEXAGONAL_PRISM, shape(12, true, prism(6))},
      {VTK_QUADRATIC_TETRA, shape(10, true, kTetra, kTetraEdges)},
      {VTK_QUADRATIC_HEXAHEDRON, shape(20, true, kHexahedron, kHexahedronEdges)},
      {VTK_QUADRATIC_WEDGE, shape(15, true, kWedge, kWedgeEdges)},
      {VTK_QUADRATIC_PYRAMID, shape(13, true, kPyramid, kPyramidEdges)},
      {VTK_TRIQUADRATIC_HEXAHEDRON,
       shape(27, true, kHexahedron, kHexahedronEdges, 0, {20, 21, 22, 23, 24, 25})},
      {VTK_QUADRATIC_LINEAR_WEDGE, shape(12, true, kWedge, kWedgeEnds)},
      {VTK_BIQUADRATIC_QUADRATIC_WEDGE, shape(18, true, kWedge, kWedgeEdges, 2, {15, 16, 17})},
      {VTK_BIQUADRATIC_QUADRATIC_HEXAHEDRON,
       shape(24, true, kHexahedron, kHexahedronEdges, 0, {20, 21, 22, 23})},
      {VTK_TRIQUADRATIC_PYRAMID, shape(19, true, kPyramid, kPyramidEdges, 0, {13, 14, 15, 16, 17})},
      {VTK_QUADRATIC_TRIANGLE, shape(6, false, kTriangle, kTriangleEdges)},
      {VTK_QUADRATIC_QUAD, shape(8, false, kQuad, kQuadEdges)},
      {VTK_BIQUADRATIC_QUAD, shape(9, false, kQuad, kQuadEdges, 0, {8})},
      {VTK_QUADRATIC_LINEAR_QUAD, shape(6, false, kQuad, {{0, 1}, {2, 3}})},
      {VTK_BIQUADRATIC_TRIANGLE, shape(7, false, kTriangle, kTriangleEdges, 0, {6})},
  };
}

bool hasAllMiddles(const DrawnCellFace& face) {
  return std::all_of(face.middles.begin(), face.middles.end(), [](int m) { return m >= 0; });
}

/// Identifies a face by its corners, regardless of their order and orientation: the three smallest numbers
/// and the largest.
struct FaceKey {
  std::array<uint32_t, 4> corners;
  OuterFace face;
};
static_assert(sizeof(FaceKey) == kBytesPerFace);

FaceKey keyOf(const DrawnCellFace& face, std::span<const vtkIdType> cell, OuterFace of) {
  std::vector<uint32_t> ids;
  for (int corner : face.corners) ids.push_back(uint32_t(cell[size_t(corner)]));
  std::sort(ids.begin(), ids.end());
  return {{ids[0], ids[1], ids[2], ids.back()}, of};
}

std::vector<OuterFace> facesThatAreAlone(std::vector<FaceKey> keys) {
  std::sort(keys.begin(), keys.end(),
            [](const FaceKey& a, const FaceKey& b) { return a.corners < b.corners; });
  std::vector<OuterFace> alone;
  for (size_t begin = 0, end = 0; begin < keys.size(); begin = end) {
    for (end = begin + 1; end < keys.size() && keys[end].corners == keys[begin].corners;) ++end;
    if (end == begin + 1) alone.push_back(keys[begin].face);
  }
  std::sort(alone.begin(), alone.end(), [](const OuterFace& a, const OuterFace& b) {
    return a.cell != b.cell ? a.cell < b.cell : a.face < b.face;
  });
  return alone;
}

/// Returns the outer faces of a lattice of hexahedra.
std::vector<OuterFace> sidesOf(vtkStructuredGrid* grid) {
  int n[3];
  grid->GetCellDims(n);
  std::vector<OuterFace> sides;
  vtkIdType cell = 0;
  for (int k = 0; k < n[2]; ++k)
    for (int j = 0; j < n[1]; ++j)
      for (int i = 0; i < n[0]; ++i, ++cell) {
        const bool atSide[6] = {i == 0, i + 1 == n[0], j == 0, j + 1 == n[1], k == 0, k + 1 == n[2]};
        for (int f = 0; f < 6; ++f)
          if (atSide[f]) sides.push_back({cell, f});
      }
  return sides;
}

}  // namespace

const DrawnCellShape* shapeOf(int vtkType) {
  static const std::map<int, DrawnCellShape> shapes = allShapes();
  const auto found = shapes.find(vtkType);
  return found == shapes.end() ? nullptr : &found->second;
}

size_t trianglesOf(const DrawnCellFace& face) {
  const size_t n = face.corners.size(),
               middles = size_t(
                   std::count_if(face.middles.begin(), face.middles.end(), [](int m) { return m >= 0; }));
  return face.centre >= 0 ? 2 * n : n + middles - 2;
}

void appendFace(vtkPointSet* set, const DrawnCellFace& face, std::span<const vtkIdType> cell,
                std::vector<std::array<uint32_t, 3>>& triangles) {
  const auto id = [&](int point) { return uint32_t(cell[size_t(point)]); };
  const auto add = [&](int a, int b, int c) { triangles.push_back({id(a), id(b), id(c)}); };
  const auto& [corners, middles, centre] = face;
  const size_t n = corners.size();
  if (hasAllMiddles(face)) {
    for (size_t i = 0; i < n; ++i) {
      const int before = middles[(i + n - 1) % n];
      if (centre < 0) {
        add(corners[i], middles[i], before);
      } else {
        add(corners[i], middles[i], centre);
        add(corners[i], centre, before);
      }
    }
    for (size_t i = 1; centre < 0 && i + 1 < n; ++i) add(middles[0], middles[i], middles[i + 1]);
    return;
  }
  std::vector<int> around;
  std::vector<glm::dvec3> places;
  for (size_t i = 0; i < n; ++i)
    for (int point : {corners[i], middles[i]})
      if (point >= 0) {
        const double* p = set->GetPoint(cell[size_t(point)]);
        around.push_back(point);
        places.push_back({p[0], p[1], p[2]});
      }
  std::vector<std::array<uint32_t, 3>> cut;
  triangulate(places, cut);
  for (const auto& [a, b, c] : cut) add(around[a], around[b], around[c]);
}

std::vector<OuterFace> outerFaces(vtkPointSet* set, bool allThere,
                                  const std::function<bool(vtkIdType)>& isThere) {
  const auto grid = vtkStructuredGrid::SafeDownCast(set);
  if (grid && allThere && grid->GetNumberOfCells() > 0 && grid->GetCellType(0) == VTK_HEXAHEDRON)
    return sidesOf(grid);
  std::vector<FaceKey> keys;
  const CellList list(set);
  const auto ids = vtkSmartPointer<vtkIdList>::New();
  for (vtkIdType cell = 0; cell < list.count(); ++cell) {
    const DrawnCellShape* shape = shapeOf(list.type(cell));
    if (!shape || !shape->solid || !isThere(cell)) continue;
    list.points(cell, ids);
    if (ids->GetNumberOfIds() != shape->points) continue;
    for (size_t f = 0; f < shape->faces.size(); ++f)
      keys.push_back(keyOf(shape->faces[f], {ids->GetPointer(0), size_t(shape->points)}, {cell, int(f)}));
  }
  return facesThatAreAlone(std::move(keys));
}

}  // namespace gxy

// SPDX-License-Identifier: Apache-2.0
#include "core/io/mesh_kinds.h"

#include <vtkCellType.h>

namespace gxy {

namespace {

struct Kind {
  int dimension;
  const char* plural;
};

const std::map<int, Kind>& kinds() {
  static const std::map<int, Kind> all{
      {VTK_EMPTY_CELL, {0, "empty cells"}},
      {VTK_VERTEX, {0, "vertices"}},
      {VTK_POLY_VERTEX, {0, "groups of vertices"}},
      {VTK_LINE, {1, "lines"}},
      {VTK_POLY_LINE, {1, "polylines"}},
      {VTK_TRIANGLE, {2, "triangles"}},
      {VTK_TRIANGLE_STRIP, {2, "triangle strips"}},
      {VTK_POLYGON, {2, "polygons"}},
      {VTK_PIXEL, {2, "pixels"}},
      {VTK_QUAD, {2, "quads"}},
      {VTK_TETRA, {3, "tetrahedra"}},
      {VTK_VOXEL, {3, "voxels"}},
      {VTK_HEXAHEDRON, {3, "hexahedra"}},
      {VTK_WEDGE, {3, "wedges"}},
      {VTK_PYRAMID, {3, "pyramids"}},
      {VTK_PENTAGONAL_PRISM, {3, "pentagonal prisms"}},
      {VTK_HEXAGONAL_PRISM, {3, "hexagonal prisms"}},
      {VTK_QUADRATIC_EDGE, {1, "quadratic edges"}},
      {VTK_QUADRATIC_TRIANGLE, {2, "quadratic triangles"}},
      {VTK_QUADRATIC_QUAD, {2, "quadratic quads"}},
      {VTK_QUADRATIC_POLYGON, {2, "quadratic polygons"}},
      {VTK_QUADRATIC_TETRA, {3, "quadratic tetrahedra"}},
      {VTK_QUADRATIC_HEXAHEDRON, {3, "quadratic hexahedra"}},
      {VTK_QUADRATIC_WEDGE, {3, "quadratic wedges"}},
      {VTK_QUADRATIC_PYRAMID, {3, "quadratic pyramids"}},
      {VTK_BIQUADRATIC_QUAD, {2, "biquadratic quads"}},
      {VTK_TRIQUADRATIC_HEXAHEDRON, {3, "triquadratic hexahedra"}},
      {VTK_TRIQUADRATIC_PYRAMID, {3, "triquadratic pyramids"}},
      {VTK_QUADRATIC_LINEAR_QUAD, {2, "quadratic linear quads"}},
      {VTK_QUADRATIC_LINEAR_WEDGE, {3, "quadratic linear wedges"}},
      {VTK_BIQUADRATIC_QUADRATIC_WEDGE, {3, "biquadratic quadratic wedges"}},
      {VTK_BIQUADRATIC_QUADRATIC_HEXAHEDRON, {3, "biquadratic quadratic hexahedra"}},
      {VTK_BIQUADRATIC_TRIANGLE, {2, "biquadratic triangles"}},
      {VTK_CUBIC_LINE, {1, "cubic lines"}},
      {VTK_CONVEX_POINT_SET, {3, "convex point sets"}},
      {VTK_POLYHEDRON, {3, "polyhedra"}},
      {VTK_PARAMETRIC_CURVE, {1, "parametric curves"}},
      {VTK_PARAMETRIC_SURFACE, {2, "parametric surfaces"}},
      {VTK_PARAMETRIC_TRI_SURFACE, {2, "parametric triangles"}},
      {VTK_PARAMETRIC_QUAD_SURFACE, {2, "parametric quads"}},
      {VTK_PARAMETRIC_TETRA_REGION, {3, "parametric tetrahedra"}},
      {VTK_PARAMETRIC_HEX_REGION, {3, "parametric hexahedra"}},
      {VTK_HIGHER_ORDER_EDGE, {1, "edges of higher order"}},
      {VTK_HIGHER_ORDER_TRIANGLE, {2, "triangles of higher order"}},
      {VTK_HIGHER_ORDER_QUAD, {2, "quads of higher order"}},
      {VTK_HIGHER_ORDER_POLYGON, {2, "polygons of higher order"}},
      {VTK_HIGHER_ORDER_TETRAHEDRON, {3, "tetrahedra of higher order"}},
      {VTK_HIGHER_ORDER_WEDGE, {3, "wedges of higher order"}},
      {VTK_HIGHER_ORDER_PYRAMID, {3, "pyramids of higher order"}},
      {VTK_HIGHER_ORDER_HEXAHEDRON, {3, "hexahedra of higher order"}},
      {VTK_LAGRANGE_CURVE, {1, "Lagrange curves"}},
      {VTK_LAGRANGE_TRIANGLE, {2, "Lagrange triangles"}},
      {VTK_LAGRANGE_QUADRILATERAL, {2, "Lagrange quads"}},
      {VTK_LAGRANGE_TETRAHEDRON, {3, "Lagrange tetrahedra"}},
      {VTK_LAGRANGE_HEXAHEDRON, {3, "Lagrange hexahedra"}},
      {VTK_LAGRANGE_WEDGE, {3, "Lagrange wedges"}},
      {VTK_LAGRANGE_PYRAMID, {3, "Lagrange pyramids"}},
      {VTK_BEZIER_CURVE, {1, "Bezier curves"}},
      {VTK_BEZIER_TRIANGLE, {2, "Bezier triangles"}},
      {VTK_BEZIER_QUADRILATERAL, {2, "Bezier quads"}},
      {VTK_BEZIER_TETRAHEDRON, {3, "Bezier tetrahedra"}},
      {VTK_BEZIER_HEXAHEDRON, {3, "Bezier hexahedra"}},
      {VTK_BEZIER_WEDGE, {3, "Bezier wedges"}},
      {VTK_BEZIER_PYRAMID, {3, "Bezier pyramids"}},
  };
  return all;
}

}  // namespace

std::optional<CellType> meshCellOf(int vtkType) {
  switch (vtkType) {
    case VTK_TETRA:
      return CellType::Tetrahedron;
    case VTK_PYRAMID:
      return CellType::Pyramid;
    case VTK_WEDGE:
      return CellType::Wedge;
    case VTK_HEXAHEDRON:
    case VTK_VOXEL:
      return CellType::Hexahedron;
    default:
      return {};
  }
}

size_t placeInFile(int vtkType, size_t i) { return vtkType == VTK_VOXEL && (i & 2) ? i ^ 1 : i; }

std::optional<int> dimensionOf(int vtkType) {
  const auto kind = kinds().find(vtkType);
  if (kind == kinds().end()) return {};
  return kind->second.dimension;
}

std::string describe(const CellKinds& found) {
  std::string text;
  for (const auto& [type, count] : found) {
    const auto kind = kinds().find(type);
    text +=
        (text.empty() ? "" : ", ") +
        (kind == kinds().end() ? "cells of type " + std::to_string(type) : std::string(kind->second.plural)) +
        " (" + std::to_string(count) + ")";
  }
  return text;
}

}  // namespace gxy

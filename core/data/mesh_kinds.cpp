// SPDX-License-Identifier: Apache-2.0
#include "core/data/mesh_kinds.h"

namespace gxy {

namespace {

constexpr int kVoxel = 11;

struct Kind {
  int dimension;
  const char* plural;
};

const std::map<int, Kind>& kinds() {
  static const std::map<int, Kind> all{
      {0, {0, "empty cells"}},
      {1, {0, "vertices"}},
      {2, {0, "groups of vertices"}},
      {3, {1, "lines"}},
      {4, {1, "polylines"}},
      {5, {2, "triangles"}},
      {6, {2, "triangle strips"}},
      {7, {2, "polygons"}},
      {8, {2, "pixels"}},
      {9, {2, "quads"}},
      {10, {3, "tetrahedra"}},
      {11, {3, "voxels"}},
      {12, {3, "hexahedra"}},
      {13, {3, "wedges"}},
      {14, {3, "pyramids"}},
      {15, {3, "pentagonal prisms"}},
      {16, {3, "hexagonal prisms"}},
      {21, {1, "quadratic edges"}},
      {22, {2, "quadratic triangles"}},
      {23, {2, "quadratic quads"}},
      {24, {3, "quadratic tetrahedra"}},
      {25, {3, "quadratic hexahedra"}},
      {26, {3, "quadratic wedges"}},
      {27, {3, "quadratic pyramids"}},
      {28, {2, "biquadratic quads"}},
      {29, {3, "triquadratic hexahedra"}},
      {30, {2, "quadratic linear quads"}},
      {31, {3, "quadratic linear wedges"}},
      {32, {3, "biquadratic quadratic wedges"}},
      {33, {3, "biquadratic quadratic hexahedra"}},
      {34, {2, "biquadratic triangles"}},
      {35, {1, "cubic lines"}},
      {36, {2, "quadratic polygons"}},
      {37, {3, "triquadratic pyramids"}},
      {41, {3, "convex point sets"}},
      {42, {3, "polyhedra"}},
      {51, {1, "parametric curves"}},
      {52, {2, "parametric surfaces"}},
      {53, {2, "parametric triangles"}},
      {54, {2, "parametric quads"}},
      {55, {3, "parametric tetrahedra"}},
      {56, {3, "parametric hexahedra"}},
      {60, {1, "edges of higher order"}},
      {61, {2, "triangles of higher order"}},
      {62, {2, "quads of higher order"}},
      {63, {2, "polygons of higher order"}},
      {64, {3, "tetrahedra of higher order"}},
      {65, {3, "wedges of higher order"}},
      {66, {3, "pyramids of higher order"}},
      {67, {3, "hexahedra of higher order"}},
      {68, {1, "Lagrange curves"}},
      {69, {2, "Lagrange triangles"}},
      {70, {2, "Lagrange quads"}},
      {71, {3, "Lagrange tetrahedra"}},
      {72, {3, "Lagrange hexahedra"}},
      {73, {3, "Lagrange wedges"}},
      {74, {3, "Lagrange pyramids"}},
      {75, {1, "Bezier curves"}},
      {76, {2, "Bezier triangles"}},
      {77, {2, "Bezier quads"}},
      {78, {3, "Bezier tetrahedra"}},
      {79, {3, "Bezier hexahedra"}},
      {80, {3, "Bezier wedges"}},
      {81, {3, "Bezier pyramids"}},
  };
  return all;
}

}  // namespace

std::optional<CellType> meshCellOf(int vtkType) {
  switch (vtkType) {
    case 10:
      return CellType::Tetrahedron;
    case 14:
      return CellType::Pyramid;
    case 13:
      return CellType::Wedge;
    case 12:
    case kVoxel:
      return CellType::Hexahedron;
    default:
      return {};
  }
}

size_t placeInFile(int vtkType, size_t i) { return vtkType == kVoxel && (i & 2) ? i ^ 1 : i; }

std::optional<int> dimensionOf(int vtkType) {
  const auto kind = kinds().find(vtkType);
  if (kind == kinds().end()) return {};
  return kind->second.dimension;
}

const char* pluralOfKind(int vtkType) {
  const auto kind = kinds().find(vtkType);
  return kind == kinds().end() ? nullptr : kind->second.plural;
}

std::string describe(const CellKinds& found) {
  std::string text;
  for (const auto& [type, count] : found) {
    const char* plural = pluralOfKind(type);
    text += (text.empty() ? "" : ", ") + (plural ? plural : "cells of type " + std::to_string(type)) + " (" +
            std::to_string(count) + ")";
  }
  return text;
}

}  // namespace gxy

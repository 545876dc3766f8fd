// SPDX-License-Identifier: Apache-2.0
// Hexahedra, wedges and pyramids for the tests of the reference renderer.
#pragma once
#include <array>
#include <functional>
#include <vector>

#include "core/reference/mesh_field.h"
#include "tests/reference/mesh_samples.h"
#include "tests/support/cell_meshes.h"

namespace gxy::reference {

/// A way to fill [0, 1]^3 with cells; see cubeOfHexes() and those beside it.
struct CellFilling {
  using Move = std::function<glm::dvec3(glm::dvec3)>;
  using Value = std::function<double(glm::dvec3)>;
  const char* name;
  MeshPiece (*make)(uint32_t n, const Move& move, const Value& value);
};

inline const std::array<CellFilling, 4> kFillings{{
    {"hexahedra", [](uint32_t n, const CellFilling::Move& m,
                     const CellFilling::Value& v) { return test::cubeOfHexes(n, m, v); }},
    {"wedges", [](uint32_t n, const CellFilling::Move& m,
                  const CellFilling::Value& v) { return test::cubeOfWedges(n, m, v); }},
    {"pyramids", [](uint32_t n, const CellFilling::Move& m,
                    const CellFilling::Value& v) { return test::cubeOfPyramids(n, m, v); }},
    {"all", [](uint32_t n, const CellFilling::Move& m,
               const CellFilling::Value& v) { return test::cubeOfAllCells(n, m, v); }},
}};

/// VTK's shape functions of a linear cell, in VTK's parametric coordinates.
inline std::array<double, 8> vtkShape(CellType type, glm::dvec3 p) {
  const double r = p.x, s = p.y, t = p.z, rm = 1 - r, sm = 1 - s, tm = 1 - t;
  switch (type) {
    case CellType::Pyramid:
      return {rm * sm * tm, r * sm * tm, r * s * tm, rm * s * tm, t};
    case CellType::Wedge:
      return {(1 - r - s) * tm, r * tm, s * tm, (1 - r - s) * t, r * t, s * t};
    case CellType::Hexahedron:
      return {rm * sm * tm, r * sm * tm, r * s * tm, rm * s * tm,
              rm * sm * t,  r * sm * t,  r * s * t,  rm * s * t};
    case CellType::Tetrahedron:
      break;
  }
  return {1 - r - s - t, r, s, t};
}

/// A parametric place inside a cell.
inline glm::dvec3 randomPlace(CellType type, Uniform& random) {
  glm::dvec3 p = glm::dvec3(0.5) + random.inCube(0.48);
  if (type == CellType::Wedge && p.x + p.y > 1) p.x = 1 - p.x, p.y = 1 - p.y;
  return p;
}

/// One cell of a type with the corners of a unit cube, pyramid or prism, moved by up to `far` on each axis, and random values.
inline MeshPiece oneBentCell(CellType type, double far, Uniform& random) {
  static const std::array<std::vector<glm::dvec3>, kCellTypes> kCorners{
      {{},
       {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 0.5, 1}},
       {{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {0, 0, 1}, {0, 1, 1}, {1, 0, 1}},
       {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}}}};
  MeshPiece piece;
  for (const glm::dvec3& corner : kCorners[size_t(type)]) {
    piece.cells.points[size_t(type)].push_back(uint32_t(piece.points.size()));
    piece.numbers.push_back(piece.points.size());
    piece.points.push_back(corner + random.inCube(far));
    piece.values.push_back(float(random()));
  }
  return piece;
}

}  // namespace gxy::reference

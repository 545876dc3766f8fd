// SPDX-License-Identifier: Apache-2.0
// Meshes of hexahedra, wedges, pyramids and of all types of cells in [-1, 1]^3.
#pragma once
#include <array>
#include <cmath>
#include <string>

#include "core/comm/random.h"
#include "core/data/mesh_blocks.h"
#include "tests/meshes/shapes.h"
#include "tests/support/cell_meshes.h"
#include "tests/support/meshes.h"

namespace gxy::test {

enum class Cells { Hexahedra, Wedges, Pyramids, Tetrahedra, All };
inline constexpr std::array kOtherCells{Cells::Hexahedra, Cells::Wedges, Cells::Pyramids, Cells::All};

inline std::string nameOf(Cells cells) {
  switch (cells) {
    case Cells::Hexahedra:
      return "hexahedra";
    case Cells::Wedges:
      return "wedges";
    case Cells::Pyramids:
      return "pyramids";
    case Cells::Tetrahedra:
      return "tetrahedra";
    default:
      return "all";
  }
}

/// n^3 cubes of such cells with the value field(place) at each point. Inner points are moved by up to `far` of a cube's side on each
/// axis, so that faces are not flat; those of the border in it, so that it is.
inline MeshPiece cubeOfCells(Cells cells, uint32_t n, double far, const Field& field, uint64_t seed = 1) {
  Random random(seed);
  const auto move = [&](glm::dvec3 p) {
    glm::dvec3 by(0);
    for (int a = 0; a < 3; a++) {
      const double r = double(random.next() >> 11) * 0x1p-52 - 1;
      if (p[a] > 0 && p[a] < 1) by[a] = far / n * r;
    }
    return by;
  };
  const auto value = [&](glm::dvec3 q) { return field(2.0 * q - 1.0); };
  const auto made = [&] {
    switch (cells) {
      case Cells::Hexahedra:
        return cubeOfHexes(n, move, value);
      case Cells::Wedges:
        return cubeOfWedges(n, move, value);
      case Cells::Pyramids:
        return cubeOfPyramids(n, move, value);
      case Cells::Tetrahedra:
        return cubeOfTets(n, move, value);
      default:
        return cubeOfAllCells(n, move, value);
    }
  };
  return placed(made(), [](glm::dvec3 q) { return 2.0 * q - 1.0; });
}

}  // namespace gxy::test

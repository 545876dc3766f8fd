// SPDX-License-Identifier: Apache-2.0
// The meshes of cells that other tests take: their cells fill the cube, face to face.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "core/comm/random.h"
#include "core/data/connect.h"
#include "tests/support/cell_meshes.h"
#include "tests/support/meshes.h"

namespace gxy::test {
namespace {

/// Three times the volume between the origin and a face, which is bilinear if it has four corners. Two points of Gauss each way are exact.
double coneOver(const std::array<glm::dvec3, 4>& q, int corners) {
  if (corners == 3) return glm::dot(q[0], glm::cross(q[1] - q[0], q[2] - q[0])) / 2;
  double sum = 0;
  for (const double u : {0.5 - std::sqrt(1 / 12.0), 0.5 + std::sqrt(1 / 12.0)})
    for (const double v : {0.5 - std::sqrt(1 / 12.0), 0.5 + std::sqrt(1 / 12.0)}) {
      const glm::dvec3 low = (1 - u) * q[0] + u * q[1], high = (1 - u) * q[3] + u * q[2];
      const glm::dvec3 alongU = (1 - v) * (q[1] - q[0]) + v * (q[2] - q[3]);
      sum += glm::dot((1 - v) * low + v * high, glm::cross(alongU, high - low)) / 4;
    }
  return sum;
}

double volumeOf(const MeshPiece& piece, uint32_t cell) {
  const auto points = piece.cells.pointsOf(cell);
  const CellShape& shape = shapeOf(piece.cells.typeOf(cell));
  double sum = 0;
  for (size_t f = 0; f < shape.faces; f++) {
    std::array<glm::dvec3, 4> q{};
    for (size_t k = 0; k < shape.face[f].corners; k++) q[k] = piece.points[points[shape.face[f].corner[k]]];
    sum += coneOver(q, shape.face[f].corners);
  }
  return sum / 3;
}

/// Expects cells that fill [0, 1]^3: volumes add up to 1, and each face is of two cells or in the border.
void expectFull(const MeshPiece& piece, bool oneOrientation = true) {
  ASSERT_EQ(piece.values.size(), piece.points.size());
  ASSERT_EQ(piece.numbers.size(), piece.points.size());
  double volume = 0;
  for (uint32_t cell = 0; cell < piece.cells.size(); cell++) {
    const double one = volumeOf(piece, cell);
    if (oneOrientation) {
      EXPECT_GT(one, 0);
    }
    volume += std::abs(one);
  }
  EXPECT_NEAR(volume, 1, 1e-12);
  const Connectivity joined = connect(piece.cells, piece.points.size());
  EXPECT_EQ(joined.crowded + joined.repeated + joined.twins, 0u);
  if (oneOrientation) {
    EXPECT_EQ(joined.sameSide, 0u);
  }
  for (const FaceId id : joined.shell) {
    const CellFace& face = shapeOf(piece.cells.typeOf(cellOf(id))).face[size_t(faceOf(id))];
    bool onBorder = false;
    for (int a = 0; a < 3; a++)
      for (const double side : {0.0, 1.0}) {
        const auto isThere = [&](size_t k) {
          return piece.points[piece.cells.pointsOf(cellOf(id))[face.corner[k]]][a] == side;
        };
        bool all = true;
        for (size_t k = 0; k < face.corners; k++) all = all && isThere(k);
        onBorder = onBorder || all;
      }
    EXPECT_TRUE(onBorder) << "face " << faceOf(id) << " of cell " << cellOf(id);
  }
}

class CellMeshes : public testing::TestWithParam<uint32_t> {
 protected:
  /// Moves points by up to 0.15 of a cube on each axis, those of the border within it.
  auto moved() {
    return [n = GetParam(), random = Random(7)](glm::dvec3 p) mutable {
      glm::dvec3 step(0);
      for (int a = 0; a < 3; a++) {
        const double r = double(random.next() >> 11) * 0x1p-52 - 1;
        if (p[a] > 0 && p[a] < 1) step[a] = 0.15 / n * r;
      }
      return step;
    };
  }
  static double valueAt(glm::dvec3 p) { return p.x + 2 * p.y - p.z; }
};

TEST_P(CellMeshes, FillTheCubeFaceToFace) {
  const uint32_t n = GetParam();
  const auto still = [](glm::dvec3) { return glm::dvec3(0); };
  for (const bool moves : {false, true}) {
    const auto check = [&](auto make, bool oneOrientation = true) {
      const MeshPiece piece = moves ? make(moved()) : make(still);
      expectFull(piece, oneOrientation);
      for (size_t i = 0; i < piece.points.size(); i++)
        EXPECT_EQ(piece.values[i], float(valueAt(piece.points[i])));
      return piece.cells;
    };
    const auto hexes = check([&](auto move) { return cubeOfHexes(n, move, valueAt); });
    EXPECT_EQ(hexes.size(CellType::Hexahedron), size_t(n * n * n));
    const auto wedges = check([&](auto move) { return cubeOfWedges(n, move, valueAt); });
    EXPECT_EQ(wedges.size(CellType::Wedge), size_t(2 * n * n * n));
    const auto pyramids = check([&](auto move) { return cubeOfPyramids(n, move, valueAt); });
    EXPECT_EQ(pyramids.size(CellType::Pyramid), size_t(6 * n * n * n));
    check([&](auto move) { return cubeOfTets(n, move, valueAt); });
    if (n < 2) continue;
    const auto all = check([&](auto move) { return cubeOfAllCells(n, move, valueAt); });
    for (const CellType type : kAllCellTypes) EXPECT_GT(all.size(type), 0u);
  }
}

INSTANTIATE_TEST_SUITE_P(Sizes, CellMeshes, testing::Values(1u, 2u, 3u, 4u, 5u));

}  // namespace
}  // namespace gxy::test

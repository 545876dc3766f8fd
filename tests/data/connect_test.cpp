// SPDX-License-Identifier: Apache-2.0
// The cells of meshes, and which of them share faces.
#include <gtest/gtest.h>

#include <algorithm>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <map>
#include <numeric>
#include <set>
#include <string>
#include <vector>

#include "core/comm/error.h"
#include "core/comm/random.h"
#include "core/data/connect.h"
#include "tests/support/seeds.h"

namespace gxy::test {
namespace {

void add(MeshCells& cells, CellType type, const std::vector<uint32_t>& points) {
  auto& all = cells.points[size_t(type)];
  all.insert(all.end(), points.begin(), points.end());
}

std::vector<uint32_t> cornersOf(const MeshCells& cells, FaceId id) {
  const CellFace& face = shapeOf(cells.typeOf(cellOf(id))).face[size_t(faceOf(id))];
  std::vector<uint32_t> corners;
  for (int i = 0; i < face.corners; i++)
    corners.push_back(cells.pointsOf(cellOf(id))[face.corner[size_t(i)]]);
  return corners;
}

FaceId neighbourOf(const MeshCells& cells, const Connectivity& c, FaceId id) {
  const CellType type = cells.typeOf(cellOf(id));
  return c
      .neighbours[size_t(type)][(cellOf(id) - cells.first(type)) * shapeOf(type).faces + size_t(faceOf(id))];
}

/// What must hold for any mesh: neighbours are mutual, and a face has one or is on the shell or has no area.
void expectConsistent(const MeshCells& cells, const Connectivity& c) {
  const std::set<FaceId> shell(c.shell.begin(), c.shell.end());
  EXPECT_EQ(shell.size(), c.shell.size());
  EXPECT_TRUE(std::is_sorted(c.shell.begin(), c.shell.end()));
  for (uint32_t cell = 0; cell < cells.size(); cell++)
    for (int f = 0; f < shapeOf(cells.typeOf(cell)).faces; f++) {
      const FaceId id = faceId(cell, f), other = neighbourOf(cells, c, id);
      if (other == kNoFace) continue;
      EXPECT_EQ(neighbourOf(cells, c, other), id);
      EXPECT_EQ(shell.count(id), 0u);
      const auto one = cornersOf(cells, id), two = cornersOf(cells, other);
      EXPECT_EQ(std::set(one.begin(), one.end()), std::set(two.begin(), two.end()));
    }
}

/// Cells that fill a box of n x n x n cubes, each cut into cells of one type; pyramids have their tops in the middle.
enum class Way { Hexahedron, Wedges, Tetrahedra, Pyramids };
MeshCells cubes(uint32_t n, Way way) {
  MeshCells cells;
  const uint32_t m = n + 1;
  uint32_t middle = m * m * m;
  for (uint32_t z = 0; z < n; z++)
    for (uint32_t y = 0; y < n; y++)
      for (uint32_t x = 0; x < n; x++) {
        const auto p = [&](uint32_t i, uint32_t j, uint32_t k) { return x + i + m * (y + j + m * (z + k)); };
        const std::vector<uint32_t> h{p(0, 0, 0), p(1, 0, 0), p(1, 1, 0), p(0, 1, 0),
                                      p(0, 0, 1), p(1, 0, 1), p(1, 1, 1), p(0, 1, 1)};
        switch (way) {
          case Way::Hexahedron:
            add(cells, CellType::Hexahedron, h);
            break;
          case Way::Wedges:
            add(cells, CellType::Wedge, {h[0], h[2], h[1], h[4], h[6], h[5]});
            add(cells, CellType::Wedge, {h[0], h[3], h[2], h[4], h[7], h[6]});
            break;
          case Way::Tetrahedra:  // Kuhn's six around the diagonal
            for (const auto& [a, b] : {std::pair{1, 2}, {2, 3}, {3, 7}, {7, 4}, {4, 5}, {5, 1}})
              add(cells, CellType::Tetrahedron, {h[0], h[size_t(a)], h[size_t(b)], h[6]});
            break;
          case Way::Pyramids:
            for (const CellFace& face : shapeOf(CellType::Hexahedron).face)
              add(cells, CellType::Pyramid,
                  {h[face.corner[3]], h[face.corner[2]], h[face.corner[1]], h[face.corner[0]], middle});
            middle++;
            break;
        }
      }
  return cells;
}

glm::dvec3 pointOfCubes(uint32_t n, uint32_t point) {
  const uint32_t m = n + 1;
  if (point < m * m * m) return {point % m, point / m % m, point / (m * m)};
  point -= m * m * m;
  return glm::dvec3(point % n, point / n % n, point / (n * n)) + 0.5;
}

/// By the theorem of Gauss, over faces that are cut into fans.
double volumeOf(const MeshCells& cells, uint32_t cell, uint32_t n) {
  double volume = 0;
  for (int f = 0; f < shapeOf(cells.typeOf(cell)).faces; f++) {
    const auto corners = cornersOf(cells, faceId(cell, f));
    for (size_t i = 2; i < corners.size(); i++) {
      const auto at = [&](size_t k) { return pointOfCubes(n, corners[k]) - glm::dvec3(0.3, 0.7, 1.1); };
      volume += glm::dot(at(0), glm::cross(at(i - 1), at(i))) / 6;
    }
  }
  return volume;
}

constexpr struct {
  Way way;
  CellType type;
  uint32_t ofACube, shellOfASquare;
} kWays[] = {{Way::Hexahedron, CellType::Hexahedron, 1, 1},
             {Way::Wedges, CellType::Wedge, 2, 1},
             {Way::Tetrahedra, CellType::Tetrahedron, 6, 2},
             {Way::Pyramids, CellType::Pyramid, 6, 1}};

TEST(MeshCells, HaveFacesThatAreCounterclockwiseFromOutside) {
  for (const auto& [way, type, ofACube, ignored] : kWays) {
    const MeshCells cells = cubes(3, way);
    EXPECT_EQ(cells.size(), 27u * ofACube);
    EXPECT_EQ(cells.size(type), cells.size());
    for (uint32_t cell = 0; cell < cells.size(); cell++)
      EXPECT_NEAR(volumeOf(cells, cell, 3), 1.0 / ofACube, 1e-12) << int(type) << " " << cell;
  }
}

TEST(MeshCells, AreNumberedByType) {
  MeshCells cells;
  add(cells, CellType::Hexahedron, {0, 1, 2, 3, 4, 5, 6, 7});
  add(cells, CellType::Tetrahedron, {8, 9, 10, 11});
  add(cells, CellType::Wedge, {1, 2, 3, 4, 5, 6});
  add(cells, CellType::Tetrahedron, {9, 10, 11, 12});
  EXPECT_EQ(cells.size(), 4u);
  EXPECT_EQ(cells.typeOf(1), CellType::Tetrahedron);
  EXPECT_EQ(cells.typeOf(2), CellType::Wedge);
  EXPECT_EQ(cells.typeOf(3), CellType::Hexahedron);
  EXPECT_EQ(cells.first(CellType::Pyramid), 2u);
  EXPECT_EQ(cells.pointsOf(1)[3], 12u);
  EXPECT_EQ(cells.pointsOf(3)[7], 7u);
}

TEST(Connect, OneCellHasAllItsFacesOnTheShell) {
  for (const CellType type : kAllCellTypes) {
    MeshCells cells;
    std::vector<uint32_t> points(shapeOf(type).points);
    std::iota(points.begin(), points.end(), 0);
    add(cells, type, points);
    const Connectivity c = connect(cells, points.size());
    EXPECT_EQ(c.shell.size(), shapeOf(type).faces);
    EXPECT_EQ(c.crowded + c.sameSide + c.repeated, 0u);
    expectConsistent(cells, c);
  }
  const Connectivity nothing = connect({}, 0);
  EXPECT_TRUE(nothing.shell.empty());
}

TEST(Connect, CellsThatFillABoxShareAllButItsSides) {
  for (const auto& [way, type, ofACube, shellOfASquare] : kWays) {
    constexpr uint32_t n = 5;
    const MeshCells cells = cubes(n, way);
    const Connectivity c = connect(cells, (n + 1) * (n + 1) * (n + 1) + n * n * n);
    const bool wedges = way == Way::Wedges;  // triangles above and below
    EXPECT_EQ(c.shell.size(), n * n * (6 * shellOfASquare + (wedges ? 2 : 0))) << int(type);
    EXPECT_EQ(c.crowded + c.sameSide + c.repeated, 0u) << int(type);
    expectConsistent(cells, c);
    for (const FaceId id : c.shell) {  // each lies in a side of the box
      const auto corners = cornersOf(cells, id);
      bool inSide = false;
      for (int axis = 0; axis < 3; axis++)
        for (const double side : {0.0, double(n)})
          inSide = inSide || std::all_of(corners.begin(), corners.end(),
                                         [&](uint32_t p) { return pointOfCubes(n, p)[axis] == side; });
      EXPECT_TRUE(inSide) << int(type) << " " << id;
    }
  }
}

/// Which faces are one, by a map of all of them: the points that follow each other around a face, from any point and either way.
std::map<std::vector<uint32_t>, std::vector<FaceId>> facesByPoints(const MeshCells& cells) {
  std::map<std::vector<uint32_t>, std::vector<FaceId>> faces;
  for (uint32_t cell = 0; cell < cells.size(); cell++)
    for (int f = 0; f < shapeOf(cells.typeOf(cell)).faces; f++) {
      std::vector<uint32_t> corners = cornersOf(cells, faceId(cell, f));
      for (bool fewer = true; fewer;) {
        fewer = false;
        for (size_t i = 0; i < corners.size() && corners.size() > 1 && !fewer; i++)
          if (corners[i] == corners[(i + 1) % corners.size()]) {
            corners.erase(corners.begin() + int64_t(i));
            fewer = true;
          }
      }
      if (std::set(corners.begin(), corners.end()).size() < std::max<size_t>(3, corners.size())) continue;
      std::vector<uint32_t> least = corners;
      for (int way = 0; way < 2; way++) {
        for (size_t i = 0; i < corners.size(); i++) {
          std::rotate(corners.begin(), corners.begin() + 1, corners.end());
          least = std::min(least, corners);
        }
        std::reverse(corners.begin(), corners.end());
      }
      faces[least].push_back(faceId(cell, f));
    }
  return faces;
}

TEST(Connect, FindsWhatAMapOfAllFacesFindsInRandomCellsOfFewPoints) {
  for (int seed = 0; seed < sweep(2000); seed++) {
    Random random{uint64_t(seed)};
    MeshCells cells;
    const auto points = uint32_t(4 + random.below(9));
    for (uint64_t n = random.below(40); n > 0; n--) {
      const auto type = CellType(random.below(kCellTypes));
      std::vector<uint32_t> cell(shapeOf(type).points);
      for (uint32_t& p : cell) p = uint32_t(random.below(points));
      add(cells, type, cell);
    }
    const Connectivity c = connect(cells, points);
    expectConsistent(cells, c);
    uint64_t crowded = 0;
    std::vector<FaceId> shell;
    for (const auto& [corners, faces] : facesByPoints(cells)) {
      crowded += faces.size() > 2;
      if (faces.size() == 2)
        EXPECT_EQ(neighbourOf(cells, c, faces[0]), faces[1]) << seed;
      else
        shell.insert(shell.end(), faces.begin(), faces.end());
    }
    std::sort(shell.begin(), shell.end());
    EXPECT_EQ(c.shell, shell) << seed;
    EXPECT_EQ(c.crowded, crowded) << seed;
  }
}

TEST(Connect, DoesNotDependOnHowPointsAreNumbered) {
  const MeshCells cells = cubes(3, Way::Tetrahedra);
  const Connectivity expected = connect(cells, 64);
  for (int seed = 0; seed < sweep(20); seed++) {
    Random random{uint64_t(seed)};
    std::vector<uint32_t> other(64);
    std::iota(other.begin(), other.end(), 0);
    for (size_t i = other.size(); i > 1; i--) std::swap(other[i - 1], other[random.below(i)]);
    MeshCells renumbered = cells;
    for (auto& all : renumbered.points)
      for (uint32_t& p : all) p = other[p];
    const Connectivity c = connect(renumbered, 64);
    EXPECT_EQ(c.neighbours, expected.neighbours) << seed;
    EXPECT_EQ(c.shell, expected.shell) << seed;
  }
}

TEST(Connect, CountsCellsThatAreInvertedAndFacesOfMoreThanTwo) {
  MeshCells two;
  add(two, CellType::Tetrahedron, {0, 1, 2, 3});
  add(two, CellType::Tetrahedron, {1, 3, 2, 4});  // one is inverted: their face runs the same way in both
  Connectivity c = connect(two, 5);
  EXPECT_EQ(c.shell.size(), 6u);
  EXPECT_EQ(c.sameSide, 1u);
  two.points[0] = {0, 1, 2, 3, 1, 2, 3, 4};
  c = connect(two, 5);
  EXPECT_EQ(c.shell.size(), 6u);
  EXPECT_EQ(c.sameSide, 0u);
  add(two, CellType::Tetrahedron, {1, 2, 3, 5});
  c = connect(two, 6);
  EXPECT_EQ(c.crowded, 1u);
  EXPECT_EQ(c.shell.size(), 12u) << "none of the three is anybody's neighbour";
}

TEST(Connect, CollapsedHexahedraMeetTriangles) {
  MeshCells cells;
  add(cells, CellType::Hexahedron, {0, 1, 2, 2, 3, 4, 5, 5});  // a wedge
  add(cells, CellType::Tetrahedron, {0, 2, 1, 6});
  const Connectivity c = connect(cells, 7);
  EXPECT_EQ(c.repeated, 1u);
  EXPECT_EQ(c.shell.size(), 3u + 1 + 3) << "three quads, the other triangle, and the tetrahedron's";
  EXPECT_EQ(neighbourOf(cells, c, faceId(0, 3)), faceId(1, 4));
  EXPECT_EQ(c.sameSide, 0u);
}

TEST(Connect, QuadsOfTheSamePointsInAnotherOrderAreNotOne) {
  MeshCells cells;
  add(cells, CellType::Pyramid, {0, 1, 2, 3, 4});
  add(cells, CellType::Pyramid, {0, 1, 3, 2, 5});
  EXPECT_EQ(connect(cells, 6).shell.size(), 10u);
  cells.points[size_t(CellType::Pyramid)] = {0, 1, 2, 3, 4, 2, 1, 0, 3, 5};
  EXPECT_EQ(connect(cells, 6).shell.size(), 8u);
}

TEST(Connect, IslandsAndPointsThatTouchStayApart) {
  MeshCells cells;
  add(cells, CellType::Tetrahedron, {0, 1, 2, 3});
  add(cells, CellType::Tetrahedron, {3, 4, 5, 6});    // touches at a point
  add(cells, CellType::Tetrahedron, {7, 8, 9, 10});   // an island
  add(cells, CellType::Tetrahedron, {0, 1, 11, 12});  // touches at an edge
  EXPECT_EQ(connect(cells, 13).shell.size(), 16u);
}

TEST(Connect, CountsCellsThatAreThereTwice) {
  MeshCells cells;
  add(cells, CellType::Tetrahedron, {0, 1, 2, 3});
  add(cells, CellType::Tetrahedron, {1, 2, 3, 4});
  EXPECT_EQ(connect(cells, 5).twins, 0u);
  add(cells, CellType::Hexahedron, {5, 6, 7, 8, 9, 10, 11, 12});
  add(cells, CellType::Hexahedron, {9, 10, 11, 12, 5, 6, 7, 8});
  const Connectivity c = connect(cells, 13);
  EXPECT_EQ(c.twins, 2u);
  EXPECT_EQ(c.shell.size(), 6u);
}

TEST(Connect, RefusesPointsThatAreNotThere) {
  MeshCells cells;
  add(cells, CellType::Tetrahedron, {0, 1, 2, 9});
  try {
    connect(cells, 9);
    FAIL() << "expected an error";
  } catch (const Error& e) {
    EXPECT_EQ(std::string(e.what()), "a cell has point 9 of a mesh of 9 points (counted from 0)");
  }
  EXPECT_THROW(connect({}, uint64_t(1) << 31), Error);
}

}  // namespace
}  // namespace gxy::test

// SPDX-License-Identifier: Apache-2.0
// Meshes of cells of all types as blocks of partitions, and hexahedra that are other cells.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <random>
#include <set>

#include "core/data/collapsed.h"
#include "core/data/connect.h"
#include "core/data/mesh_blocks.h"
#include "core/data/replicate.h"
#include "tests/data/mesh_pieces.h"
#include "tests/data/random_partitioning.h"
#include "tests/support/mixed_meshes.h"

namespace gxy {
namespace {

using test::addCell;
using test::dealtOut;

constexpr size_t kTet = size_t(CellType::Tetrahedron), kPyramid = size_t(CellType::Pyramid),
                 kHex = size_t(CellType::Hexahedron);
using Counts = std::array<uint64_t, kCellTypes>;
using Corners = std::vector<std::array<double, 3>>;  // of a cell, in its order

const Box kUnitBox{{0, 0, 0}, {1, 1, 1}};

MeshPiece warpedCells(uint32_t n) {
  return test::cubeOfMixedCells(
      n, [](const glm::dvec3& p) { return 0.03 * glm::dvec3(std::sin(9 * p.y), std::sin(7 * p.z), p.x); },
      [](const glm::dvec3& p) { return p.x + 2 * p.y + 4 * p.z; });
}

template <class Points, class Cells>
Corners cornersAt(const Points& points, const Cells& cells, uint32_t cell) {
  Corners corners;
  for (const uint32_t p : cells.pointsOf(cell)) corners.push_back(test::placeOf(points[p]));
  if (cells.typeOf(cell) == CellType::Tetrahedron) std::sort(corners.begin(), corners.end());
  return corners;
}

template <class Points, class Cells>
std::multiset<Corners> cellsAt(const Points& points, const Cells& cells) {
  std::multiset<Corners> all;
  for (uint32_t cell = 0; cell < cells.size(); cell++) all.insert(cornersAt(points, cells, cell));
  return all;
}

glm::dvec3 areaOf(const MeshBlock& block, FaceId id) {
  const CellFace& face = shapeOf(block.cells.typeOf(cellOf(id))).face[size_t(faceOf(id))];
  const auto cell = block.cells.pointsOf(cellOf(id));
  const auto at = [&](size_t k) { return block.points[cell[face.corner[k]]]; };
  return 0.5 * (face.corners == 3 ? glm::cross(at(1) - at(0), at(2) - at(0))
                                  : glm::cross(at(2) - at(0), at(3) - at(1)));
}

double shellAreaOf(const MeshBlock& block) {
  double area = 0;
  for (const FaceId id : block.shell) area += glm::length(areaOf(block, id));
  return area;
}

/// By the theorem of Gauss; of cells with flat faces. It is positive if the faces run counterclockwise seen from outside. Tetrahedra,
/// which a block turns as it likes, count as positive.
double volumeOf(const MeshBlock& block, uint32_t cell) {
  const CellShape& shape = shapeOf(block.cells.typeOf(cell));
  double volume = 0;
  for (int f = 0; f < shape.faces; f++) {
    const uint32_t corner = block.cells.pointsOf(cell)[shape.face[size_t(f)].corner[0]];
    volume += glm::dot(block.points[corner] - glm::dvec3(0.3, 0.7, 1.1), areaOf(block, faceId(cell, f))) / 3;
  }
  return block.cells.typeOf(cell) == CellType::Tetrahedron ? std::abs(volume) : volume;
}

double volumeOf(const MeshBlock& block) {
  double volume = 0;
  for (uint32_t cell = 0; cell < block.cells.size(); cell++) volume += volumeOf(block, cell);
  return volume;
}

MeshBlock blockOf(const MeshPiece& mesh, MeshBlockCounts& counts) {
  Box box;
  for (const glm::dvec3& p : mesh.points) box.extend(p);
  return meshBlock(mesh, Partitioning::single(box), 0, counts);
}

TEST(MixedCells, FillACubeWithoutGaps) {
  const auto still = [](const glm::dvec3&) { return glm::dvec3(0); };
  const MeshPiece mesh = test::cubeOfMixedCells(4, still, [](const glm::dvec3& p) { return p.x; });
  for (const CellType type : kAllCellTypes) EXPECT_GT(mesh.cells.size(type), 3u) << int(type);
  MeshBlockCounts counts;
  const MeshBlock block = blockOf(mesh, counts);
  EXPECT_NEAR(shellAreaOf(block), 6, 1e-12);
  EXPECT_NEAR(volumeOf(block), 1, 1e-12);
  for (uint32_t cell = 0; cell < block.cells.size(); cell++) EXPECT_GT(volumeOf(block, cell), 0) << cell;
  EXPECT_EQ(counts.points, mesh.points.size());
  EXPECT_EQ(counts.crowdedFaces + counts.foldedFaces, 0u);
}

TEST(MixedCells, ABlockDoesNotDependOnTheOrderOfCellsPointsAndPieces) {
  const MeshPiece mesh = warpedCells(5);
  Counts ofTypes;
  for (const CellType type : kAllCellTypes) ofTypes[size_t(type)] = mesh.cells.size(type);
  for (uint32_t seed = 1; seed <= 20; seed++) {
    std::mt19937 random(seed);
    const int ranks = 1 + int(random() % 4);
    const Partitioning cut = test::randomPartitioning(random, kUnitBox, 1 + int(random() % 9), ranks);
    MeshBlockCounts expectedCounts, counts;
    std::map<int, MeshBlock> expected;
    for (int r = 0; r < ranks; r++) {
      const std::vector<Bytes> messages = packForOwners(mesh, cut, ranks);
      expected.merge(unpackMesh(cut, r, std::span(&messages[size_t(r)], 1), expectedCounts));
    }
    const auto blocks = dealtOut(test::shuffled(mesh, random), cut, ranks, random, counts);
    ASSERT_EQ(blocks.size(), expected.size()) << seed;
    for (const auto& [partition, block] : blocks)
      EXPECT_TRUE(test::areEqual(block, expected.at(partition))) << seed;
    for (const MeshBlockCounts& c : {expectedCounts, counts}) {
      EXPECT_EQ(c.points, mesh.points.size());
      EXPECT_EQ(c.cells, ofTypes);
      EXPECT_EQ(c.repeatedCells + c.degenerateCells + c.mergedPoints + c.differingPoints + c.crowdedFaces +
                    c.foldedFaces,
                0u);
    }
  }
}

TEST(MixedCells, APartitionHasTheCellsWhoseInflatedBoxesItTouches) {
  const MeshPiece mesh = warpedCells(4);
  for (uint32_t seed = 1; seed <= 10; seed++) {
    std::mt19937 random(seed);
    const Partitioning cut = test::randomPartitioning(random, kUnitBox, 12, 3);
    MeshBlockCounts counts;
    const auto blocks = dealtOut(mesh, cut, 3, random, counts);
    const double slack = borderSlack(cut);
    for (int p = 0; p < cut.partitions(); p++) {
      std::multiset<Corners> expected;
      for (uint32_t cell = 0; cell < mesh.cells.size(); cell++) {
        Box box;
        for (const uint32_t point : mesh.cells.pointsOf(cell)) box.extend(mesh.points[point]);
        bool touches = true;
        for (int a = 0; a < 3; a++) {
          const double lo = cut.box(p).lo[a], hi = cut.box(p).hi[a];
          touches = touches && (lo == 0 || box.hi[a] + slack >= lo) && (hi == 1 || box.lo[a] - slack <= hi);
        }
        if (touches) expected.insert(cornersAt(mesh.points, mesh.cells, cell));
      }
      const auto block = blocks.find(p);
      ASSERT_NE(block, blocks.end());
      EXPECT_EQ(cellsAt(block->second.points, block->second.cells), expected) << seed << " " << p;
    }
  }
}

TEST(MixedCells, NeighboursAndShellAreThoseOfTheBlock) {
  std::mt19937 random(3);
  const Partitioning cut = test::randomPartitioning(random, kUnitBox, 5, 1);
  MeshBlockCounts counts;
  for (const auto& [partition, block] : dealtOut(warpedCells(4), cut, 1, random, counts)) {
    const Connectivity found = connect(test::cellsOf(block), block.points.size());
    EXPECT_TRUE(block.neighbours == shared(found.neighbours));
    EXPECT_TRUE(block.shell == found.shell);
    EXPECT_FALSE(block.shell.empty());
  }
}

TEST(MixedCells, RepeatedCellsOfEachTypeAreCountedOnceWhereverTheyBegin) {
  const MeshPiece mesh = warpedCells(3);
  MeshPiece repeated = mesh;
  for (const auto& turn : std::vector<std::pair<CellType, std::vector<size_t>>>{
           {CellType::Tetrahedron, {2, 0, 1, 3}},
           {CellType::Pyramid, {1, 2, 3, 0, 4}},
           {CellType::Wedge, {1, 2, 0, 4, 5, 3}},
           {CellType::Hexahedron, {3, 0, 1, 2, 7, 4, 5, 6}}}) {
    std::vector<uint32_t>& cells = repeated.cells.points[size_t(turn.first)];
    const std::vector<uint32_t> first(cells.begin(), cells.begin() + std::ptrdiff_t(turn.second.size()));
    for (const size_t i : turn.second) cells.push_back(first[i]);
  }
  std::mt19937 random(4);
  const Partitioning cut = test::randomPartitioning(random, kUnitBox, 6, 3);
  MeshBlockCounts counts;
  size_t cells = 0;
  for (const auto& [partition, block] : dealtOut(repeated, cut, 3, random, counts)) {
    std::set<std::set<std::array<double, 3>>> distinct;
    for (uint32_t cell = 0; cell < block.cells.size(); cell++) {
      const Corners corners = cornersAt(block.points, block.cells, cell);
      distinct.emplace(corners.begin(), corners.end());
    }
    EXPECT_EQ(distinct.size(), block.cells.size());
    cells += distinct.size();
  }
  EXPECT_GT(cells, mesh.cells.size());
  EXPECT_EQ(counts.repeatedCells, 4u);
  for (const CellType type : kAllCellTypes)
    EXPECT_EQ(counts.cells[size_t(type)], mesh.cells.size(type)) << int(type);
}

/// The points of a hexahedron or wedge over a polygon of them, from z = 0 to z = `height`.
void addColumn(MeshPiece& mesh, CellType type, const std::vector<uint32_t>& below, double height) {
  auto& cells = mesh.cells.points[size_t(type)];
  cells.insert(cells.end(), below.begin(), below.end());
  for (const uint32_t p : below) {
    cells.push_back(uint32_t(mesh.points.size()));
    mesh.points.push_back(mesh.points[p] + glm::dvec3(0.01, 0.02, height));
  }
}

// Two cells of a face at z = 0: above and below, both above, and one of them flat.
TEST(MixedCells, FacesWhoseCellsOverlapAreCountedOnceOfAnyTypes) {
  for (const double z : {-1.0, 0.5, 0.0})
    for (const bool isQuad : {true, false})
      for (const bool hasTop : {true, false}) {
        MeshPiece mesh;
        mesh.points = {{0.4, 0, 0}, {0.6, 0, 0}, {0.6, 1, 0}, {0.4, 1, 0}};
        const std::vector<uint32_t> face =
            isQuad ? std::vector<uint32_t>{0, 1, 2, 3} : std::vector<uint32_t>{0, 1, 2};
        addColumn(mesh, isQuad ? CellType::Hexahedron : CellType::Wedge, face, 1);
        if (hasTop) {
          auto& cells = mesh.cells.points[isQuad ? kPyramid : kTet];
          cells.insert(cells.end(), face.begin(), face.end());
          cells.push_back(uint32_t(mesh.points.size()));
          mesh.points.push_back({0.5, 0.2, z});
        } else {
          addColumn(mesh, isQuad ? CellType::Hexahedron : CellType::Wedge, face, z);
        }
        mesh.values.resize(mesh.points.size());
        for (size_t p = 0; p < mesh.points.size(); p++) mesh.numbers.push_back(p);
        const Partitioning two = Partitioning::lattice(
            {std::vector<double>{0, 0.5, 1}, std::vector<double>{0, 1}, std::vector<double>{-1, 2}}, 2);
        std::mt19937 random(1);
        MeshBlockCounts counts;
        EXPECT_EQ(dealtOut(mesh, two, 2, random, counts).size(), 2u);
        EXPECT_EQ(counts.foldedFaces, z < 0 ? 0u : 1u) << z << isQuad << hasTop;
      }
}

/// One hexahedron, of whose points those with the same number are the same, by number or only by place.
MeshPiece oneHexahedron(const std::array<uint32_t, 8>& same, bool byPlace) {
  MeshPiece mesh;
  for (uint32_t i = 0; i < 8; i++) {
    const uint32_t p = byPlace ? same[i] : i;
    mesh.points.push_back({(p + 1) / 2 % 2, p / 2 % 2, p / 4});
    mesh.values.push_back(float(p));
    mesh.numbers.push_back(i);
    mesh.cells.points[kHex].push_back(byPlace ? i : same[i]);
  }
  return mesh;
}

/// The 24 rotations of a cube, as what stands where its points have stood, and then the 24 with a reflection.
std::vector<std::array<uint32_t, 8>> waysOfTheCube() {
  const MeshPiece cube = oneHexahedron({0, 1, 2, 3, 4, 5, 6, 7}, false);
  std::vector<std::array<uint32_t, 8>> ways;
  for (const int mirrored : {1, -1}) {
    std::array<int, 3> axes{0, 1, 2};
    do {
      const int order = axes[1] == (axes[0] + 1) % 3 ? 1 : -1;
      for (int signs = 0; signs < 8; signs++) {
        const int flips = signs == 0 || signs == 3 || signs == 5 || signs == 6 ? 1 : -1;
        if (order * flips != mirrored) continue;
        std::array<uint32_t, 8> way;
        for (size_t i = 0; i < 8; i++) {
          glm::dvec3 q;
          for (int a = 0; a < 3; a++) {
            const double v = cube.points[i][axes[size_t(a)]];
            q[a] = signs >> a & 1 ? 1 - v : v;
          }
          way[i] = uint32_t(std::find(cube.points.begin(), cube.points.end(), q) - cube.points.begin());
        }
        ways.push_back(way);
      }
    } while (std::next_permutation(axes.begin(), axes.end()));
  }
  return ways;
}

struct Pattern {
  CellType type;
  std::array<uint32_t, 8> same;
  double volume;
};
const Pattern kPatterns[] = {{CellType::Wedge, {0, 1, 2, 2, 4, 5, 6, 6}, 0.5},
                             {CellType::Pyramid, {0, 1, 2, 3, 4, 4, 4, 4}, 1. / 3},
                             {CellType::Tetrahedron, {0, 1, 2, 2, 4, 4, 4, 4}, 1. / 6}};

TEST(CollapsedHexahedra, BecomeTheCellsThatTheyAreHoweverTurned) {
  const auto ways = waysOfTheCube();
  ASSERT_EQ(std::set(ways.begin(), ways.end()).size(), 48u);
  for (const auto& [type, same, volume] : kPatterns)
    for (size_t w = 0; w < 48; w++)
      for (const bool byPlace : {true, false}) {
        std::array<uint32_t, 8> turned;
        for (size_t i = 0; i < 8; i++) turned[i] = same[ways[w][i]];
        MeshBlockCounts counts;
        const MeshBlock block = blockOf(oneHexahedron(turned, byPlace), counts);
        ASSERT_EQ(block.cells.size(type), 1u) << int(type) << " " << w;
        EXPECT_EQ(counts.cells[size_t(type)], 1u);
        EXPECT_EQ(counts.cells[kHex] + counts.degenerateCells, 0u);
        EXPECT_EQ(counts.points, shapeOf(type).points);
        EXPECT_EQ(block.shell.size(), shapeOf(type).faces);
        const bool isInverted = w >= 24 && type != CellType::Tetrahedron;
        EXPECT_NEAR(volumeOf(block), isInverted ? -volume : volume, 1e-15) << int(type) << " " << w;
        std::set<float> values(block.values.begin(), block.values.end());
        EXPECT_EQ(values, std::set<float>(same.begin(), same.end()));
      }
}

TEST(CollapsedHexahedra, OfOtherPatternsAreDegenerate) {
  const std::array<uint32_t, 8> others[] = {{0, 1, 2, 2, 4, 5, 6, 7},  // one edge
                                            {0, 1, 0, 3, 4, 5, 6, 7},  // a diagonal
                                            {0, 1, 2, 2, 4, 5, 5, 7},  // two edges of no face
                                            {0, 1, 2, 3, 0, 1, 2, 3},  // flat
                                            {0, 0, 2, 2, 0, 0, 2, 2},  // a line
                                            {5, 5, 5, 5, 5, 5, 5, 5}};
  for (const auto& same : others) {
    EXPECT_FALSE(collapsed(same));
    MeshPiece mesh = oneHexahedron(same, false);
    addCell(mesh, CellType::Wedge, {0, 2, 1, 4, 6, 4});
    addCell(mesh, CellType::Pyramid, {0, 1, 2, 3, 1});
    MeshBlockCounts counts;
    EXPECT_EQ(blockOf(mesh, counts).cells.size(), 0u);
    EXPECT_EQ(counts.degenerateCells, 3u);
  }
  EXPECT_FALSE(collapsed(std::array<uint32_t, 8>{7, 6, 5, 4, 3, 2, 1, 0}));
}

/// A sector of a ball between two meridians, as a curvilinear grid of hexahedra in radius, latitude and longitude writes it: from the
/// centre, and from pole to pole.
MeshPiece ballSector(uint32_t n) {
  MeshPiece mesh;
  const uint32_t m = n + 1;
  for (uint32_t i = 0; i < m * m * m; i++) {
    const double r = double(i % m) / n, latitude = double(i / m % m) / n * 3.14159265358979,
                 longitude = double(i / (m * m)) / n;
    const bool isPole = i / m % m % n == 0;
    const double around = isPole ? 0 : r * std::sin(latitude);
    mesh.points.push_back(
        {around * std::cos(longitude), around * std::sin(longitude), r * std::cos(latitude)});
    mesh.values.push_back(float(r));
    mesh.numbers.push_back(i);
  }
  for (uint32_t i = 0; i < n * n * n; i++) {
    const uint32_t x = i % n, y = i / n % n, z = i / (n * n);
    const auto p = [&](uint32_t a, uint32_t b, uint32_t c) { return x + a + m * (y + b + m * (z + c)); };
    addCell(mesh, CellType::Hexahedron,
            {p(0, 0, 0), p(1, 0, 0), p(1, 1, 0), p(0, 1, 0), p(0, 0, 1), p(1, 0, 1), p(1, 1, 1), p(0, 1, 1)});
  }
  return mesh;
}

TEST(CollapsedHexahedra, FitTogetherAroundThePolesOfAGrid) {
  const MeshPiece mesh = ballSector(6);
  for (uint32_t seed = 1; seed <= 5; seed++) {
    std::mt19937 random(seed);
    const Partitioning cut = test::randomPartitioning(random, Box{{0, 0, -1}, {1, 1, 1}}, int(seed), 3);
    MeshBlockCounts counts;
    const auto blocks = dealtOut(mesh, cut, 3, random, counts);
    // Along the axis one cell in six rows on both sides, of which the innermost are tetrahedra; at the centre pyramids.
    EXPECT_EQ(counts.cells, (Counts{12, 24, 60, 120}));
    EXPECT_EQ(counts.degenerateCells + counts.crowdedFaces + counts.foldedFaces, 0u);
    EXPECT_EQ(counts.points, 1u + 2 * 6 + 6 * 5 * 7);
    if (blocks.size() > 1) continue;
    // The shell is the part of the sphere and both half discs, each a quad of the grid or a triangle of a collapsed one.
    EXPECT_EQ(blocks.begin()->second.shell.size(), 36u + 2 * 36u);
  }
}

}  // namespace
}  // namespace gxy

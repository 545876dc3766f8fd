// SPDX-License-Identifier: Apache-2.0
// Blocks of meshes whose data are those of cells.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <random>

#include "core/comm/error.h"
#include "tests/data/mesh_pieces.h"
#include "tests/data/random_partitioning.h"
#include "tests/support/cell_meshes.h"
#include "tests/support/meshes.h"

namespace gxy::cell_values {
namespace {

using test::areEqual;
using test::dealtOut;
using test::placeOf;
using test::shuffled;
using test::withCellValues;

constexpr size_t kHexes = size_t(CellType::Hexahedron);
const Box kDomain{{0, 0, 0}, {1, 1, 1}};
const auto kStill = [](glm::dvec3) { return glm::dvec3(0); };
const auto kZero = [](glm::dvec3) { return 0.0; };
double wavy(glm::dvec3 p) { return std::sin(5 * p.x) + std::cos(7 * p.y + p.z); }
glm::dvec3 bend(glm::dvec3 p) { return 0.03 * glm::dvec3(std::sin(9 * p.y), std::sin(7 * p.z), p.x); }

std::vector<MeshPiece> meshes() {
  return {withCellValues(test::cubeOfTets(5, bend, kZero), wavy),
          withCellValues(test::cubeOfAllCells(4, bend, kZero), wavy)};
}

MeshBlock wholeOf(const MeshPiece& mesh, MeshBlockCounts& counts) {
  return meshBlock(mesh, Partitioning::single(kDomain), 0, counts);
}

using Places = std::vector<std::array<double, 3>>;
Places placesOf(const MeshBlock& block, uint32_t cell) {
  Places places;
  for (const uint32_t p : block.cells.pointsOf(cell)) places.push_back(placeOf(block.points[p]));
  std::sort(places.begin(), places.end());
  return places;
}

TEST(CellValues, PointsAndCellsHaveThemInAnyPartitionsOnAnyRanks) {
  for (const MeshPiece& mesh : meshes()) {
    MeshBlockCounts wholeCounts;
    const MeshBlock whole = wholeOf(mesh, wholeCounts);
    std::map<std::array<double, 3>, float> ofPoint;
    std::map<Places, float> ofCell;
    for (size_t p = 0; p < whole.points.size(); p++) ofPoint[placeOf(whole.points[p])] = whole.values[p];
    for (uint32_t c = 0; c < whole.cells.size(); c++) ofCell[placesOf(whole, c)] = whole.cellValues[c];
    for (uint32_t seed = 1; seed <= 12; seed++) {
      std::mt19937 random(seed);
      const int ranks = 1 + int(random() % 4);
      const Partitioning cut = test::randomPartitioning(random, kDomain, 2 + int(random() % 12), ranks);
      MeshBlockCounts counts;
      for (const auto& [partition, block] : dealtOut(shuffled(mesh, random), cut, ranks, random, counts)) {
        ASSERT_EQ(block.cellValues.size(), block.cells.size());
        ASSERT_EQ(block.values.size(), block.points.size());
        for (size_t p = 0; p < block.points.size(); p++)
          ASSERT_EQ(block.values[p], ofPoint.at(placeOf(block.points[p]))) << seed;
        for (uint32_t c = 0; c < block.cells.size(); c++)
          ASSERT_EQ(block.cellValues[c], ofCell.at(placesOf(block, c))) << seed;
      }
      EXPECT_EQ(counts.cells, wholeCounts.cells);
      EXPECT_EQ(counts.points, wholeCounts.points);
      EXPECT_EQ(counts.repeatedCells + counts.differingCells + counts.differingPoints + counts.noDataCells,
                0u);
    }
  }
}

// A half of a mesh with a layer of duplicates of the other half.
TEST(CellValues, DuplicatesServeAveragesAndThenLeave) {
  const MeshPiece all = withCellValues(test::cubeOfHexes(6, bend, kZero), wavy);
  MeshPiece half = all;
  MeshCells kept;
  half.cellValues[kHexes].clear();
  half.duplicates[kHexes].clear();
  for (size_t cell = 0; cell < all.cells.size(); cell++) {
    if (cell % 6 > 3) continue;  // x
    const auto points = all.cells.pointsOf(uint32_t(cell));
    kept.points[kHexes].insert(kept.points[kHexes].end(), points.begin(), points.end());
    half.cellValues[kHexes].push_back(all.cellValues[kHexes][cell]);
    half.duplicates[kHexes].push_back(cell % 6 == 3);
  }
  half.cells = kept;
  MeshBlockCounts wholeCounts, counts;
  const MeshBlock whole = wholeOf(all, wholeCounts), block = wholeOf(half, counts);
  std::map<std::array<double, 3>, float> expected;
  for (size_t p = 0; p < whole.points.size(); p++) expected[placeOf(whole.points[p])] = whole.values[p];
  EXPECT_EQ(block.cells.size(), 108u);
  EXPECT_EQ(block.cellValues.size(), 108u);
  EXPECT_EQ(block.points.size(), 196u);
  EXPECT_EQ(counts.cells[kHexes], 108u);
  EXPECT_EQ(counts.points, 196u);
  EXPECT_EQ(counts.repeatedCells, 0u);
  for (size_t p = 0; p < block.points.size(); p++)
    EXPECT_EQ(block.values[p], expected.at(placeOf(block.points[p])));
  // Where the cells themselves are there, too, duplicates change nothing, whatever their values.
  MeshPiece both = all;
  for (size_t cell = 0; cell < 50; cell++) {
    const auto points = all.cells.pointsOf(uint32_t(cell));
    both.cells.points[kHexes].insert(both.cells.points[kHexes].end(), points.begin(), points.end());
    both.cellValues[kHexes].push_back(-99);
    both.duplicates[kHexes].push_back(1);
  }
  for (uint32_t seed = 1; seed <= 6; seed++) {
    std::mt19937 random(seed);
    MeshBlockCounts found;
    const auto blocks = dealtOut(shuffled(both, random), Partitioning::single(kDomain), 1, random, found);
    EXPECT_TRUE(areEqual(blocks.at(0), whole));
    EXPECT_EQ(found.repeatedCells + found.differingCells, 0u);
  }
}

TEST(CellValues, OfCellsWithTheSamePointsTheLowestIsUsed) {
  const MeshPiece all = withCellValues(test::cubeOfHexes(3, bend, kZero), wavy);
  MeshBlockCounts counts;
  const MeshBlock expected = wholeOf(all, counts);
  MeshPiece twice = all;
  for (size_t cell = 0; cell < 10; cell++) {
    const auto points = all.cells.pointsOf(uint32_t(cell));
    twice.cells.points[kHexes].insert(twice.cells.points[kHexes].end(), points.begin(), points.end());
    const float value = all.cellValues[kHexes][cell];
    twice.cellValues[kHexes].push_back(
        cell < 3 ? value : (cell < 6 ? std::numeric_limits<float>::quiet_NaN() : value + 1));
    twice.duplicates[kHexes].push_back(0);
  }
  for (uint32_t seed = 1; seed <= 10; seed++) {
    std::mt19937 random(seed);
    const int ranks = 1 + int(random() % 3);
    MeshBlockCounts found;
    const auto blocks =
        dealtOut(shuffled(twice, random), Partitioning::single(kDomain), ranks, random, found);
    EXPECT_TRUE(areEqual(blocks.at(0), expected));
    EXPECT_EQ(found.repeatedCells, 10u);
    EXPECT_EQ(found.differingCells, 7u);
  }
}

TEST(CellValues, CollapsedHexahedraKeepTheirs) {
  MeshPiece piece;
  piece.ofCells = true;
  // A hexahedron, a wedge (an edge collapsed in two faces), and a hexahedron again.
  for (int x = 0; x < 4; x++)
    for (int k = 0; k < 4; k++) piece.points.push_back(0.25 * glm::dvec3(x, k & 1, k >> 1));
  const auto cube = [](uint32_t x) {
    const uint32_t a = 4 * x, b = a + 4;
    return std::vector<uint32_t>{a, b, b + 1, a + 1, a + 2, b + 2, b + 3, a + 3};
  };
  auto& cells = piece.cells.points[kHexes];
  for (uint32_t x = 0; x < 3; x++) {
    std::vector<uint32_t> cell = cube(x);
    if (x == 1) cell[3] = cell[0], cell[7] = cell[4];
    cells.insert(cells.end(), cell.begin(), cell.end());
  }
  piece.numbers.resize(piece.points.size());
  for (size_t i = 0; i < piece.numbers.size(); i++) piece.numbers[i] = i;
  piece.cellValues[kHexes] = {1, 2, 3};
  piece.duplicates[kHexes] = {0, 0, 0};
  MeshBlockCounts counts;
  const MeshBlock block = wholeOf(piece, counts);
  ASSERT_EQ(block.cells.size(CellType::Wedge), 1u);
  ASSERT_EQ(block.cells.size(CellType::Hexahedron), 2u);
  EXPECT_EQ(block.cellValues[0], 2);
  for (uint32_t cell : {1u, 2u})
    EXPECT_EQ(block.cellValues[cell], block.points[block.cells.pointsOf(cell)[0]].x == 0 ? 1.f : 3.f);
}

TEST(CellValues, CellsWithoutDataAreCounted) {
  MeshPiece mesh = withCellValues(test::cubeOfHexes(4, kStill, kZero), wavy);
  for (const size_t cell : {3, 17, 40})
    mesh.cellValues[kHexes][cell] = std::numeric_limits<float>::infinity();
  std::mt19937 random(1);
  MeshBlockCounts counts;
  dealtOut(mesh, test::randomPartitioning(random, kDomain, 7, 3), 3, random, counts);
  EXPECT_EQ(counts.noDataCells, 3u);
  EXPECT_EQ(counts.noDataPoints, 0u);
}

TEST(CellValues, PiecesWithoutAValueForEachCellAreRefused) {
  const MeshPiece mesh = withCellValues(test::cubeOfHexes(2, kStill, kZero), wavy);
  validate(mesh);
  MeshPiece wrong = mesh;
  wrong.cellValues[kHexes].pop_back();
  EXPECT_THROW(validate(wrong), Error);
  wrong = mesh;
  wrong.duplicates[kHexes].pop_back();
  EXPECT_THROW(validate(wrong), Error);
  wrong = mesh;
  wrong.values.assign(mesh.points.size(), 0);
  EXPECT_THROW(validate(wrong), Error);
  wrong = mesh;
  wrong.ofCells = false;
  EXPECT_THROW(validate(wrong), Error);
}

}  // namespace
}  // namespace gxy::cell_values

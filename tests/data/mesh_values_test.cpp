// SPDX-License-Identifier: Apache-2.0
// Other values on the same points and cells.
#include "core/data/mesh_values.h"

#include <cmath>
#include <limits>

#include "core/comm/error.h"
#include "tests/data/mesh_pieces.h"
#include "tests/data/random_partitioning.h"
#include "tests/support/mixed_meshes.h"

namespace gxy {
namespace {

using test::ThreadRanks;

const Box kCubeOfCells{{0, 0, 0}, {1, 1, 1}};

// Cells of all types, some of them twice with points of their own, and one with a point twice.
MeshPiece flawedMesh() {
  MeshPiece mesh = test::cubeOfMixedCells(
      3, [](const glm::dvec3& p) { return 0.02 * glm::dvec3(p.y, p.z, p.x); },
      [](const glm::dvec3&) { return 0; });
  auto& hexahedra = mesh.cells.points[size_t(CellType::Hexahedron)];
  for (size_t i = 0; i < 24; i++) {
    mesh.points.push_back(mesh.points[hexahedra[i]]);
    mesh.numbers.push_back(mesh.points.size() - 1);
    hexahedra.push_back(uint32_t(mesh.points.size() - 1));
  }
  mesh.points.push_back({0.5, 0.5, 0.9});
  mesh.numbers.push_back(mesh.points.size() - 1);
  test::addCell(mesh, CellType::Tetrahedron, {0, 1, 1, uint32_t(mesh.points.size() - 1)});
  mesh.values.resize(mesh.points.size());
  return mesh;
}

// By the number in the files, so that points at one place have several.
std::vector<float> valuesByNumber(const MeshPiece& piece, int components, int step) {
  std::vector<float> values;
  for (const uint64_t number : piece.numbers)
    for (int c = 0; c < components; c++)
      values.push_back((number + uint64_t(step)) % 17 == 3 ? std::numeric_limits<float>::quiet_NaN()
                                                           : float(number % 5) + float(step * c));
  return values;
}

void expectSameCounts(const MeshBlockCounts& a, const MeshBlockCounts& b) {
  EXPECT_EQ(a.cells, b.cells);
  EXPECT_EQ(a.points, b.points);
  EXPECT_EQ(a.repeatedCells, b.repeatedCells);
  EXPECT_EQ(a.degenerateCells, b.degenerateCells);
  EXPECT_EQ(a.mergedPoints, b.mergedPoints);
  EXPECT_EQ(a.differingPoints, b.differingPoints);
  EXPECT_EQ(a.crowdedFaces, b.crowdedFaces);
  EXPECT_EQ(a.foldedFaces, b.foldedFaces);
  EXPECT_EQ(a.noDataPoints, b.noDataPoints);
  EXPECT_EQ(a.invertedCells, b.invertedCells);
  EXPECT_EQ(a.hangingPoints, b.hangingPoints);
  EXPECT_EQ(a.noDataCells, b.noDataCells);
  EXPECT_EQ(a.differingCells, b.differingCells);
}

bool areSameValues(const std::vector<float>& a, const std::vector<float>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](float x, float y) { return x == y || (std::isnan(x) && std::isnan(y)); });
}

TEST(MeshValues, OfTheSameCellsAreThoseOfBlocksMadeAnew) {
  const MeshPiece mesh = flawedMesh();
  for (uint32_t seed = 1; seed <= 12; seed++) {
    std::mt19937 random(seed);
    const int ranks = 1 + int(seed % 4);
    const Partitioning cut = test::randomPartitioning(random, kCubeOfCells, 1 + int(random() % 9), ranks);
    std::vector<MeshPiece> pieces;
    for (size_t r = 0; r < size_t(ranks); r++)
      pieces.push_back(test::someOf(mesh, mesh.cells.size() * r / size_t(ranks),
                                    mesh.cells.size() * (r + 1) / size_t(ranks), random));
    const auto errors = ThreadRanks(ranks).run([&](Collectives& mine) {
      MeshPiece& piece = pieces[size_t(mine.rank())];
      ValueRoutes routes;
      MeshBlockCounts first;
      const auto blocks = distribute(piece, cut, first, mine, {}, &routes);
      for (int step = 1; step <= 3; step++) {
        piece.components = 1 + int((seed + uint32_t(step)) % 3);
        piece.values = valuesByNumber(piece, piece.components, step);
        MeshBlockCounts expectedCounts, counts = first;
        const auto expected = distribute(piece, cut, expectedCounts, mine);
        const auto found =
            distributeValues(blocks, routes, piece.values, piece.components, false, cut, counts, mine);
        EXPECT_EQ(found.size(), expected.size());
        for (const auto& [partition, block] : found) {
          const MeshBlock& other = expected.at(partition);
          EXPECT_TRUE(areSameValues(block.values, other.values)) << partition;
          EXPECT_TRUE(block.points == other.points && block.cells.points == other.cells.points);
          EXPECT_TRUE(block.points.sharesWith(blocks.at(partition).points));
        }
        expectSameCounts(counts, expectedCounts);
        EXPECT_GT(counts.differingPoints, 0u);
        EXPECT_GT(counts.noDataPoints, 0u);
      }
    });
    EXPECT_EQ(errors, std::vector<std::string>(size_t(ranks))) << seed;
  }
}

// Many cells are there once more, most of these as duplicates, hexahedra and pyramids with their corners in another order, and some as duplicates only.
MeshPiece meshWithDuplicates(std::mt19937& random) {
  MeshPiece mesh = flawedMesh();
  mesh.values.clear();
  mesh.ofCells = true;
  constexpr std::array<std::array<size_t, 8>, kCellTypes> kTurned{
      {{1, 2, 0, 3}, {1, 2, 3, 0, 4}, {1, 2, 0, 4, 5, 3}, {1, 2, 3, 0, 5, 6, 7, 4}}};
  for (const CellType type : kAllCellTypes) {
    auto& cells = mesh.cells.points[size_t(type)];
    auto& duplicates = mesh.duplicates[size_t(type)];
    const size_t n = shapeOf(type).points, count = cells.size() / n;
    for (size_t cell = 0; cell < count; cell++) {
      duplicates.push_back(random() % 4 == 0);
      if (random() % 3 != 0) continue;
      for (size_t i = 0; i < n; i++) cells.push_back(cells[cell * n + kTurned[size_t(type)][i]]);
    }
    while (duplicates.size() < cells.size() / n) duplicates.push_back(random() % 3 != 0);
    mesh.cellValues[size_t(type)].resize(duplicates.size());
  }
  return mesh;
}

// As a file is read whose data are those of points.
MeshPiece withoutDuplicates(const MeshPiece& piece, int components, const std::vector<float>& values) {
  MeshPiece left;
  left.components = components;
  std::vector<uint32_t> numberOf(piece.points.size(), UINT32_MAX);
  for (const CellType type : kAllCellTypes) {
    const auto& corners = piece.cells.points[size_t(type)];
    for (size_t i = 0; i < corners.size(); i++) {
      if (piece.duplicates[size_t(type)][i / shapeOf(type).points]) continue;
      const uint32_t p = corners[i];
      if (numberOf[p] == UINT32_MAX) {
        numberOf[p] = uint32_t(left.points.size());
        left.points.push_back(piece.points[p]);
        left.numbers.push_back(piece.numbers[p]);
        for (int c = 0; c < components; c++)
          left.values.push_back(values[p * size_t(components) + size_t(c)]);
      }
      left.cells.points[size_t(type)].push_back(numberOf[p]);
    }
  }
  return left;
}

std::vector<float> randomCellValues(MeshPiece& piece, std::mt19937& random) {
  std::vector<float> all;
  for (size_t type = 0; type < kCellTypes; type++) {
    std::vector<float>& values = piece.cellValues[type];
    values.resize(piece.duplicates[type].size() * size_t(piece.components));
    for (float& v : values)
      v = random() % 7 == 0 ? std::numeric_limits<float>::quiet_NaN() : float(random() % 7);
    all.insert(all.end(), values.begin(), values.end());
  }
  return all;
}

TEST(MeshValues, OfCellsAndOfPointsAreThoseOfBlocksMadeAnewWithoutDuplicates) {
  std::array<uint64_t, 2> noData{}, differing{};  // of points, and of cells
  for (uint32_t seed = 1; seed <= 12; seed++) {
    std::mt19937 random(seed);
    const MeshPiece mesh = meshWithDuplicates(random);
    const int ranks = 1 + int(seed % 4);
    const Partitioning cut = test::randomPartitioning(random, kCubeOfCells, 1 + int(random() % 9), ranks);
    std::vector<MeshPiece> pieces;
    for (size_t r = 0; r < size_t(ranks); r++)
      pieces.push_back(test::someOf(mesh, mesh.cells.size() * r / size_t(ranks),
                                    mesh.cells.size() * (r + 1) / size_t(ranks), random));
    const auto errors = ThreadRanks(ranks).run([&](Collectives& mine) {
      std::mt19937 own(100 * seed + uint32_t(mine.rank()));
      MeshPiece& piece = pieces[size_t(mine.rank())];
      ValueRoutes routes;
      MeshBlockCounts first;
      const auto blocks = distribute(piece, cut, first, mine, {}, &routes);
      for (int step = 1; step <= 4; step++) {
        const bool ofCells = step != 3;
        const int components = 1 + int((seed + uint32_t(step)) % 3);
        piece.components = components;
        const std::vector<float> values =
            ofCells ? randomCellValues(piece, own) : valuesByNumber(piece, components, step);
        MeshBlockCounts expectedCounts, counts = first;
        const auto expected = distribute(ofCells ? piece : withoutDuplicates(piece, components, values), cut,
                                         expectedCounts, mine);
        const auto found = distributeValues(blocks, routes, values, components, ofCells, cut, counts, mine);
        EXPECT_EQ(found.size(), expected.size());
        for (const auto& [partition, block] : found) {
          const MeshBlock& other = expected.at(partition);
          EXPECT_TRUE(areSameValues(block.values, other.values)) << partition;
          EXPECT_TRUE(areSameValues(block.cellValues, other.cellValues)) << partition;
          EXPECT_TRUE(block.points == other.points && block.cells.points == other.cells.points);
          EXPECT_TRUE(block.neighbours == other.neighbours && block.shell == other.shell);
          EXPECT_TRUE(block.points.sharesWith(blocks.at(partition).points));
        }
        expectSameCounts(counts, expectedCounts);
        if (mine.rank() != 0) continue;
        noData[ofCells] += ofCells ? counts.noDataCells : counts.noDataPoints;
        differing[ofCells] += ofCells ? counts.differingCells : counts.differingPoints;
      }
    });
    EXPECT_EQ(errors, std::vector<std::string>(size_t(ranks))) << seed;
  }
  for (const bool ofCells : {false, true}) {
    EXPECT_GT(noData[ofCells], 0u);
    EXPECT_GT(differing[ofCells], 0u);
  }
}

TEST(MeshValues, ForWhichThereIsNoRoomAreRefusedOnAllRanks) {
  const MeshPiece mesh = flawedMesh();
  std::mt19937 random(1);
  const Partitioning cut = test::randomPartitioning(random, kCubeOfCells, 4, 2);
  const auto errors = ThreadRanks(2).run([&](Collectives& mine) {
    const size_t half = mesh.cells.size() / 2;
    const MeshPiece piece = mine.rank() == 0 ? test::someOf(mesh, 0, half, random) : MeshPiece();
    ValueRoutes routes;
    MeshBlockCounts counts;
    const auto blocks = distribute(piece, cut, counts, mine, {}, &routes);
    EXPECT_GT(bytesOf(routes), 0);
    distributeValues(blocks, routes, piece.values, 1, false, cut, counts, mine, [&](int64_t) {
      if (mine.rank() == 1) throw Error("no room");
    });
  });
  for (const std::string& error : errors) EXPECT_NE(error.find("no room"), std::string::npos) << error;
}

}  // namespace
}  // namespace gxy

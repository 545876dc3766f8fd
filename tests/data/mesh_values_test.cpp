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
  MeshPiece mesh = test::cubeOfAllCells(
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
            distributeValues(blocks, routes, piece.values, piece.components, cut, counts, mine);
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
    distributeValues(blocks, routes, piece.values, 1, cut, counts, mine, [&](int64_t) {
      if (mine.rank() == 1) throw Error("no room");
    });
  });
  for (const std::string& error : errors) EXPECT_NE(error.find("no room"), std::string::npos) << error;
}

}  // namespace
}  // namespace gxy

// SPDX-License-Identifier: Apache-2.0
// Defects of meshes are counted once, on any partitions.
#include "core/data/mesh_defects.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/data/mesh_pieces.h"
#include "tests/data/random_partitioning.h"
#include "tests/support/cell_meshes.h"
#include "tests/support/meshes.h"

namespace gxy::mesh_defects {
namespace {

using test::dealtOut;

const Box kDomain{{0, 0, 0}, {1, 1, 1}};
const auto kStill = [](glm::dvec3) { return glm::dvec3(0); };
const auto kZero = [](glm::dvec3) { return 0.0; };

/// Two meshes of the cube, one at x < 0.5 and the other one at x > 0.5 + gap, then moved.
template <class Move>
MeshPiece halves(MeshPiece left, MeshPiece right, Move&& move, double gap = 0) {
  for (glm::dvec3& p : left.points) p.x *= 0.5;
  for (glm::dvec3& p : right.points) p.x = 0.5 + gap + (0.5 - gap) * p.x;
  MeshPiece both = test::joined(std::move(left), right);
  for (glm::dvec3& p : both.points) p = move(p);
  return both;
}

const auto kAsItIs = [](glm::dvec3 p) { return p; };
/// Bilinear in y and z, so that the middles of faces and edges stay so.
glm::dvec3 bilinear(glm::dvec3 p) { return {p.x + 0.2 * p.y * p.z, p.y, p.z}; }

/// The counts of a mesh in one partition, which are those on any others.
MeshBlockCounts countsOf(const MeshPiece& mesh) {
  MeshBlockCounts whole;
  meshBlock(mesh, Partitioning::single(kDomain), 0, whole);
  for (uint32_t seed = 1; seed <= 12; seed++) {
    std::mt19937 random(seed);
    const int ranks = 1 + int(random() % 4);
    const Partitioning cut = test::randomPartitioning(random, kDomain, 2 + int(random() % 12), ranks);
    MeshBlockCounts counts;
    dealtOut(test::shuffled(mesh, random), cut, ranks, random, counts);
    EXPECT_EQ(counts.hangingPoints, whole.hangingPoints) << seed;
    EXPECT_EQ(counts.splitFaces, whole.splitFaces) << seed;
    EXPECT_EQ(counts.foldedFaces, whole.foldedFaces) << seed;
  }
  return whole;
}

TEST(MeshDefects, ConformingMeshesHaveNone) {
  for (const MeshPiece& mesh : {test::cubeOfTets(5, kStill, kZero), test::cubeOfAllCells(4, kStill, kZero)}) {
    const MeshBlockCounts counts = countsOf(mesh);
    EXPECT_EQ(counts.hangingPoints + counts.splitFaces + counts.foldedFaces + counts.invertedCells, 0u);
  }
}

TEST(MeshDefects, PointsThatHangInFacesAndEdgesAreCounted) {
  for (const auto& move : {+kAsItIs, +bilinear})
    for (const uint32_t k : {2u, 3u}) {
      const uint32_t fine = 2 * k + 1;
      const MeshBlockCounts hexes = countsOf(
          halves(test::cubeOfHexes(2, kStill, kZero), test::cubeOfHexes(2 * k, kStill, kZero), move));
      EXPECT_EQ(hexes.hangingPoints, fine * fine - 9) << k;
      EXPECT_EQ(hexes.splitFaces, 0u);
    }
  const MeshBlockCounts tets =
      countsOf(halves(test::cubeOfTets(2, kStill, kZero), test::cubeOfTets(4, kStill, kZero), kAsItIs));
  EXPECT_EQ(tets.hangingPoints, 16u);
  EXPECT_EQ(tets.splitFaces, 0u);
}

TEST(MeshDefects, TrianglesThatAreHalvesOfQuadsAreCounted) {
  const MeshBlockCounts counts =
      countsOf(halves(test::cubeOfHexes(4, kStill, kZero), test::cubeOfTets(4, kStill, kZero), bilinear));
  EXPECT_EQ(counts.splitFaces, 32u);
  EXPECT_EQ(counts.hangingPoints, 0u);
}

// Within 1e-6 of the edges, which are 1/2 and 1/4, all 25 and 9 points at the gap lie in faces beyond it.
TEST(MeshDefects, AGapIsNoContact) {
  for (const double gap : {1e-5, 1e-8})
    EXPECT_EQ(countsOf(halves(test::cubeOfHexes(2, kStill, kZero), test::cubeOfHexes(4, kStill, kZero),
                              kAsItIs, gap))
                  .hangingPoints,
              gap > 1e-6 ? 0u : 34u);
}

TEST(MeshDefects, InvertedCellsAreCounted) {
  MeshPiece mesh = test::cubeOfAllCells(4, kStill, kZero);
  size_t inverted = 0;
  for (const CellType type : kAllCellTypes) {
    std::vector<uint32_t>& cells = mesh.cells.points[size_t(type)];
    const size_t n = shapeOf(type).points;
    for (size_t at = 0; at < cells.size(); at += 5 * n, inverted++) {
      uint32_t* const c = &cells[at];
      if (type == CellType::Tetrahedron) std::swap(c[0], c[1]);
      if (type == CellType::Pyramid) std::swap(c[1], c[3]);
      if (type == CellType::Wedge) std::swap(c[1], c[2]), std::swap(c[4], c[5]);
      if (type == CellType::Hexahedron) std::swap_ranges(c, c + 4, c + 4);
    }
  }
  MeshBlockCounts counts;
  meshBlock(mesh, Partitioning::single(kDomain), 0, counts);
  EXPECT_EQ(counts.invertedCells, inverted);
  EXPECT_EQ(counts.foldedFaces, 0u);
}

}  // namespace
}  // namespace gxy::mesh_defects

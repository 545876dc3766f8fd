// SPDX-License-Identifier: Apache-2.0
#include "core/data/mesh_blocks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <set>

#include "core/comm/error.h"
#include "core/data/connect.h"
#include "core/data/replicate.h"
#include "tests/data/mesh_pieces.h"
#include "tests/data/random_partitioning.h"
#include "tests/support/meshes.h"

namespace gxy {
namespace {

using test::areEqual;
using test::dealtOut;
using test::placeOf;
using test::shuffled;

constexpr size_t kTets = size_t(CellType::Tetrahedron);
using Tet = std::array<std::array<double, 3>, 4>;  // its corners, ascending

template <class Points, class Cells>
std::vector<Tet> tetsOf(const Points& points, const Cells& cells) {
  std::vector<Tet> tets;
  const auto& ids = cells.points[kTets];
  for (size_t at = 0; at < ids.size(); at += 4) {
    Tet& tet = tets.emplace_back();
    for (size_t i = 0; i < 4; i++) tet[i] = placeOf(points[ids[at + i]]);
  }
  return tets;
}

std::vector<Tet> sortedTets(std::vector<Tet> tets) {
  for (Tet& tet : tets) std::sort(tet.begin(), tet.end());
  std::sort(tets.begin(), tets.end());
  return tets;
}

MeshPiece warpedCube(uint32_t n) {
  return test::cubeOfTets(
      n, [](const glm::dvec3& p) { return 0.03 * glm::dvec3(std::sin(9 * p.y), std::sin(7 * p.z), p.x); },
      [](const glm::dvec3& p) { return p.x + 2 * p.y + 4 * p.z; });
}

const Box kDomain{{0, 0, 0}, {1, 1, 1}};

TEST(MeshBlocks, ABlockDoesNotDependOnTheOrderOfCellsPointsAndPieces) {
  const MeshPiece mesh = warpedCube(6);
  for (uint32_t seed = 1; seed <= 20; seed++) {
    std::mt19937 random(seed);
    const int ranks = 1 + int(random() % 4);
    const Partitioning cut = test::randomPartitioning(random, kDomain, 1 + int(random() % 9), ranks);
    MeshBlockCounts expectedCounts, counts;
    std::map<int, MeshBlock> expected;
    for (int r = 0; r < ranks; r++) {
      const std::vector<Bytes> messages = packForOwners(mesh, cut, ranks);
      expected.merge(unpackMesh(cut, r, std::span(&messages[size_t(r)], 1), expectedCounts));
    }
    const auto blocks = dealtOut(shuffled(mesh, random), cut, ranks, random, counts);
    ASSERT_EQ(blocks.size(), expected.size()) << seed;
    for (const auto& [partition, block] : blocks)
      EXPECT_TRUE(areEqual(block, expected.at(partition))) << seed;
    for (const MeshBlockCounts& c : {expectedCounts, counts}) {
      EXPECT_EQ(c.points, 343u);
      EXPECT_EQ(c.cells[kTets], 1296u);
      EXPECT_EQ(c.repeatedCells + c.degenerateCells + c.mergedPoints + c.differingPoints + c.crowdedFaces +
                    c.foldedFaces,
                0u);
    }
  }
}

TEST(MeshBlocks, APartitionHasTheCellsWhoseInflatedBoxesItTouches) {
  const MeshPiece mesh = warpedCube(5);
  for (uint32_t seed = 1; seed <= 20; seed++) {
    std::mt19937 random(seed);
    const Box domain{{0, 0, 0}, {0.8, 1, 1}};  // some cells are outside
    const Partitioning cut = test::randomPartitioning(random, domain, 12, 3);
    MeshBlockCounts counts;
    const auto blocks = dealtOut(mesh, cut, 3, random, counts);
    const double slack = borderSlack(cut);
    for (int p = 0; p < cut.partitions(); p++) {
      std::vector<Tet> expected;
      for (const Tet& tet : tetsOf(mesh.points, mesh.cells)) {
        Box box;
        for (const auto& [x, y, z] : tet) box.extend({x, y, z});
        bool touches = true;
        for (int a = 0; a < 3; a++) {
          const double lo = cut.box(p).lo[a], hi = cut.box(p).hi[a];
          touches = touches && (lo == domain.lo[a] || box.hi[a] + slack >= lo) &&
                    (hi == domain.hi[a] || box.lo[a] - slack <= hi);
        }
        if (touches) expected.push_back(tet);
      }
      const auto block = blocks.find(p);
      const std::vector<Tet> found =
          block == blocks.end() ? std::vector<Tet>() : tetsOf(block->second.points, block->second.cells);
      EXPECT_EQ(sortedTets(found), sortedTets(expected)) << seed << " " << p;
    }
    EXPECT_EQ(counts.cells[kTets], 750u);
    EXPECT_EQ(counts.points, 216u);
  }
}

TEST(MeshBlocks, PartitionsHaveCommonCellsInTheSameOrder) {
  std::mt19937 random(7);
  const Partitioning cut = test::randomPartitioning(random, kDomain, 9, 1);
  MeshBlockCounts counts;
  const auto blocks = dealtOut(warpedCube(6), cut, 1, random, counts);
  ASSERT_EQ(blocks.size(), 9u);
  size_t common = 0;
  std::vector<std::vector<Tet>> all;
  for (const auto& [partition, block] : blocks) {
    all.push_back(tetsOf(block.points, block.cells));
    const auto& ids = block.cells.points[kTets];
    for (size_t at = 0; at < ids.size(); at += 4)
      EXPECT_TRUE(std::is_sorted(ids.begin() + at, ids.begin() + at + 4));
  }
  for (const auto& a : all)
    for (const auto& b : all) {
      const std::set<Tet> ofA(a.begin(), a.end()), ofB(b.begin(), b.end());
      std::vector<Tet> fromA, fromB;
      std::copy_if(a.begin(), a.end(), std::back_inserter(fromA), [&](const Tet& t) { return ofB.count(t); });
      std::copy_if(b.begin(), b.end(), std::back_inserter(fromB), [&](const Tet& t) { return ofA.count(t); });
      EXPECT_EQ(fromA, fromB);  // and the points of each in the same order
      common += &a != &b ? fromA.size() : 0;
    }
  EXPECT_GT(common, 100u);
}

TEST(MeshBlocks, NeighboursAndShellAreThoseOfTheBlock) {
  std::mt19937 random(3);
  const Partitioning cut = test::randomPartitioning(random, kDomain, 5, 1);
  MeshBlockCounts counts;
  for (const auto& [partition, block] : dealtOut(warpedCube(4), cut, 1, random, counts)) {
    const Connectivity found = connect(test::cellsOf(block), block.points.size());
    EXPECT_TRUE(block.neighbours == shared(found.neighbours));
    EXPECT_TRUE(block.shell == found.shell);
    EXPECT_FALSE(block.shell.empty());
  }
}

/// Cells 0 to `repeated` a second time, with points of their own at the same places.
MeshPiece withRepeated(MeshPiece mesh, size_t repeated, float more) {
  const size_t points = mesh.points.size();
  std::vector<uint32_t>& ids = mesh.cells.points[kTets];
  for (size_t at = 0; at < 4 * repeated; at++) {
    const uint32_t p = ids[at];
    ids.push_back(uint32_t(mesh.points.size()));
    mesh.points.push_back(mesh.points[p]);
    mesh.values.push_back(mesh.values[p] + more);
    mesh.numbers.push_back(points + at);
  }
  return mesh;
}

TEST(MeshBlocks, RepeatedCellsAndPointsAreLeftOutAndCountedOnce) {
  const MeshPiece mesh = warpedCube(4);
  const MeshPiece repeated = withRepeated(mesh, 30, 0);
  for (uint32_t seed = 1; seed <= 10; seed++) {
    std::mt19937 random(seed);
    const Partitioning cut = test::randomPartitioning(random, kDomain, 7, 3);
    MeshBlockCounts expectedCounts, counts;
    const auto expected = dealtOut(mesh, cut, 3, random, expectedCounts);
    const auto blocks = dealtOut(shuffled(repeated, random), cut, 3, random, counts);
    for (const auto& [partition, block] : blocks)
      EXPECT_TRUE(areEqual(block, expected.at(partition))) << seed;
    EXPECT_EQ(counts.repeatedCells, 30u);
    EXPECT_EQ(counts.cells[kTets], 384u);
    EXPECT_EQ(counts.points, 125u);
    EXPECT_EQ(counts.mergedPoints, 120u) << "points that several ranks have read do not count";
    EXPECT_EQ(counts.differingPoints, 0u);
  }
}

TEST(MeshBlocks, OfSeveralValuesAllPartitionsHaveTheFirst) {
  // Every cell has points of its own with values of their own, the first of a place the lowest.
  const MeshPiece mesh = warpedCube(4);
  MeshPiece apart;
  for (const uint32_t p : mesh.cells.points[kTets]) {
    apart.cells.points[kTets].push_back(uint32_t(apart.points.size()));
    apart.numbers.push_back(apart.points.size());
    apart.values.push_back(float(apart.points.size()));
    apart.points.push_back(mesh.points[p]);
  }
  std::map<std::array<double, 3>, float> first;
  for (size_t p = 0; p < apart.points.size(); p++) first.emplace(placeOf(apart.points[p]), apart.values[p]);
  for (uint32_t seed = 1; seed <= 10; seed++) {
    std::mt19937 random(seed);
    const Partitioning cut = test::randomPartitioning(random, kDomain, 20, 4);
    MeshBlockCounts counts;
    size_t wrong = 0;
    for (const auto& [partition, block] : dealtOut(apart, cut, 4, random, counts))
      for (size_t p = 0; p < block.points.size(); p++)
        wrong += block.values[p] != first.at(placeOf(block.points[p]));
    EXPECT_EQ(wrong, 0u) << seed;
    EXPECT_EQ(counts.points, 125u);
    EXPECT_EQ(counts.mergedPoints, apart.points.size() - 125);
    EXPECT_EQ(counts.differingPoints, apart.points.size() - 125);
  }
}

TEST(MeshBlocks, CellsWithAPointTwiceAreLeftOutWithTheirPoints) {
  MeshPiece mesh = warpedCube(2);
  mesh.points.push_back({0.5, 0.5, 2});
  mesh.values.push_back(9);
  mesh.numbers.push_back(27);
  for (const uint32_t p : {0u, 1u, 1u, 27u}) mesh.cells.points[kTets].push_back(p);
  const Partitioning two = Partitioning::lattice(
      {std::vector<double>{0, 0.4, 1}, std::vector<double>{0, 1}, std::vector<double>{0, 1}}, 1);
  std::mt19937 random(1);
  MeshBlockCounts counts;
  for (const auto& [partition, block] : dealtOut(mesh, two, 1, random, counts))
    for (const glm::dvec3& p : block.points) EXPECT_LT(p.z, 2);
  EXPECT_EQ(counts.degenerateCells, 1u);
  EXPECT_EQ(counts.cells[kTets], 48u);
  EXPECT_EQ(counts.points, 27u);
}

TEST(MeshBlocks, CrowdedFacesAndPointsWithoutDataAreCountedOnce) {
  MeshPiece mesh;
  mesh.points = {{0.4, 0, 0}, {0.6, 0, 0}, {0.5, 1, 0}, {0.5, 0.3, 1}, {0.5, 0.3, -1}, {0.5, 0.3, 2}};
  mesh.values = {0, 1, std::numeric_limits<float>::quiet_NaN(), 3, std::numeric_limits<float>::infinity(), 5};
  mesh.numbers = {0, 1, 2, 3, 4, 5};
  mesh.cells.points[kTets] = {0, 1, 2, 3, 0, 1, 2, 4, 0, 1, 2, 5};
  const Partitioning two = Partitioning::lattice(
      {std::vector<double>{0, 0.5, 1}, std::vector<double>{0, 1}, std::vector<double>{-1, 2}}, 2);
  std::mt19937 random(1);
  MeshBlockCounts counts;
  const auto blocks = dealtOut(mesh, two, 2, random, counts);
  EXPECT_EQ(blocks.size(), 2u);
  EXPECT_EQ(counts.crowdedFaces, 1u);
  EXPECT_EQ(counts.noDataPoints, 2u);
  EXPECT_EQ(counts.cells[kTets], 3u);
}

// Two cells of a face, of which the second is on the other side, on the same side, and flat.
TEST(MeshBlocks, FacesWhoseCellsOverlapAreCountedOnce) {
  for (const double z : {-1.0, 0.5, 0.0}) {
    MeshPiece mesh;
    mesh.points = {{0.4, 0, 0}, {0.6, 0, 0}, {0.5, 1, 0}, {0.5, 0.3, 1}, {0.5, 0.2, z}};
    mesh.values.resize(5);
    mesh.numbers = {0, 1, 2, 3, 4};
    mesh.cells.points[kTets] = {0, 1, 2, 3, 0, 1, 2, 4};
    const Partitioning two = Partitioning::lattice(
        {std::vector<double>{0, 0.5, 1}, std::vector<double>{0, 1}, std::vector<double>{-1, 2}}, 2);
    std::mt19937 random(1);
    MeshBlockCounts counts;
    EXPECT_EQ(dealtOut(mesh, two, 2, random, counts).size(), 2u);
    EXPECT_EQ(counts.foldedFaces, z < 0 ? 0u : 1u) << z;
  }
}

TEST(MeshBlocks, PartitionsWithoutCellsHaveNoBlock) {
  const Partitioning wide = Partitioning::lattice(
      {std::vector<double>{-3, -2, -1, 2}, std::vector<double>{0, 1}, std::vector<double>{0, 1}}, 3);
  std::mt19937 random(1);
  MeshBlockCounts counts;
  const auto blocks = dealtOut(warpedCube(2), wide, 3, random, counts);
  ASSERT_EQ(blocks.size(), 1u);
  EXPECT_EQ(blocks.begin()->first, 2);
  EXPECT_EQ(blocks.begin()->second.cells.size(), 48u);
}

TEST(MeshBlocks, SeveralComponentsStayTogether) {
  MeshPiece mesh = warpedCube(3);
  mesh.components = 3;
  mesh.values.clear();
  for (const glm::dvec3& p : mesh.points)
    mesh.values.insert(mesh.values.end(), {float(p.x), float(p.y), float(p.z)});
  std::mt19937 random(5);
  const Partitioning cut = test::randomPartitioning(random, kDomain, 4, 2);
  MeshBlockCounts counts;
  for (const auto& [partition, block] : dealtOut(mesh, cut, 2, random, counts)) {
    ASSERT_EQ(block.values.size(), 3 * block.points.size());
    for (size_t p = 0; p < block.points.size(); p++)
      for (int c = 0; c < 3; c++) EXPECT_EQ(block.values[3 * p + size_t(c)], float(block.points[p][c]));
  }
}

TEST(MeshBlocks, HexahedraKeepTheOrderOfTheirPoints) {
  MeshPiece mesh;
  for (const double z : {0.0, 1.0})
    for (const auto& [x, y] : {std::pair(0.0, 0.0), {1.0, 0.0}, {1.0, 1.0}, {0.0, 1.0}})
      mesh.points.push_back({x, y, z});
  mesh.values = {0, 1, 2, 3, 4, 5, 6, 7};
  mesh.numbers = {0, 1, 2, 3, 4, 5, 6, 7};
  mesh.cells.points[size_t(CellType::Hexahedron)] = {0, 1, 2, 3, 4, 5, 6, 7};
  MeshBlockCounts counts;
  const MeshBlock block = meshBlock(mesh, Partitioning::single(kDomain), 0, counts);
  ASSERT_EQ(block.cells.size(CellType::Hexahedron), 1u);
  for (size_t i = 0; i < 8; i++) {
    const uint32_t p = block.cells.points[size_t(CellType::Hexahedron)][i];
    EXPECT_EQ(block.points[p], mesh.points[i]);
    EXPECT_EQ(block.values[p], float(i));
  }
  EXPECT_EQ(counts.cells[size_t(CellType::Hexahedron)], 1u);
}

std::string errorOf(const std::function<void()>& work) {
  try {
    work();
  } catch (const Error& e) {
    return e.what();
  }
  return {};
}

TEST(MeshBlocks, APieceThatIsNotValidIsRefused) {
  const Partitioning single = Partitioning::single(kDomain);
  MeshPiece mesh = warpedCube(1);
  mesh.cells.points[kTets][5] = 8;
  EXPECT_NE(errorOf([&] { packForOwners(mesh, single, 1); }).find("a cell has point 8 of a mesh of 8 points"),
            std::string::npos);
  mesh = warpedCube(1);
  mesh.values.pop_back();
  EXPECT_NE(errorOf([&] { packForOwners(mesh, single, 1); }).find("7 values"), std::string::npos);
  mesh = warpedCube(1);
  mesh.points[3].y = std::numeric_limits<double>::infinity();
  EXPECT_NE(errorOf([&] { packForOwners(mesh, single, 1); }).find("not finite"), std::string::npos);
  mesh = warpedCube(1);
  mesh.cells.points[kTets].pop_back();
  EXPECT_NE(errorOf([&] { packForOwners(mesh, single, 1); }).find("cells of 4 points each with 23"),
            std::string::npos);
}

TEST(MeshBlocks, MalformedMessagesAreRefused) {
  const Partitioning single = Partitioning::single(kDomain);
  const Bytes whole = packForOwners(warpedCube(1), single, 1)[0];
  MeshBlockCounts counts;
  for (size_t size = 1; size < whole.size(); size++) {
    const Bytes part(whole.begin(), whole.begin() + std::ptrdiff_t(size));
    EXPECT_THROW(unpackMesh(single, 0, std::span(&part, 1), counts), Error) << size;
  }
  EXPECT_NE(errorOf([&] {
              unpackMesh(single, 1, std::span(&whole, 1), counts);
            }).find("partition 0 came, expected"),
            std::string::npos);
}

}  // namespace
}  // namespace gxy

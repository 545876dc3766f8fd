// SPDX-License-Identifier: Apache-2.0
// Files of unstructured volumes with cells of all types.
#include <gtest/gtest.h>

#include <limits>

#include "tests/io/imported_mesh.h"
#include "tests/support/mixed_meshes.h"

namespace gxy {
namespace {

using test::errorOf;
using test::expectSameBlocks;
using test::expectText;
using test::GridFile;
using test::import;
using test::Imported;
using testing::TemporaryFolder;

MeshPiece allCells(uint32_t n = 3) {
  return test::cubeOfMixedCells(
      n, [](const glm::dvec3& p) { return 0.02 * glm::dvec3(p.y * p.z, p.x, -p.x * p.y); },
      [](const glm::dvec3& p) { return 1 + p.x - 2 * p.y + 4 * p.z; });
}

std::array<uint64_t, kCellTypes> countsOf(const MeshPiece& mesh) {
  std::array<uint64_t, kCellTypes> counts;
  for (const CellType type : kAllCellTypes) counts[size_t(type)] = mesh.cells.size(type);
  return counts;
}

/// The block that a mesh is in the only partition.
std::map<int, MeshBlock> wholeBlock(const MeshPiece& mesh) {
  MeshBlockCounts counts;
  Box box;
  for (const glm::dvec3& p : mesh.points) box.extend(p);
  return {{0, meshBlock(mesh, Partitioning::single(box), 0, counts)}};
}

TEST(MeshCellsFile, CellsOfEachTypeAreReadAsTheyAre) {
  const MeshPiece mesh = allCells();
  for (int only = -1; only < int(kCellTypes); only++) {
    MeshPiece some = mesh;
    for (const CellType type : kAllCellTypes)
      if (only >= 0 && int(type) != only) some.cells.points[size_t(type)].clear();
    ASSERT_GT(some.cells.size(), 0u);
    const TemporaryFolder folder;
    writeText(folder / "grid.vtu", test::gridOf(some, 0, some.cells.size()).vtu());
    const Imported imported = import(folder / "grid.vtu", {}, 1, {1, 1, 1});
    ASSERT_EQ(imported.errors[0], "") << only;
    EXPECT_EQ(imported.mesh.report.cells, countsOf(some)) << only;
    EXPECT_TRUE(imported.warnings.empty()) << only;
    if (only < 0) expectSameBlocks(imported.blocks, wholeBlock(mesh));
  }
}

TEST(MeshCellsFile, PiecesOfAllTypesOnAnyRanksGiveTheSameAsOneFile) {
  const TemporaryFolder folder;
  const MeshPiece mesh = allCells();
  const size_t cells = mesh.cells.size();
  writeText(folder / "grid.vtu", test::gridOf(mesh, 0, cells).vtu());
  std::vector<std::string> names;
  for (size_t i = 0; i < 5; i++) {
    names.push_back("piece" + std::to_string(i) + ".vtu");
    writeText(folder / names.back(), test::gridOf(mesh, i * cells / 5, (i + 1) * cells / 5).vtu());
  }
  writeText(folder / "grid.pvtu", test::pvtu({names[3], names[0], names[4], names[1], names[2]}, "value"));
  const Imported expected = import(folder / "grid.vtu");
  ASSERT_EQ(expected.blocks.size(), 4u);
  for (const int ranks : {1, 2, 4})
    for (const char* file : {"grid.vtu", "grid.pvtu"}) {
      const Imported found = import(folder / file, {}, ranks);
      ASSERT_EQ(found.errors, std::vector<std::string>(size_t(ranks))) << file;
      expectSameBlocks(found.blocks, expected.blocks);
      EXPECT_EQ(found.mesh.ranges, expected.mesh.ranges);
      EXPECT_EQ(found.mesh.report.cells, countsOf(mesh));
      EXPECT_EQ(found.mesh.report.points, mesh.points.size());
      EXPECT_TRUE(found.warnings.empty());
    }
}

/// The cube [0, 1]^3 as one cell, whose points run through x, y and z, or around as those of hexahedra do.
GridFile oneCube(int type) {
  GridFile grid;
  for (const double z : {0.0, 1.0})
    for (const double y : {0.0, 1.0})
      for (const double x : {0.0, 1.0}) grid.points.push_back({x, y, z});
  grid.pointArrays = {{"value", "Float32", 1, {0, 1, 2, 3, 4, 5, 6, 7}}};
  grid.cells = {{type, type == 11 ? std::vector<uint32_t>{0, 1, 2, 3, 4, 5, 6, 7}
                                  : std::vector<uint32_t>{0, 1, 3, 2, 4, 5, 7, 6}}};
  return grid;
}

TEST(MeshCellsFile, VoxelsAreHexahedra) {
  const TemporaryFolder folder;
  writeText(folder / "voxel.vtu", oneCube(11).vtu());
  writeText(folder / "hexahedron.vtu", oneCube(12).vtu());
  const Imported voxel = import(folder / "voxel.vtu", {}, 1, {1, 1, 1});
  const Imported hexahedron = import(folder / "hexahedron.vtu", {}, 1, {1, 1, 1});
  ASSERT_EQ(voxel.errors[0] + hexahedron.errors[0], "");
  EXPECT_EQ(voxel.mesh.report.cells, (std::array<uint64_t, kCellTypes>{0, 0, 0, 1}));
  expectSameBlocks(voxel.blocks, hexahedron.blocks);
  const MeshBlock& block = voxel.blocks.at(0);
  for (int i = 0; i < 4; i++) {  // counterclockwise, the upper ones over the lower ones
    const auto at = [&](int k) { return block.points[block.cells.points[3][size_t(k)]]; };
    EXPECT_EQ(at(i), glm::dvec3(i == 1 || i == 2, i >= 2, 0));
    EXPECT_EQ(at(i + 4), at(i) + glm::dvec3(0, 0, 1));
  }
}

TEST(MeshCellsFile, CollapsedHexahedraAreOtherCells) {
  GridFile grid = oneCube(12);
  const std::vector<uint32_t> cube = grid.cells[0].second;
  const auto add = [&](std::initializer_list<size_t> places) {
    auto& cell = grid.cells.emplace_back(12, std::vector<uint32_t>()).second;
    for (const size_t place : places) cell.push_back(cube[place]);
  };
  grid.cells.clear();
  add({0, 1, 2, 2, 4, 5, 6, 6});
  add({0, 1, 2, 3, 4, 4, 4, 4});
  add({0, 1, 2, 2, 4, 4, 4, 4});
  add({3, 0, 1, 2, 7, 7, 7, 7});
  add({0, 1, 2, 2, 4, 5, 6, 7});  // neither
  const TemporaryFolder folder;
  writeText(folder / "grid.vtu", grid.vtu());
  for (const int ranks : {1, 2}) {
    const Imported imported = import(folder / "grid.vtu", {}, ranks);
    ASSERT_EQ(imported.errors, std::vector<std::string>(size_t(ranks)));
    EXPECT_EQ(imported.mesh.report.cells, (std::array<uint64_t, kCellTypes>{1, 2, 1, 0}));
    EXPECT_EQ(imported.mesh.report.degenerateCells, 1u);
    std::string all;
    for (const std::string& warning : imported.warnings) all += warning;
    expectText(all, "1 cell left out: a point is there twice");
  }
}

TEST(MeshCellsFile, CellsOfAnotherNumberOfPointsAreLeftOut) {
  const testing::QuietLog quiet;
  GridFile grid = oneCube(12);
  grid.cells.push_back({14, {0, 1, 2, 3}});
  grid.cells.push_back({13, {0, 1, 2, 3, 4, 5, 6}});
  grid.cells.push_back({12, {0, 1, 3, 2, 4, 5, 7}});
  const TemporaryFolder folder;
  writeText(folder / "grid.vtu", grid.vtu());
  const Imported imported = import(folder / "grid.vtu");
  ASSERT_EQ(imported.errors[0], "");
  EXPECT_EQ(imported.mesh.report.cells, (std::array<uint64_t, kCellTypes>{0, 0, 0, 1}));
  ASSERT_EQ(imported.warnings.size(), 1u);
  expectText(imported.warnings[0], "a cell whose number of points is not that of its type is left out");
}

TEST(MeshCellsFile, LegacyFilesHaveThemToo) {
  const TemporaryFolder folder;
  writeText(folder / "mixed.vtk",
            "# vtk DataFile Version 3.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 10 double\n"
            "0 0 0 1 0 0 1 1 0 0 1 0 0 0 1 1 0 1 1 1 1 0 1 1 0.5 0.5 2 2 0 0.5\n"
            "CELLS 3 22\n8 0 1 2 3 4 5 6 7\n5 4 5 6 7 8\n6 1 2 9 5 6 9\nCELL_TYPES 3\n12\n14\n13\n"
            "POINT_DATA 10\nSCALARS heat double 1\nLOOKUP_TABLE default\n1 2 3 4 5 6 7 8 9 10\n");
  const Imported imported = import(folder / "mixed.vtk");
  ASSERT_EQ(imported.errors[0], "");
  EXPECT_EQ(imported.mesh.report.cells, (std::array<uint64_t, kCellTypes>{0, 1, 0, 1}));
  EXPECT_EQ(imported.mesh.report.degenerateCells, 1u);
}

TEST(MeshCellsFile, MemoryIsAskedForBeforeItIsTaken) {
  const TemporaryFolder folder;
  const MeshPiece mesh = allCells(6);
  writeText(folder / "grid.vtu", test::gridOf(mesh, 0, mesh.cells.size()).vtu());
  SingleRank alone;
  int64_t asked = 0;
  const TakeMemory take = [&](int64_t bytes) { asked += bytes; };
  LoadedMesh loaded = loadMesh(folder / "grid.vtu", {}, alone, take);
  EXPECT_GE(asked, bytesOf(loaded.piece));
  asked = 0;
  const Partitioning single = Partitioning::single(loaded.box);
  const auto whole = meshOf(std::move(loaded), single, alone, take);
  EXPECT_GE(asked, bytesOf(*whole));
}

TEST(MeshCellsFile, DamagedFilesGiveAnErrorOrAMesh) {
  const testing::QuietLog quiet;
  const TemporaryFolder folder;
  const MeshPiece mesh = allCells(2);
  const std::string text = test::gridOf(mesh, 0, mesh.cells.size()).vtu();
  std::mt19937 random(12);
  SingleRank alone;
  size_t failed = 0;
  for (int i = 0; i < 400; i++) {
    writeText(folder / "grid.vtu", testing::mutated(text, random));
    try {
      LoadedMesh loaded = loadMesh(folder / "grid.vtu", {}, alone);
      const auto found = meshOf(std::move(loaded), Partitioning::single(Box{{0, 0, 0}, {1, 1, 1}}), alone);
      EXPECT_GT(found->report.points, 0u);
    } catch (const Error&) {
      failed++;
    }
  }
  EXPECT_GT(failed, 100u);
}

}  // namespace
}  // namespace gxy

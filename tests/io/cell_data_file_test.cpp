// SPDX-License-Identifier: Apache-2.0
// Files of unstructured volumes whose values are those of cells.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/io/file.h"
#include "core/io/import_mesh.h"
#include "core/io/mesh_file.h"
#include "tests/io/imported_mesh.h"
#include "tests/support/meshes.h"

namespace gxy::cell_data_file {
namespace {

using test::errorOf;
using test::expectSameBlocks;
using test::expectText;
using test::GridFile;
using test::import;
using test::Imported;
using testing::TemporaryFolder;

constexpr size_t kHexes = size_t(CellType::Hexahedron);
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr std::array<int, 3> kWhole{1, 1, 1};

double wavy(glm::dvec3 p) { return std::sin(5 * p.x) + std::cos(7 * p.y + p.z); }

/// n^3 bent cubes.
MeshPiece cubes(uint32_t n = 4) {
  MeshPiece mesh = test::cubeOfTets(
      n, [](glm::dvec3 p) { return 0.02 * glm::dvec3(p.y * p.z, p.x, -p.x * p.y); },
      [](glm::dvec3) { return 0.0; });
  mesh.cells = {};
  const uint32_t m = n + 1;
  for (uint32_t i = 0; i < n * n * n; i++) {
    const uint32_t first = i % n + m * (i / n % n + m * (i / (n * n)));
    for (const uint32_t corner : {0u, 1u, m + 1, m}) mesh.cells.points[kHexes].push_back(first + corner);
    for (const uint32_t corner : {0u, 1u, m + 1, m})
      mesh.cells.points[kHexes].push_back(first + corner + m * m);
  }
  return test::withCellValues(mesh, wavy);
}

/// Cells of a mesh of hexahedra, with array "flux" of cells alone.
GridFile gridOf(const MeshPiece& mesh, std::vector<uint32_t> cells) {
  MeshPiece some = mesh;
  some.ofCells = false;
  some.values.assign(mesh.points.size(), 0);
  some.cells = {};
  for (const uint32_t cell : cells) {
    const auto points = mesh.cells.pointsOf(cell);
    some.cells.points[kHexes].insert(some.cells.points[kHexes].end(), points.begin(), points.end());
  }
  GridFile grid = test::gridOf(some, 0, cells.size());
  grid.pointArrays.clear();
  grid.cellArrays = {{"flux", "Float32", 1, {}}};
  for (const uint32_t cell : cells)
    grid.cellArrays[0].values.push_back(double(mesh.cellValues[kHexes][cell]));
  return grid;
}

std::vector<uint32_t> from(uint32_t first, uint32_t end) {
  std::vector<uint32_t> numbers(end - first);
  std::iota(numbers.begin(), numbers.end(), first);
  return numbers;
}

GridFile oneCube() {
  GridFile grid;
  for (int i = 0; i < 8; i++) grid.points.push_back({i & 1, i >> 1 & 1, i >> 2});
  grid.cells = {{11, {0, 1, 2, 3, 4, 5, 6, 7}}};
  return grid;
}

TEST(CellDataFile, AFileOfCellDataAloneIsRead) {
  const TemporaryFolder folder;
  const MeshPiece mesh = cubes();
  writeText(folder / "grid.vtu", gridOf(mesh, from(0, 64)).vtu());
  MeshBlockCounts counts;
  const Mesh described = test::describedMesh(mesh);
  const MeshBlock expected = meshBlock(mesh, Partitioning::single(described.box), 0, counts);
  const Imported imported = import(folder / "grid.vtu", {}, 1, kWhole);
  ASSERT_EQ(imported.errors, std::vector<std::string>(1));
  expectSameBlocks(imported.blocks, {{0, expected}});
  EXPECT_EQ(imported.mesh.name, "grid:flux");
  EXPECT_TRUE(imported.mesh.ofCells);
  EXPECT_EQ(imported.mesh.ranges, described.ranges);
  EXPECT_EQ(imported.mesh.box, described.box);
  EXPECT_TRUE(imported.warnings.empty());
}

TEST(CellDataFile, PiecesOnAnyRanksGiveTheSameAsOneFile) {
  const TemporaryFolder folder;
  const MeshPiece mesh = cubes();
  writeText(folder / "grid.vtu", gridOf(mesh, from(0, 64)).vtu());
  // Pieces with and without layers of the next ones' cells, marked as duplicates; their values serve nothing here.
  std::vector<std::string> names;
  for (uint32_t i = 0; i < 4; i++) {
    names.push_back("piece" + std::to_string(i) + ".vtu");
    writeText(folder / names.back(), gridOf(mesh, from(16 * i, 16 * i + 16)).vtu());
    GridFile more = gridOf(mesh, from(16 * i, std::min(16 * i + 32, 64u)));
    GridFile::Array ghosts{"vtkGhostType", "UInt8", 1, std::vector<double>(more.cells.size(), 0)};
    for (size_t c = 16; c < more.cells.size(); c++) ghosts.values[c] = 1, more.cellArrays[0].values[c] = 1e9;
    more.cellArrays.push_back(ghosts);
    writeText(folder / ("more" + names.back()), more.vtu());
  }
  writeText(folder / "grid.pvtu", test::pvtu(names, ""));
  for (std::string& name : names) name = "more" + name;
  writeText(folder / "ghosts.pvtu", test::pvtu(names, ""));
  const Imported expected = import(folder / "grid.vtu");
  ASSERT_EQ(expected.blocks.size(), 4u);
  for (const int ranks : {1, 2, 3, 7})
    for (const char* file : {"grid.vtu", "grid.pvtu", "ghosts.pvtu"}) {
      const Imported found = import(folder / file, {}, ranks);
      ASSERT_EQ(found.errors, std::vector<std::string>(size_t(ranks))) << file;
      expectSameBlocks(found.blocks, expected.blocks);
      EXPECT_EQ(found.mesh.ranges, expected.mesh.ranges);
      EXPECT_EQ(found.mesh.report.cells, expected.mesh.report.cells);
      EXPECT_EQ(found.mesh.report.repeatedCells, 0u);
      EXPECT_EQ(found.mesh.report.ghostCells, file == std::string("ghosts.pvtu") ? 48u : 0u);
    }
}

// The one piece of a list that there is shows, at its border, what all of them would.
TEST(CellDataFile, DuplicatesServeAveragesOfAPieceAlone) {
  const TemporaryFolder folder;
  const MeshPiece mesh = cubes();
  GridFile piece = gridOf(mesh, from(0, 32));
  GridFile::Array ghosts{"vtkGhostType", "UInt8", 1, std::vector<double>(32, 0)};
  std::fill(ghosts.values.begin() + 16, ghosts.values.end(), 1);
  piece.cellArrays.push_back(ghosts);
  writeText(folder / "piece.vtu", piece.vtu());
  writeText(folder / "grid.vtu", gridOf(mesh, from(0, 64)).vtu());
  const MeshBlock whole = import(folder / "grid.vtu", {}, 1, kWhole).blocks.at(0);
  for (const int ranks : {1, 3}) {
    const Imported imported = import(folder / "piece.vtu", {}, ranks, kWhole);
    ASSERT_EQ(imported.errors[0], "");
    EXPECT_EQ(imported.mesh.report.cells[kHexes], 16u);
    const MeshBlock& block = imported.blocks.at(0);
    EXPECT_EQ(block.points.size(), 50u);
    for (size_t p = 0; p < block.points.size(); p++) {
      const auto same = std::find(whole.points.begin(), whole.points.end(), block.points[p]);
      ASSERT_NE(same, whole.points.end());
      EXPECT_NEAR(block.values[p], whole.values[size_t(same - whole.points.begin())], 1e-6);
    }
  }
}

TEST(CellDataFile, ArraysOfPointsComeBeforeThoseOfCellsWithTheSameName) {
  const TemporaryFolder folder;
  GridFile grid = oneCube();
  grid.pointArrays = {{"both", "Float32", 1, {1, 2, 3, 4, 5, 6, 7, 8}}};
  grid.cellArrays = {{"both", "Float32", 1, {9}}, {"own", "Int32", 2, {3, -4}}};
  writeText(folder / "grid.vtu", grid.vtu());
  const auto isOfCells = [&](const char* array) { return import(folder / "grid.vtu", array).mesh.ofCells; };
  EXPECT_FALSE(isOfCells(""));
  EXPECT_FALSE(isOfCells("both"));
  EXPECT_TRUE(isOfCells("own"));
  const Mesh own = import(folder / "grid.vtu", "own").mesh;
  EXPECT_EQ(own.components, 2);
  EXPECT_EQ(own.ranges, (std::vector<Range>{{3, 3}, {-4, -4}, {5, 5}}));
}

TEST(CellDataFile, LegacyFilesAreReadToo) {
  const TemporaryFolder folder;
  writeText(folder / "grid.vtk",
            "# vtk DataFile Version 3.0\nt\nASCII\nDATASET RECTILINEAR_GRID\nDIMENSIONS 3 2 2\n"
            "X_COORDINATES 3 float\n0 1 3\nY_COORDINATES 2 float\n0 1\nZ_COORDINATES 2 float\n0 1\n"
            "CELL_DATA 2\nSCALARS heat double 1\nLOOKUP_TABLE default\n5 8\n");
  const Imported imported = import(folder / "grid.vtk", {}, 2, kWhole);
  ASSERT_EQ(imported.errors[0], "");
  EXPECT_EQ(imported.mesh.name, "grid:heat");
  EXPECT_TRUE(imported.mesh.ofCells);
  EXPECT_EQ(imported.mesh.ranges[0], (Range{5, 8}));
  // Linear between the centres at 0.5 and 2.
  const MeshBlock& block = imported.blocks.at(0);
  for (size_t p = 0; p < block.points.size(); p++) {
    const double x = block.points[p].x;
    EXPECT_NEAR(imported.mesh.shift + imported.mesh.scale * double(block.values[p]),
                x == 0 ? 5 : (x == 1 ? 6 : 8), 1e-6);
  }
}

TEST(CellDataFile, WhatHasNoDataIsCounted) {
  const TemporaryFolder folder;
  GridFile grid = gridOf(cubes(3), from(0, 27));
  grid.cellArrays[0].values[13] = kNan;
  GridFile::Array hidden{"vtkGhostType", "UInt8", 1, std::vector<double>(grid.points.size(), 0)};
  hidden.values[0] = 2;  // a corner of the first cell
  grid.pointArrays = {hidden};
  writeText(folder / "grid.vtu", grid.vtu());
  const Imported imported = import(folder / "grid.vtu", {}, 2);
  ASSERT_EQ(imported.errors[0], "");
  EXPECT_EQ(imported.mesh.report.noDataCells, 2u);
  EXPECT_EQ(imported.mesh.report.noDataPoints, 0u);
  ASSERT_EQ(imported.warnings.size(), 1u);
  expectText(imported.warnings[0], "2 cells have no finite value, and are transparent");
}

TEST(CellDataFile, HiddenAndRefinedCellsServeNothing) {
  const TemporaryFolder folder;
  GridFile grid = gridOf(cubes(2), from(0, 8));
  for (double& v : grid.cellArrays[0].values) v = 1;
  grid.cellArrays[0].values[7] = grid.cellArrays[0].values[6] = 99;
  grid.cellArrays.push_back({"vtkGhostType", "UInt8", 1, {0, 0, 0, 0, 0, 0, 8, 33}});
  writeText(folder / "grid.vtu", grid.vtu());
  const Imported imported = import(folder / "grid.vtu", {}, 1, kWhole);
  ASSERT_EQ(imported.errors[0], "");
  EXPECT_EQ(imported.mesh.report.ghostCells, 2u);
  for (const float v : imported.blocks.at(0).values) EXPECT_EQ(v, 1);
}

TEST(CellDataFile, AnArrayOfPointsInOnePieceAndOfCellsInAnotherIsRefused) {
  const TemporaryFolder folder;
  GridFile grid = oneCube();
  grid.cellArrays = {{"heat", "Float32", 1, {9}}};
  writeText(folder / "a.vtu", grid.vtu());
  grid.cellArrays.clear();
  grid.pointArrays = {{"heat", "Float32", 1, {1, 2, 3, 4, 5, 6, 7, 8}}};
  for (glm::dvec3& p : grid.points) p.x += 1;
  writeText(folder / "b.vtu", grid.vtu());
  writeText(folder / "grid.pvtu", test::pvtu({"a.vtu", "b.vtu"}, ""));
  for (const int ranks : {1, 2})
    for (const std::string& error : import(folder / "grid.pvtu", "heat", ranks).errors)
      expectText(error,
                 "array 'heat' is one of points in one piece and one of cells in another, expected the same");
}

}  // namespace
}  // namespace gxy::cell_data_file

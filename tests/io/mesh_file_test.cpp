// SPDX-License-Identifier: Apache-2.0
// Files of unstructured volumes, from their text to the blocks of partitions.
#include "core/io/mesh_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "core/comm/error.h"
#include "core/io/file.h"
#include "core/io/import_mesh.h"
#include "core/io/write_geometry.h"
#include "tests/io/imported_mesh.h"
#include "tests/support/meshes.h"

namespace gxy {
namespace {

using test::errorOf;
using test::expectSameBlocks;
using test::expectText;
using test::GridFile;
using test::import;
using test::Imported;
using testing::TemporaryFolder;

constexpr size_t kTets = size_t(CellType::Tetrahedron);
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

MeshPiece cube(uint32_t n = 3) {
  return test::cubeOfTets(
      n, [](const glm::dvec3& p) { return 0.02 * glm::dvec3(p.y * p.z, p.x, -p.x * p.y); },
      [](const glm::dvec3& p) { return 1 + p.x - 2 * p.y + 4 * p.z; });
}

GridFile wholeGrid(const MeshPiece& mesh = cube()) {
  return test::gridOf(mesh, 0, mesh.cells.size(CellType::Tetrahedron));
}

/// One tetrahedron with one array.
GridFile oneTet() {
  GridFile grid;
  grid.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  grid.cells = {{10, {0, 1, 2, 3}}};
  grid.pointArrays = {{"value", "Float32", 1, {1, 2, 3, 4}}};
  return grid;
}

TEST(MeshFile, TetrahedraAndTheirValuesAreReadAsTheyAre) {
  const TemporaryFolder folder;
  const MeshPiece mesh = cube();
  writeText(folder / "grid.vtu", wholeGrid(mesh).vtu());
  const Imported imported = import(folder / "grid.vtu", {}, 1, {1, 1, 1});
  ASSERT_EQ(imported.errors, std::vector<std::string>(1));
  EXPECT_TRUE(imported.warnings.empty());
  MeshBlockCounts counts;
  Box box;
  Range range;
  for (size_t p = 0; p < mesh.points.size(); p++) {
    box.extend(mesh.points[p]);
    range.extend(double(mesh.values[p]));
  }
  const MeshBlock expected = meshBlock(mesh, Partitioning::single(box), 0, counts);
  expectSameBlocks(imported.blocks, {{0, expected}});
  EXPECT_EQ(imported.mesh.name, "grid:value");
  EXPECT_EQ(imported.mesh.box, box);
  EXPECT_EQ(imported.mesh.ranges, std::vector<Range>{range});
  EXPECT_EQ(imported.mesh.report.cells[kTets], 162u);
  EXPECT_EQ(imported.mesh.report.points, 64u);
  EXPECT_EQ(imported.mesh.shift, 0);
  EXPECT_EQ(imported.mesh.scale, 1);
}

TEST(MeshFile, PiecesOnAnyRanksGiveTheSameAsOneFile) {
  const TemporaryFolder folder;
  const MeshPiece mesh = cube();
  writeText(folder / "grid.vtu", wholeGrid(mesh).vtu());
  std::vector<std::string> names;
  for (size_t i = 0; i < 5; i++) {
    names.push_back("piece" + std::to_string(i) + ".vtu");
    writeText(folder / names.back(), i == 2 ? GridFile().vtu()  // a piece may be empty
                                            : test::gridOf(mesh, i * 162 / 5, (i + 1) * 162 / 5).vtu());
  }
  names[2] = "piece2b.vtu";
  writeText(folder / "piece2b.vtu", test::gridOf(mesh, 2 * 162 / 5, 3 * 162 / 5).vtu());
  names.insert(names.begin(), "piece2.vtu");
  writeText(folder / "grid.pvtu", test::pvtu(names, "value"));
  writeText(folder / "undeclared.pvtu", test::pvtu(names, ""));
  const Imported expected = import(folder / "grid.vtu");
  ASSERT_EQ(expected.blocks.size(), 4u);
  for (const int ranks : {1, 2, 3, 7})
    for (const char* file : {"grid.vtu", "grid.pvtu", "undeclared.pvtu"}) {
      const Imported found = import(folder / file, {}, ranks);
      ASSERT_EQ(found.errors, std::vector<std::string>(size_t(ranks))) << file;
      expectSameBlocks(found.blocks, expected.blocks);
      EXPECT_EQ(found.mesh.ranges, expected.mesh.ranges);
      EXPECT_EQ(found.mesh.report.cells, expected.mesh.report.cells);
      EXPECT_EQ(found.mesh.report.points, 64u);
      EXPECT_EQ(found.mesh.report.mergedPoints > 0, file != std::string("grid.vtu"));
      EXPECT_EQ(found.mesh.report.differingPoints, 0u);
      EXPECT_TRUE(found.warnings.empty());
    }
}

TEST(MeshFile, LegacyFilesAreReadToo) {
  const TemporaryFolder folder;
  const std::string head = "# vtk DataFile Version 3.0\nt\nASCII\nDATASET ";
  writeText(folder / "tet.vtk", head +
                                    "UNSTRUCTURED_GRID\nPOINTS 4 double\n0 0 0 1 0 0 0 1 0 0 0 1\n"
                                    "CELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\n10\nPOINT_DATA 4\n"
                                    "SCALARS heat double 1\nLOOKUP_TABLE default\n1 2 3 4\n");
  writeText(folder / "lattice.vtk", head + "STRUCTURED_POINTS\n");
  EXPECT_TRUE(isMeshFile(folder / "tet.vtk"));
  EXPECT_FALSE(isMeshFile(folder / "lattice.vtk"));
  EXPECT_TRUE(isMeshFile("any.vtu") && isMeshFile("any.pvtu") && isMeshFile("any.part"));
  EXPECT_TRUE(isMeshFile("any.vts") && isMeshFile("any.pvts") && isMeshFile("any.vtr") &&
              isMeshFile("any.pvtr"));
  EXPECT_FALSE(isMeshFile("any.vti") || isMeshFile("any.vtp") || isMeshFile("any.pvtp"));
  const Imported imported = import(folder / "tet.vtk");
  ASSERT_EQ(imported.errors[0], "");
  EXPECT_EQ(imported.mesh.name, "tet:heat");
  EXPECT_EQ(imported.mesh.ranges[0], (Range{1, 4}));
}

TEST(MeshFile, TheArrayIsTheNamedOneOrTheActiveOneOrTheFirst) {
  GridFile grid = oneTet();
  grid.pointArrays = {{"first", "Float32", 1, {1, 2, 3, 4}},
                      {"second", "Int16", 1, {-5, 6, 7, 8}},
                      {"vectors", "Float64", 3, {3, 4, 0, 0, 0, 0, 0, 0, 1, 0, 0, -2}}};
  grid.cellArrays = {{"cells", "Float32", 1, {9}}};
  const TemporaryFolder folder;
  writeText(folder / "grid.vtu", grid.vtu());
  EXPECT_EQ(import(folder / "grid.vtu").mesh.name, "grid:first");
  EXPECT_EQ(import(folder / "grid.vtu", "second").mesh.ranges, (std::vector<Range>{{-5, 8}}));
  const Mesh vectors = import(folder / "grid.vtu", "vectors").mesh;
  EXPECT_EQ(vectors.components, 3);
  EXPECT_EQ(vectors.ranges, (std::vector<Range>{{0, 3}, {0, 4}, {-2, 1}, {0, 5}}));
  grid.scalars = "second";
  writeText(folder / "grid.vtu", grid.vtu());
  EXPECT_EQ(import(folder / "grid.vtu").mesh.name, "grid:second");
}

TEST(MeshFile, WideValuesAreStoredFromAShiftOn) {
  GridFile grid = oneTet();
  grid.pointArrays = {{"time", "Float64", 1, {1e9, 1e9 + 0.25, 1e9 + 0.5, 1e9 + 1}}};
  const TemporaryFolder folder;
  writeText(folder / "grid.vtu", grid.vtu());
  const Imported imported = import(folder / "grid.vtu", {}, 2, {1, 1, 1});
  EXPECT_NE(imported.mesh.shift, 0);
  std::vector<double> values;
  for (const float stored : imported.blocks.at(0).values)
    values.push_back(imported.mesh.shift + imported.mesh.scale * double(stored));
  std::sort(values.begin(), values.end());
  EXPECT_EQ(values, (std::vector<double>{1e9, 1e9 + 0.25, 1e9 + 0.5, 1e9 + 1}));
  EXPECT_EQ(imported.mesh.ranges[0], (Range{1e9, 1e9 + 1}));
}

TEST(MeshFile, MissingArraysAreListed) {
  GridFile grid = oneTet();
  grid.cellArrays = {{"flux", "Float32", 1, {9}}};
  expectText(
      errorOf(grid, "nothing"),
      "no array 'nothing' of points or cells, which an unstructured volume needs; of points the file has "
      "'value', of cells 'flux'");
  grid.pointArrays.clear();
  grid.cellArrays.clear();
  expectText(errorOf(grid), "no numeric array of points or cells, which an unstructured volume needs");
}

TEST(MeshFile, OtherCellsWithAVolumeAreNamedAndCounted) {
  GridFile grid = oneTet();
  for (int i = 0; i < 6; i++) grid.points.push_back({2.0 + i, 0, 0});
  grid.pointArrays[0].values.resize(10);
  grid.cells.push_back({15, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9}});
  grid.cells.push_back({15, {1, 2, 3, 4, 5, 6, 7, 8, 9, 0}});
  grid.cells.push_back({12, {0, 1, 2, 3, 4, 5, 6, 7}});
  grid.cells.push_back({24, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9}});
  for (const int ranks : {1, 3})
    expectText(errorOf(grid, {}, ranks),
               "it has cells that an unstructured volume cannot have yet: pentagonal prisms (2), quadratic "
               "tetrahedra "
               "(1); expected tetrahedra, pyramids, wedges, hexahedra or voxels");
}

TEST(MeshFile, AFileWithoutVolumeSaysWhatItHas) {
  GridFile grid = oneTet();
  grid.cells = {{5, {0, 1, 2}}, {5, {1, 2, 3}}, {3, {0, 3}}};
  const std::string error = errorOf(grid, {}, 2);
  expectText(error,
             "it has no cells with a volume, expected tetrahedra, pyramids, wedges, hexahedra or voxels; it "
             "has lines "
             "(1), triangles (2)");
  expectText(error, "imported as Triangles");
  grid = oneTet();
  grid.pointArrays.push_back({"unused", "Float32", 1, {0, 0, 0, 0}});
  grid.cellArrays = {{"vtkGhostType", "UInt8", 1, {1}}};
  expectText(errorOf(grid), "all of its 1 cells with a volume are duplicate, refined or hidden");
  grid = oneTet();
  grid.points[2].y = kNan;
  expectText(errorOf(grid), "none of its cells can be used: tetrahedra (1)");
  grid = oneTet();
  grid.cells[0].second[3] = 2;
  expectText(errorOf(grid), "all of its 1 cells have a point twice");
  const TemporaryFolder folder;
  GeometryBlock triangle;
  triangle.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  triangle.values = {1, 2, 3};
  triangle.triangles = {{0, 1, 2}};
  triangle.ids = {0};
  writeGeometry(folder / "surface.vtp", triangle, GeometryKind::Triangles);
  expectText(import(folder / "surface.vtp").errors[0],
             "expected an unstructured, structured or rectilinear grid, found vtkPolyData");
}

TEST(MeshFile, DefectsAreCountedAndTold) {
  const MeshPiece mesh = cube();
  GridFile grid = wholeGrid(mesh);
  const uint32_t points = uint32_t(grid.points.size());
  for (int i = 0; i < 4; i++) {  // a cell that no other touches, and one of a point that is nowhere
    grid.points.push_back({i == 1 ? 3.0 : 2.0, i == 2 ? 1.0 : 0.0, i == 3 ? 1.0 : 0.0});
    grid.pointArrays[0].values.push_back(i);
  }
  grid.points.push_back({kNan, 0, 0});
  grid.points.push_back(grid.points[0]);  // once more, with another value
  for (const double v : {5.0, 99.0}) grid.pointArrays[0].values.push_back(v);
  grid.cells.push_back({10, {points, points + 1, points + 2, points + 3}});
  grid.cells.push_back({10, {points, points + 1, points + 2, points + 4}});  // not finite
  grid.cells.push_back({10, {points, points + 1, points + 2, points + 2}});  // a point twice
  grid.cells.push_back({10, {points + 3, points + 2, points, points + 1}});  // repeated
  // The other value; the cell overlaps the first one of these, with which it shares a face.
  grid.cells.push_back({10, {points + 5, points + 1, points + 2, points + 3}});
  grid.cells.push_back({5, {0, 1, 2}});           // flat
  grid.cells.push_back({10, {0, 1, 2, points}});  // a ghost
  GridFile::Array cellGhosts{"vtkGhostType", "UInt8", 1, std::vector<double>(grid.cells.size(), 0)};
  cellGhosts.values.back() = 8;
  GridFile::Array pointGhosts{"vtkGhostType", "UInt8", 1, std::vector<double>(grid.points.size(), 0)};
  pointGhosts.values[points + 3] = 2;
  grid.cellArrays = {cellGhosts};
  grid.pointArrays.push_back(pointGhosts);
  const TemporaryFolder folder;
  writeText(folder / "grid.vtu", grid.vtu());
  for (const int ranks : {1, 3}) {
    const Imported imported = import(folder / "grid.vtu", {}, ranks);
    ASSERT_EQ(imported.errors, std::vector<std::string>(size_t(ranks)));
    const MeshReport& report = imported.mesh.report;
    EXPECT_EQ(report.cells[kTets], 164u);
    EXPECT_EQ(report.points, 68u);
    EXPECT_EQ(report.flatCells, 1u);
    EXPECT_EQ(report.ghostCells, 1u);
    EXPECT_EQ(report.repeatedCells, 1u);
    EXPECT_EQ(report.degenerateCells, 1u);
    EXPECT_EQ(report.unusableCells, 1u);
    EXPECT_EQ(report.mergedPoints, 1u);
    EXPECT_EQ(report.differingPoints, 1u);
    EXPECT_EQ(report.noDataPoints, 1u);
    EXPECT_EQ(report.crowdedFaces, 0u);
    EXPECT_EQ(report.foldedFaces, 1u);
    std::string all;
    for (const std::string& warning : imported.warnings) all += warning + "\n";
    for (const char* text :
         {"1 cell without a volume left out", "1 ghost cell left out", "1 cell left out: a coordinate is not",
          "1 cell left out: another cell", "1 cell left out: a point is there twice",
          "1 point has another value than an earlier point", "1 point has no finite value",
          "1 face whose two cells are on the same side", "in faces of cells that do not have them"})
      expectText(all, text);
    EXPECT_EQ(imported.warnings.size(), 9u) << all;
    size_t other = 0;
    for (const auto& [partition, block] : imported.blocks)
      other += size_t(std::count(block.values.begin(), block.values.end(), 99.f));
    EXPECT_EQ(other, 0u) << "the first value counts";
  }
}

TEST(MeshFile, MemoryIsAskedForBeforeItIsTaken) {
  const TemporaryFolder folder;
  writeText(folder / "grid.vtu", wholeGrid().vtu());
  SingleRank alone;
  int64_t asked = 0;
  const TakeMemory take = [&](int64_t bytes) { asked += bytes; };
  LoadedMesh loaded = loadMesh(folder / "grid.vtu", {}, alone, take);
  EXPECT_GE(asked, bytesOf(loaded.piece));
  asked = 0;
  const Partitioning single = Partitioning::single(loaded.box);
  const auto mesh = meshOf(std::move(loaded), single, alone, take);
  EXPECT_GE(asked, bytesOf(*mesh));
  const auto refuse = [](int64_t) { throw Error("no room"); };
  EXPECT_THROW(loadMesh(folder / "grid.vtu", {}, alone, refuse), Error);
  LoadedMesh again = loadMesh(folder / "grid.vtu", {}, alone);
  EXPECT_THROW(meshOf(std::move(again), single, alone, refuse), Error);
}

TEST(MeshFile, AnImportEndsWhenItIsCancelled) {
  const TemporaryFolder folder;
  writeText(folder / "grid.vtu", wholeGrid().vtu());
  for (int most = 1, ended = 0; ended == 0; most++) {
    ASSERT_LT(most, 1000);
    testing::EndsAt ends(most);
    try {
      LoadedMesh loaded = loadMesh(folder / "grid.vtu", {}, ends);
      meshOf(std::move(loaded), Partitioning::single(Box{{0, 0, 0}, {1, 1, 1}}), ends);
      ended = 1;
      EXPECT_GT(most, 3) << "it asks again and again";
    } catch (const Error& e) {
      expectText(e.what(), "cancelled");
    }
  }
}

TEST(MeshFile, PiecesThatDoNotFitTogetherAreRefused) {
  const TemporaryFolder folder;
  GridFile vectors = oneTet();
  vectors.pointArrays = {{"value", "Float32", 3, std::vector<double>(12, 1)}};
  writeText(folder / "a.vtu", oneTet().vtu());
  writeText(folder / "b.vtu", vectors.vtu());
  writeText(folder / "list.pvtu", test::pvtu({"a.vtu", "b.vtu"}, "value"));
  for (const int ranks : {1, 2}) {
    const auto errors = import(folder / "list.pvtu", {}, ranks).errors;
    for (const std::string& error : errors) expectText(error, "components");
  }
  writeText(folder / "none.pvtu", test::pvtu({}, "value"));
  expectText(import(folder / "none.pvtu").errors[0], "it lists no pieces");
}

TEST(MeshFile, DamagedFilesGiveAnErrorOrAMesh) {
  const testing::QuietLog quiet;
  const TemporaryFolder folder;
  const std::string text = wholeGrid(cube(1)).vtu();
  std::mt19937 random(11);
  SingleRank alone;
  size_t failed = 0;
  for (int i = 0; i < 400; i++) {
    writeText(folder / "grid.vtu", testing::mutated(text, random));
    try {
      LoadedMesh loaded = loadMesh(folder / "grid.vtu", {}, alone);
      const auto mesh = meshOf(std::move(loaded), Partitioning::single(Box{{0, 0, 0}, {1, 1, 1}}), alone);
      EXPECT_GT(mesh->report.points, 0u);
    } catch (const Error&) {
      failed++;
    }
  }
  EXPECT_GT(failed, 100u);
}

}  // namespace
}  // namespace gxy

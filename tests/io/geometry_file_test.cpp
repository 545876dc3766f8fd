// SPDX-License-Identifier: Apache-2.0
#include "core/io/geometry_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <set>

#include "core/comm/error.h"
#include "core/data/distribute.h"
#include "core/io/file.h"
#include "core/io/import_geometry.h"
#include "core/io/write_geometry.h"
#include "tests/io/fixtures.h"

namespace gxy {
namespace {

using testing::TemporaryFolder;
using testing::ThreadRanks;

GeometryBlock twoTriangles() {
  GeometryBlock block;
  block.points = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0.1}};
  block.values = {1, 2, 3, 4};
  block.normals.assign(4, {0, 0, 1});
  block.triangles = {{0, 1, 2}, {0, 2, 3}};
  block.ids = {0, 1};
  return block;
}

GeometryBlock twoLines() {
  GeometryBlock block;
  block.points = {{0, 0, 0}, {1, 0, 0}, {2, 1, 0}, {5, 5, 5}, {6, 5, 5}};
  block.values = {1, 2, 3, 4, 5};
  block.segments = {{0, 1}, {1, 2}, {3, 4}};
  block.neighbours = {{0, 2}, {0, 2}, {3, 4}};
  block.ids = {0, 1, 2};
  return block;
}

GeometryBlock cloud(size_t n) {
  GeometryBlock block;
  std::mt19937 random(1);
  std::uniform_real_distribution<double> u(-1, 1);
  for (size_t i = 0; i < n; ++i) {
    block.points.push_back({u(random), u(random), u(random)});
    block.values.push_back(float(i));
  }
  block.ids.resize(n);
  std::iota(block.ids.begin(), block.ids.end(), uint64_t(0));
  return block;
}

TEST(GeometryFile, NamesInListsMayHoldAnyCharacter) {
  const TemporaryFolder folder;
  const std::string name = "a & <b> \"c\"";
  writeGeometry(folder / (name + ".vtp"), twoTriangles(), GeometryKind::Triangles);
  writeGeometryPieces(folder / "list.pvtp", {{{}, name + ".vtp"}}, twoTriangles(), name);
  EXPECT_EQ(geometryPieces(folder / "list.pvtp"), std::vector<std::string>{folder / (name + ".vtp")});
  EXPECT_NE(readText(folder / "list.pvtp").find("Name=\"a &amp; &lt;b&gt; &quot;c&quot;\""),
            std::string::npos);
}

TEST(GeometryFile, XmlFormatsLoseNothing) {
  const TemporaryFolder folder;
  for (const char* name : {"g.vtp", "g.vtu"}) {
    const std::string path = folder / name;
    writeGeometry(path, twoTriangles(), GeometryKind::Triangles);
    EXPECT_EQ(readGeometry(path, GeometryKind::Triangles).block, twoTriangles());
    writeGeometry(path, twoLines(), GeometryKind::PathLines, "speed");
    const GeometryContent lines = readGeometry(path, GeometryKind::PathLines);
    EXPECT_EQ(lines.block, twoLines());
    EXPECT_EQ(lines.array, "speed");
    writeGeometry(path, cloud(50), GeometryKind::Particles);
    EXPECT_EQ(readGeometry(path, GeometryKind::Particles).block, cloud(50));
  }
}

TEST(GeometryFile, MeshFormatsKeepPositionsToFloat) {
  const TemporaryFolder folder;
  for (const char* name : {"g.ply", "g.stl"}) {
    writeGeometry(folder / name, twoTriangles(), GeometryKind::Triangles);
    const GeometryBlock got = readGeometry(folder / name, GeometryKind::Triangles).block;
    ASSERT_EQ(got.triangles.size(), 2u);
    for (size_t t = 0; t < 2; ++t)
      for (size_t c = 0; c < 3; ++c)
        for (int a = 0; a < 3; ++a)
          EXPECT_NEAR(got.points[got.triangles[t][c]][a],
                      twoTriangles().points[twoTriangles().triangles[t][c]][a], 1e-7);
  }
}

TEST(GeometryFile, LegacyStripsAndPolygonsBecomeTriangles) {
  const TemporaryFolder folder;
  const std::string path = folder / "g.vtk";
  writeText(path,
            "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\nPOINTS 6 float\n0 0 0 1 0 0 0 1 0 1 1 0 "
            "0 2 0 1 2 0\n"
            "POLYGONS 1 5\n4 0 1 3 2\nTRIANGLE_STRIPS 1 7\n6 0 1 2 3 4 5\nPOINT_DATA 6\nVECTORS v float\n"
            "3 4 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0\n");
  const GeometryBlock block = readGeometry(path, GeometryKind::Triangles).block;
  const std::vector<std::array<uint32_t, 3>> expected{{0, 1, 3}, {0, 3, 2}, {0, 1, 2},
                                                      {2, 1, 3}, {2, 3, 4}, {4, 3, 5}};
  EXPECT_EQ(block.triangles, expected);
  EXPECT_EQ(block.values[0], 5.f);  // a vector's magnitude
}

/// A legacy file of three unit squares in a row, with these arrays.
std::string threeSquares(const std::string& arrays) {
  return "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\nPOINTS 8 float\n"
         "0 0 0 1 0 0 1 1 0 0 1 0 2 0 0 2 1 0 3 0 0 3 1 0\n"
         "POLYGONS 3 15\n4 0 1 2 3\n4 1 4 5 2\n4 4 6 7 5\n" +
         arrays;
}

std::vector<uint32_t> firstCorners(const GeometryBlock& block) {
  std::vector<uint32_t> corners;
  for (const auto& t : block.triangles) corners.push_back(t[0]);
  return corners;
}

TEST(GeometryFile, CellsThatVtkDoesNotDrawAreLeftOut) {
  const TemporaryFolder folder;
  // duplicate, high and low connectivity, refined, exterior, hidden
  for (const auto& [bit, drawn] :
       {std::pair(1, false), {2, true}, {4, true}, {8, false}, {16, true}, {32, false}}) {
    writeText(folder / "g.vtk", threeSquares("CELL_DATA 3\nFIELD f 1\nvtkGhostType 1 3 unsigned_char\n0 " +
                                             std::to_string(bit) + " 0\n"));
    const std::vector<uint32_t> all{0, 0, 1, 1, 4, 4}, some{0, 0, 4, 4};
    EXPECT_EQ(firstCorners(readGeometry(folder / "g.vtk", GeometryKind::Triangles).block), drawn ? all : some)
        << bit;
  }
}

TEST(GeometryFile, HiddenPointsAreNoParticlesAndHideTheirCells) {
  const TemporaryFolder folder;
  writeText(folder / "g.vtk",
            threeSquares("POINT_DATA 8\nFIELD f 1\nvtkGhostType 1 8 unsigned_char\n1 0 0 0 0 0 2 0\n"));
  EXPECT_EQ(firstCorners(readGeometry(folder / "g.vtk", GeometryKind::Triangles).block),
            (std::vector<uint32_t>{0, 0, 1, 1}));
  const GeometryBlock points = readGeometry(folder / "g.vtk", GeometryKind::Particles).block;
  ASSERT_EQ(points.points.size(), 6u);
  EXPECT_EQ(points.points[0], glm::dvec3(1, 0, 0));
  EXPECT_EQ(points.points[5], glm::dvec3(3, 1, 0));
  EXPECT_TRUE(points.values.empty());  // vtkGhostType is no array of the data
  EXPECT_EQ(readGeometry(folder / "g.vtk", GeometryKind::Particles, "vtkGhostType").block.values.size(), 6u);
}

TEST(GeometryFile, ObjIsRead) {
  const TemporaryFolder folder;
  writeText(folder / "g.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n");
  EXPECT_EQ(readGeometry(folder / "g.obj", GeometryKind::Triangles).block.triangles.size(), 2u);
}

TEST(GeometryFile, MissingArraysAndDamagedFilesAreErrors) {
  const TemporaryFolder folder;
  const std::string path = folder / "g.vtp";
  writeGeometry(path, twoLines(), GeometryKind::PathLines);
  EXPECT_THROW(readGeometry(path, GeometryKind::PathLines, "nothing"), Error);
  const std::string text = readText(path);
  ::testing::internal::CaptureStderr();
  writeText(path, text.substr(0, text.size() / 2));
  EXPECT_THROW(readGeometry(path, GeometryKind::PathLines), Error);
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
  EXPECT_THROW(readGeometry(folder / "none.ply", GeometryKind::Triangles), Error);
  EXPECT_THROW(readGeometry(folder / "g.xyz", GeometryKind::Triangles), Error);
}

TEST(LoadGeometry, DropsAndCountsWhatCannotBeDrawn) {
  const TemporaryFolder folder;
  GeometryBlock block = twoTriangles();
  block.points.push_back({NAN, 0, 0});
  block.values.push_back(9);
  block.normals.push_back({0, 0, 1});
  block.triangles.push_back({0, 1, 4});
  block.triangles.push_back({1, 1, 2});
  block.ids = {0, 1, 2, 3};
  writeGeometry(folder / "g.vtp", block, GeometryKind::Triangles);
  SingleRank one;
  const OwnedGeometry loaded = loadGeometry(folder / "g.vtp", GeometryKind::Triangles, "", one).geometry;
  EXPECT_EQ(loaded.primitives, 2u);
  EXPECT_EQ(loaded.droppedPrimitives, 2u);
  EXPECT_EQ(loaded.box, (Box{{0, 0, 0}, {1, 1, 0.1}}));
  EXPECT_EQ(loaded.range, (Range{1, 4}));
}

TEST(LoadGeometry, PiecesOnManyRanksAndOneFileGiveTheSameParticles) {
  const TemporaryFolder folder;
  const GeometryBlock all = cloud(300);
  std::vector<GeometryPiece> pieces;
  for (uint32_t first = 0; first < 300; first += 60) {
    std::vector<uint32_t> members(60);
    std::iota(members.begin(), members.end(), first);
    const std::string name = "g" + std::to_string(first) + ".vtu";
    writeGeometry(folder / name, subset(all, GeometryKind::Particles, members), GeometryKind::Particles);
    pieces.push_back({{{-1, -1, -1}, {1, 1, 1}}, name});
  }
  writeGeometry(folder / "whole.vtp", all, GeometryKind::Particles);
  for (const char* list : {"g.part", "g.pvtu"}) writeGeometryPieces(folder / list, pieces, all);

  const Partitioning cut = Partitioning::lattice(
      {std::vector<double>{-1, 0, 1}, std::vector<double>{-1, 0.2, 1}, std::vector<double>{-1, 1}}, 3);
  for (const char* name : {"whole.vtp", "g.part", "g.pvtu"}) {
    ThreadRanks ranks(3);
    std::mutex mutex;
    std::map<uint64_t, glm::dvec3> seen;
    const auto errors = ranks.run([&](Collectives& mine) {
      const auto geometry = distribute(
          ownedGeometry(loadGeometry(folder / name, GeometryKind::Particles, "", mine), cut, mine), cut,
          [](double) { return 0.0; }, mine);
      EXPECT_EQ(geometry->primitives, 300u);
      EXPECT_EQ(geometry->range, (Range{0, 299}));
      const std::lock_guard lock(mutex);
      for (const auto& [partition, block] : geometry->blocks)
        for (size_t i = 0; i < block.ids.size(); ++i) seen[block.ids[i]] = block.points[i];
    });
    EXPECT_EQ(errors, std::vector<std::string>(3));
    ASSERT_EQ(seen.size(), 300u);
    for (const auto& [id, point] : seen) EXPECT_EQ(point, all.points[id]);
  }
}

}  // namespace
}  // namespace gxy

// SPDX-License-Identifier: Apache-2.0
// Colours in geometry files: read by each reader, chosen among other arrays, written, and shared among pieces and ranks.
#include <gtest/gtest.h>

#include <cmath>
#include <mutex>

#include "core/data/distribute.h"
#include "core/io/file.h"
#include "core/io/geometry_file.h"
#include "core/io/import_geometry.h"
#include "core/io/write_geometry.h"
#include "tests/io/fixtures.h"

namespace gxy {
namespace {

using testing::TemporaryFolder;
using testing::ThreadRanks;

using Colors = std::vector<glm::vec3>;
using Warnings = std::vector<std::string>;

const float kThird = float(85 / 255.);
const Colors kPrimary{{1, 0, 0}, {0, 1, 0}, {0, 0, kThird}};

const std::string kMissing = "a colour that is missing or not finite is black",
                  kOutside = "a colour outside 0 to 1 is clamped",
                  kOpacity = "the opacity of colours is not used: that of the operator is";

class ColorFiles : public ::testing::Test {
 protected:
  GeometryContent read(const std::string& name, const std::string& text, const ValuesWanted& wanted = {},
                       GeometryKind kind = GeometryKind::Triangles) {
    writeText(folder_ / name, text);
    GeometryContent content = readGeometry(folder_ / name, kind, wanted);
    for (std::string& warning : content.warnings) warning.erase(0, (folder_ / name).size() + 2);
    EXPECT_TRUE(content.block.values.empty() || content.block.colors.empty());
    return content;
  }
  Colors colorsOf(const std::string& name, const std::string& text, const ValuesWanted& wanted = {},
                  GeometryKind kind = GeometryKind::Triangles) {
    const GeometryContent content = read(name, text, wanted, kind);
    EXPECT_EQ(content.warnings, Warnings());
    return content.block.colors;
  }
  const TemporaryFolder folder_;
};

std::string ply(const std::string& properties, const std::array<const char*, 3>& vertices,
                const std::string& face = "", const std::string& ofFace = "") {
  std::string text =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n" +
      properties + "element face 1\nproperty list uchar int vertex_indices\n" + face + "end_header\n";
  const char* const points[] = {"0 0 0 ", "1 0 0 ", "0 1 0 "};
  for (size_t i = 0; i < 3; ++i) text += points[i] + std::string(vertices[i]) + "\n";
  return text + "3 0 1 2 " + ofFace + "\n";
}

/// Properties red, green, blue.
std::string rgb(const std::string& type, const std::string& before = "") {
  std::string text;
  for (const char* name : {"red", "green", "blue"}) text += "property " + type + " " + before + name + "\n";
  return text;
}

TEST_F(ColorFiles, PlyVerticesHaveThoseOfEveryType) {
  const std::array<const char*, 3> bytes{"255 0 0", "0 255 0", "0 0 85"};
  EXPECT_EQ(colorsOf("g.ply", ply(rgb("uchar"), bytes)), kPrimary);
  EXPECT_EQ(colorsOf("g.ply", ply(rgb("uchar", "diffuse_"), bytes)), kPrimary);
  EXPECT_EQ(colorsOf("g.ply", ply(rgb("int"), bytes)), kPrimary);
  EXPECT_EQ(colorsOf("g.ply", ply(rgb("float"), bytes)), kPrimary) << "0 to 255";
  EXPECT_EQ(colorsOf("g.ply", ply(rgb("ushort"), {"65535 0 0", "0 65535 0", "0 0 21845"})), kPrimary);
  EXPECT_EQ(colorsOf("g.ply", ply(rgb("float"), {"1 0 0", "0 1 0", "0 0 0.25"})),
            (Colors{{1, 0, 0}, {0, 1, 0}, {0, 0, 0.25f}}));
  const GeometryContent content = read("g.ply", ply(rgb("uchar"), bytes));
  EXPECT_EQ(content.array, "RGB");
  EXPECT_FALSE(content.ofCells);
}

TEST_F(ColorFiles, PlyFacesHaveThem) {
  const std::string text = ply("", {"", "", ""}, rgb("uchar"), "0 255 85");
  const GeometryContent content = read("g.ply", text);
  EXPECT_TRUE(content.ofCells);
  EXPECT_EQ(content.block.colors, Colors(3, {0, 1, kThird}));
  // those of vertices come first
  const std::string both = ply(rgb("uchar"), {"255 0 0", "0 255 0", "0 0 85"}, rgb("uchar"), "0 255 85");
  EXPECT_EQ(colorsOf("g.ply", both), kPrimary);
  EXPECT_EQ(colorsOf("g.ply", both, ValuesWanted("RGB", true)), Colors(3, {0, 1, kThird}));
}

TEST_F(ColorFiles, PlyFacesBesideStripsHaveNone) {
  std::string text = ply("", {"", "", ""}, rgb("uchar"), "0 255 85");
  text.replace(text.find("end_header"), 0, "element tristrips 1\nproperty list int int vertex_indices\n");
  const GeometryContent content = read("g.ply", text + "3 2 1 0\n");
  EXPECT_EQ(content.block.triangles.size(), 2u);
  EXPECT_TRUE(content.block.colors.empty());
  EXPECT_EQ(content.warnings,
            Warnings{"header: colours of faces are passed over beside strips, which have none"});
}

TEST_F(ColorFiles, OpacityIsNotUsedAndToldWhereThereIsSome) {
  const std::string four = rgb("uchar") + "property uchar alpha\n";
  EXPECT_EQ(colorsOf("g.ply", ply(four, {"255 0 0 255", "0 255 0 255", "0 0 85 255"})), kPrimary);
  const GeometryContent content = read("g.ply", ply(four, {"255 0 0 255", "0 255 0 128", "0 0 85 0"}));
  EXPECT_EQ(content.block.colors, kPrimary);
  EXPECT_EQ(content.warnings, Warnings{"array 'RGB', entry 1: " + kOpacity + " (2 of these)"});
}

TEST_F(ColorFiles, PlyPropertiesNamedAsArraysAreMadeArePassedOver) {
  const std::string names = rgb("uchar") + "property float nx\nproperty float ny\nproperty float nz\n" +
                            "property float RGB\nproperty float Normals\n";
  EXPECT_EQ(colorsOf("g.ply", ply(names, {"255 0 0 0 0 1 7 7", "0 255 0 0 0 1 7 7", "0 0 85 0 0 1 7 7"})),
            kPrimary);
}

const std::string kVertices = "v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 0.25\n";

TEST_F(ColorFiles, ObjVerticesHaveThem) {
  const Colors expected{{1, 0, 0}, {0, 1, 0}, {0, 0, 0.25f}};
  EXPECT_EQ(colorsOf("g.obj", kVertices + "f 1 2 3\n"), expected);
  EXPECT_EQ(colorsOf("g.obj", "v 0 0 0 255 0 0\nv 1 0 0 0 255 0 255\nv 0 1 0 0 0 85\nf 1 2 3\n"), kPrimary);
  const GeometryContent some = read("g.obj", kVertices + "v 1 1 0\nf 1 2 3\nf 2 4 3\n");
  EXPECT_EQ(some.block.colors, (Colors{{1, 0, 0}, {0, 1, 0}, {0, 0, 0.25f}, {0, 0, 0}}));
  EXPECT_EQ(some.warnings, Warnings{"array 'RGB', entry 3: " + kMissing});
  EXPECT_TRUE(read("g.obj", "v 0 0 0 1\nv 1 0 0 1\nv 0 1 0 1\nf 1 2 3\n").block.colors.empty())
      << "the fourth number is a weight";
}

TEST_F(ColorFiles, ObjCopiesOfAVertexHaveItsColour) {
  const GeometryBlock block =
      read("g.obj", kVertices + "vn 0 0 1\nvn 1 0 0\nf 1//1 2//1 3//1\nf 1//2 3//2 2//2\n").block;
  ASSERT_EQ(block.points.size(), 6u);
  for (size_t p = 3; p < 6; ++p)
    for (size_t v = 0; v < 3; ++v)
      if (block.points[p] == block.points[v]) {
        EXPECT_EQ(block.colors[p], block.colors[v]);
      }
}

TEST_F(ColorFiles, OffVerticesAndFacesHaveThem) {
  EXPECT_EQ(
      colorsOf("g.off", "COFF\n3 1 0\n0 0 0 255 0 0 255\n1 0 0 0 255 0 255\n0 1 0 0 0 85 255\n3 0 1 2\n"),
      kPrimary);
  EXPECT_EQ(colorsOf("g.off",
                     "STCNOFF\n3 1 0\n0 0 0 0 0 1 1 0 0 9 9\n1 0 0 0 0 1 0 1 0 9 9\n0 1 0 0 0 1 0 0 0.25 9 "
                     "9\n3 0 1 2\n"),
            (Colors{{1, 0, 0}, {0, 1, 0}, {0, 0, 0.25f}}));
  const GeometryContent faces =
      read("g.off", "OFF\n3 4 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2 1 0.5 0\n2 0 1\n3 2 1 0\n3 1 0 2 7\n");
  EXPECT_TRUE(faces.ofCells);
  Colors expected(3, {1, 0.5f, 0});
  expected.resize(9, glm::vec3(0));
  EXPECT_EQ(faces.block.colors, expected);
  EXPECT_EQ(faces.warnings,
            (Warnings{"line 7: a face of fewer than 3 corners is left out",
                      "line 9: what follows a face, no colour of three or four numbers, is passed over",
                      "array 'RGB', entry 1: " + kMissing + " (6 of these)"}));
}

TEST_F(ColorFiles, TablesHaveColumnsOfThem) {
  const auto particles = GeometryKind::Particles;
  EXPECT_EQ(
      colorsOf("t.csv", "x,y,z,Red,GREEN,blue\n0,0,0,255,0,0\n1,0,0,0,255,0\n2,0,0,0,0,85\n", {}, particles),
      kPrimary);
  EXPECT_EQ(colorsOf("t.csv", "r,g,b,x,y,z\n1,0,0,0,0,0\n0,0.5,1,1,0,0\n", {}, particles),
            (Colors{{1, 0, 0}, {0, 0.5f, 1}}));
  const std::string heat = "x,y,z,heat,r,g,b,a\n0,0,0,5,1,0,0,1\n";
  EXPECT_EQ(read("t.csv", heat, {}, particles).block.values, std::vector<float>{5});
  EXPECT_EQ(colorsOf("t.csv", heat, "RGB", particles), (Colors{{1, 0, 0}}));
  EXPECT_EQ(read("t.csv", "x,y,z,r,g\n0,0,0,1,2\n", {}, particles).block.values, std::vector<float>{1});
}

std::string xmlArray(const std::string& type, const std::string& name, int components,
                     const std::string& values) {
  return "<DataArray type=\"" + type + "\" Name=\"" + name + "\" NumberOfComponents=\"" +
         std::to_string(components) + "\" format=\"ascii\">" + values + "</DataArray>";
}

std::string vtp(const std::string& ofPoints, const std::string& ofCells = "",
                const std::string& active = "") {
  return "<VTKFile type=\"PolyData\" version=\"0.1\" byte_order=\"LittleEndian\"><PolyData><Piece "
         "NumberOfPoints=\"3\" "
         "NumberOfPolys=\"1\"><PointData" +
         active + ">" + ofPoints + "</PointData><CellData>" + ofCells + "</CellData><Points>" +
         xmlArray("Float32", "p", 3, "0 0 0 1 0 0 0 1 0") + "</Points><Polys>" +
         xmlArray("Int32", "connectivity", 1, "0 1 2") + xmlArray("Int32", "offsets", 1, "3") +
         "</Polys></Piece></PolyData></VTKFile>";
}

const std::string kBytes = "255 0 0 0 255 0 0 0 85";

TEST_F(ColorFiles, ColoursThatAreNoneAreClampedOrBlackAndTold) {
  const GeometryContent content = read("g.ply", ply(rgb("float"), {"1.5 0 0", "0 nan 1", "-1 0.5 inf"}));
  EXPECT_EQ(content.block.colors, (Colors{{1, 0, 0}, {0, 0, 0}, {0, 0, 0}}));
  EXPECT_EQ(content.warnings, (Warnings{"array 'RGB', entry 0: " + kOutside,
                                        "array 'RGB', entry 1: " + kMissing + " (2 of these)"}));
  const GeometryContent vtk =
      read("g.vtp", vtp(xmlArray("Float32", "Color", 3, "1.5 0 -1 0.5 nan 1 200 0.25 0")));
  EXPECT_EQ(vtk.block.colors, (Colors{{1, 0, 0}, {0, 0, 0}, {1, 0.25f, 0}}));
  EXPECT_EQ(vtk.warnings, (Warnings{"array 'Color', entry 0: " + kOutside + " (2 of these)",
                                    "array 'Color', entry 1: " + kMissing}));
}

TEST_F(ColorFiles, VtkArraysOfUnsignedCharAreAndThoseNamedSo) {
  EXPECT_EQ(colorsOf("g.vtp", vtp(xmlArray("UInt8", "anything", 3, kBytes))), kPrimary);
  for (const char* name : {"RGB", "rgba", "Color", "colors", "COLOUR", "Colours"}) {
    EXPECT_EQ(colorsOf("g.vtp", vtp(xmlArray("Float32", name, 3, "1 0 0 0 1 0 0 0 0.25"))),
              (Colors{{1, 0, 0}, {0, 1, 0}, {0, 0, 0.25f}}))
        << name;
    EXPECT_EQ(colorsOf("g.vtp", vtp(xmlArray("Int32", name, 4, "255 0 0 255 0 255 0 255 0 0 85 255"))),
              kPrimary);
  }
  EXPECT_EQ(read("g.vtp", vtp(xmlArray("Float32", "v", 3, "3 4 0 0 0 1 0 0 2"))).block.values,
            (std::vector<float>{5, 1, 2}));
  EXPECT_EQ(read("g.vtp", vtp(xmlArray("UInt8", "v", 2, "3 4 0 1 0 2"))).block.values,
            (std::vector<float>{5, 1, 2}));
  EXPECT_EQ(colorsOf("g.vtp", vtp("", xmlArray("UInt8", "c", 3, "0 255 85"))), Colors(3, {0, 1, kThird}));
}

TEST_F(ColorFiles, LegacyColorScalarsAre) {
  const std::string mesh =
      "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\nPOINTS 3 float\n0 0 0 1 0 0 0 1 0\nPOLYGONS 1 "
      "4\n"
      "3 0 1 2\n";
  EXPECT_EQ(colorsOf("g.vtk", mesh + "POINT_DATA 3\nCOLOR_SCALARS c 3\n1 0 0 0 1 0 0 0 0.33333333\n"),
            kPrimary);
  EXPECT_EQ(colorsOf("g.vtk", mesh + "CELL_DATA 1\nCOLOR_SCALARS c 4\n0 1 0.33333333 1\n"),
            Colors(3, {0, 1, kThird}));
  // which are active, as other scalars are
  EXPECT_EQ(colorsOf("g.vtk", mesh + "POINT_DATA 3\nFIELD f 1\nheat 1 3 float\n1 2 3\nCOLOR_SCALARS c 3\n"
                                     "1 0 0 0 1 0 0 0 0.33333333\n"),
            kPrimary);
}

TEST_F(ColorFiles, OtherArraysComeFirstUnlessColoursAreActiveOrNamed) {
  const std::string colors = xmlArray("UInt8", "c", 3, kBytes),
                    heat = xmlArray("Float32", "heat", 1, "1 2 3");
  const std::vector<float> values{1, 2, 3};
  EXPECT_EQ(read("g.vtp", vtp(colors + heat)).block.values, values);
  EXPECT_EQ(colorsOf("g.vtp", vtp(colors + heat, "", " Scalars=\"c\"")), kPrimary);
  EXPECT_EQ(colorsOf("g.vtp", vtp(colors + heat), "c"), kPrimary);
  EXPECT_EQ(read("g.vtp", vtp(colors + heat, "", " Scalars=\"c\""), "heat").block.values, values);
  EXPECT_EQ(read("g.vtp", vtp(colors, xmlArray("Float32", "heat", 1, "7"))).block.values,
            std::vector<float>(3, 7));
}

TEST_F(ColorFiles, ParticlesHaveThoseOfPointsOrOfTheirVertices) {
  const std::string text =
      "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\nPOINTS 3 float\n0 0 0 1 0 0 0 1 0\nVERTICES 1 "
      "2\n1 1\n";
  const auto particles = GeometryKind::Particles;
  EXPECT_EQ(colorsOf("g.vtk", text + "POINT_DATA 3\nCOLOR_SCALARS c 3\n1 0 0 0 1 0 0 0 0.33333333\n", {},
                     particles),
            kPrimary);
  const GeometryContent cells =
      read("g.vtk", text + "CELL_DATA 1\nCOLOR_SCALARS c 3\n0 1 0.33333333\n", {}, particles);
  EXPECT_EQ(cells.block.colors, (Colors{{0, 0, 0}, {0, 1, kThird}, {0, 0, 0}}));
  EXPECT_EQ(cells.warnings, Warnings{"array 'c': " + kMissing + " (2 of these)"});
  // a hidden point takes its colour with it
  EXPECT_EQ(colorsOf("g.vtk",
                     text + "POINT_DATA 3\nCOLOR_SCALARS c 3\n1 0 0 0 1 0 0 0 0.33333333\nFIELD f 1\n"
                            "vtkGhostType 1 3 unsigned_char\n0 2 0\n",
                     {}, particles),
            (Colors{kPrimary[0], kPrimary[2]}));
}

TEST_F(ColorFiles, TheSummaryTellsThem) {
  writeText(folder_ / "g.vtp",
            vtp(xmlArray("UInt8", "c", 3, kBytes) + xmlArray("Float32", "v", 3, "3 4 0 0 0 1 0 0 2")));
  const GeometrySummary summary = summariseGeometry(folder_ / "g.vtp");
  ASSERT_EQ(summary.arrays.size(), 2u);
  EXPECT_TRUE(summary.arrays[0].colors);
  EXPECT_EQ(summary.arrays[0].range, (Range{0, 255}));
  EXPECT_FALSE(summary.arrays[1].colors);
  EXPECT_EQ(summary.arrays[1].range, (Range{1, 5}));
}

GeometryBlock coloured(const Colors& colors) {
  GeometryBlock block;
  for (size_t i = 0; i < colors.size(); ++i) {
    block.points.push_back({double(i % 4), double(i / 4), 0});
    if (i >= 2) block.triangles.push_back({uint32_t(i - 2), uint32_t(i - 1), uint32_t(i)});
    if (i >= 2) block.ids.push_back(i - 2);
  }
  block.colors = colors;
  return block;
}

TEST_F(ColorFiles, WhatIsWrittenIsReadWithoutLoss) {
  const Colors anything{{0.1f, 0.7f, 0.3f}, {1, 0, 0.5f}, {kThird, 0, 1}};
  for (const Colors& colors : {kPrimary, anything})
    for (const char* name : {"g.vtp", "g.vtu", "g.ply"}) {
      writeGeometry(folder_ / name, coloured(colors), GeometryKind::Triangles, "heat");
      const GeometryContent content = readGeometry(folder_ / name, GeometryKind::Triangles);
      EXPECT_EQ(content.block, coloured(colors)) << name;
      EXPECT_EQ(content.array, "RGB");
      const std::string text = readText(folder_ / name);
      const char* bytes = name == std::string("g.ply") ? "property uchar red" : "\"UInt8\" Name=\"RGB\"";
      EXPECT_EQ(text.find(bytes) != std::string::npos, &colors == &kPrimary || colors == kPrimary) << name;
    }
}

TEST_F(ColorFiles, PiecesOnManyRanksHaveThoseOfTheWhole) {
  Colors colors;
  for (int i = 0; i < 40; ++i) colors.push_back({float(i / 39.), float((i * 7) % 11 / 10.), 0.5f});
  const GeometryBlock whole = coloured(colors);
  std::vector<GeometryPiece> pieces;
  for (uint32_t first = 0; first < 38; first += 10) {
    std::vector<uint32_t> members;
    for (uint32_t t = first; t < std::min(first + 10, 38u); ++t) members.push_back(t);
    const std::string name = "g" + std::to_string(first) + ".vtp";
    writeGeometry(folder_ / name, subset(whole, GeometryKind::Triangles, members), GeometryKind::Triangles,
                  "data", &whole);
    pieces.push_back({{{0, 0, 0}, {3, 9, 0}}, name});
  }
  writeGeometry(folder_ / "whole.vtp", whole, GeometryKind::Triangles);
  const Partitioning halves = Partitioning::lattice(
      {std::vector<double>{0, 3}, std::vector<double>{0, 4.5, 10}, std::vector<double>{0, 1}}, 2);
  std::map<int, GeometryBlock> expected;
  for (const char* list : {"whole.vtp", "g.pvtp", "g.part"})
    for (const int count : {1, 2, 3}) {
      if (list != std::string("whole.vtp")) writeGeometryPieces(folder_ / list, pieces, whole);
      std::map<int, GeometryBlock> blocks;
      std::mutex mutex;
      const Partitioning partitioning =
          count > 1 ? halves
                    : Partitioning::lattice({std::vector<double>{0, 3}, std::vector<double>{0, 4.5, 10},
                                             std::vector<double>{0, 1}},
                                            1);
      ThreadRanks ranks(count);
      const auto errors = ranks.run([&](Collectives& mine) {
        const OwnedGeometry loaded = ownedGeometry(
            loadGeometry(folder_ / list, GeometryKind::Triangles, "", mine), partitioning, mine);
        EXPECT_TRUE(loaded.colored);
        EXPECT_TRUE(loaded.range.empty());
        const auto geometry = distribute(
            loaded, partitioning, [](double) { return 0; }, mine);
        EXPECT_TRUE(geometry->colored);
        const std::lock_guard lock(mutex);
        for (const auto& [part, block] : geometry->blocks) blocks.emplace(part, block);
      });
      EXPECT_EQ(errors, std::vector<std::string>(size_t(count)));
      if (expected.empty()) expected = blocks;
      EXPECT_EQ(blocks, expected) << list << " on " << count;
    }
  ASSERT_EQ(expected.size(), 2u);
  for (const auto& [part, block] : expected)
    for (size_t p = 0; p < block.points.size(); ++p)
      EXPECT_EQ(block.colors[p], colors[size_t(block.points[p].x + 4 * block.points[p].y)]);
}

TEST_F(ColorFiles, PiecesOfColoursAndOfValuesHaveNeither) {
  writeText(folder_ / "0.vtp", vtp(xmlArray("UInt8", "a", 3, kBytes)));
  writeText(folder_ / "1.vtp", vtp(xmlArray("Float32", "a", 1, "1 2 3")));
  writeText(folder_ / "g.part", "{\"parts\": [{\"filename\": \"0.vtp\"}, {\"filename\": \"1.vtp\"}]}");
  for (const int count : {1, 2}) {
    Warnings warnings;
    ThreadRanks ranks(count);
    const auto errors = ranks.run([&](Collectives& mine) {
      Warnings other;
      const LoadedGeometry loaded = loadGeometry(folder_ / "g.part", GeometryKind::Triangles, "", mine, {},
                                                 mine.rank() == 0 ? &warnings : &other);
      EXPECT_FALSE(loaded.geometry.colored);
      EXPECT_TRUE(loaded.geometry.block.colors.empty() && loaded.geometry.block.values.empty());
    });
    EXPECT_EQ(errors, std::vector<std::string>(size_t(count)));
    EXPECT_EQ(warnings, Warnings{(folder_ / "g.part") +
                                 ": some pieces have colours where others have values, so neither are used"});
  }
}

}  // namespace
}  // namespace gxy

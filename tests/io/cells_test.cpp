// SPDX-License-Identifier: Apache-2.0
// What cells become: values of cells, the outer surfaces of solid ones, the array that all pieces have in common.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "core/comm/error.h"
#include "core/io/file.h"
#include "core/io/geometry_file.h"
#include "core/io/import_geometry.h"
#include "core/io/write_geometry.h"
#include "tests/io/fixtures.h"

namespace gxy {
namespace {

using testing::TemporaryFolder;
using testing::ThreadRanks;

using Points = std::vector<glm::dvec3>;

std::string coordinates(const Points& points) {
  std::string text = "POINTS " + std::to_string(points.size()) + " double\n";
  for (const glm::dvec3& p : points)
    text += std::to_string(p.x) + " " + std::to_string(p.y) + " " + std::to_string(p.z) + "\n";
  return text;
}

std::string legacyFile(const std::string& type, const std::string& body) {
  return "# vtk DataFile Version 3.0\nt\nASCII\nDATASET " + type + "\n" + body;
}

/// Cells of one type whose points are all points in order, so many each.
std::string grid(int type, const Points& points, size_t each, const std::string& arrays = {}) {
  const size_t cells = points.size() / each;
  std::string text = legacyFile("UNSTRUCTURED_GRID", coordinates(points)) + "CELLS " + std::to_string(cells) +
                     " " + std::to_string(cells * (each + 1)) + "\n",
              types = "CELL_TYPES " + std::to_string(cells) + "\n";
  for (size_t cell = 0; cell < cells; ++cell) {
    text += std::to_string(each);
    for (size_t i = 0; i < each; ++i) text += " " + std::to_string(cell * each + i);
    text += "\n";
    types += std::to_string(type) + "\n";
  }
  return text + types + arrays;
}

/// By the divergence theorem: positive for triangles that all face outwards.
double volumeOf(const GeometryBlock& block) {
  double sum = 0;
  for (const auto& [a, b, c] : block.triangles)
    sum += glm::dot(block.points[a], glm::cross(block.points[b], block.points[c])) / 6;
  return sum;
}

double areaOf(const GeometryBlock& block) {
  double sum = 0;
  for (const auto& [a, b, c] : block.triangles)
    sum += glm::length(glm::cross(block.points[b] - block.points[a], block.points[c] - block.points[a])) / 2;
  return sum;
}

/// Corners and, behind them, the middles of these edges.
Points withMiddles(Points points, const std::vector<std::array<size_t, 2>>& edges) {
  for (const auto& [a, b] : edges) points.push_back((points[a] + points[b]) / 2.);
  return points;
}

const Points kCubeCorners{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                          {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
const Points kTetra{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
const Points kWedge{{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {0, 0, 1}, {0, 1, 1}, {1, 0, 1}};
const Points kPyramid{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 0.5, 1}};
const std::vector<std::array<size_t, 2>> kCubeEdges{{0, 1}, {1, 2}, {2, 3}, {3, 0}, {4, 5}, {5, 6},
                                                    {6, 7}, {7, 4}, {0, 4}, {1, 5}, {2, 6}, {3, 7}};

class Cells : public ::testing::Test {
 protected:
  GeometryContent read(const std::string& text, const std::string& name = "g.vtk",
                       GeometryKind kind = GeometryKind::Triangles, const std::string& array = {}) const {
    writeText(folder_ / name, text);
    return readGeometry(folder_ / name, kind, array);
  }
  const TemporaryFolder folder_;
};

TEST_F(Cells, SolidOnesShowTheirOuterSurfaceFacingOutwards) {
  Points voxel = kCubeCorners;
  std::swap(voxel[2], voxel[3]), std::swap(voxel[6], voxel[7]);
  Points triquadratic = withMiddles(kCubeCorners, kCubeEdges);
  for (const glm::dvec3& c :
       Points{{0, .5, .5}, {1, .5, .5}, {.5, 0, .5}, {.5, 1, .5}, {.5, .5, 0}, {.5, .5, 1}})
    triquadratic.push_back(c);
  triquadratic.push_back({.5, .5, .5});
  Points hexagon;
  for (int i = 0; i < 12; ++i)
    hexagon.push_back({std::cos(i * std::acos(-1.) / 3), std::sin(i * std::acos(-1.) / 3), i / 6});
  const double slant = std::sqrt(1.25) / 2;
  struct Case {
    int type;
    Points points;
    double volume, area;
    size_t triangles;
  };
  for (const Case& c :
       {Case{10, kTetra, 1. / 6, 1.5 + std::sqrt(3.) / 2, 4}, Case{11, voxel, 1, 6, 12},
        Case{12, kCubeCorners, 1, 6, 12}, Case{13, kWedge, 0.5, 3 + std::sqrt(2.), 8},
        Case{14, kPyramid, 1. / 3, 1 + 4 * slant, 6},
        Case{16, hexagon, 1.5 * std::sqrt(3.), 3 * std::sqrt(3.) + 6, 20},
        Case{24, withMiddles(kTetra, {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}}), 1. / 6,
             1.5 + std::sqrt(3.) / 2, 16},
        Case{25, withMiddles(kCubeCorners, kCubeEdges), 1, 6, 36},
        Case{26,
             withMiddles(kWedge, {{0, 1}, {1, 2}, {2, 0}, {3, 4}, {4, 5}, {5, 3}, {0, 3}, {1, 4}, {2, 5}}),
             0.5, 3 + std::sqrt(2.), 26},
        Case{27, withMiddles(kPyramid, {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {0, 4}, {1, 4}, {2, 4}, {3, 4}}),
             1. / 3, 1 + 4 * slant, 22},
        Case{29, triquadratic, 1, 6, 48}}) {
    const GeometryBlock block = read(grid(c.type, c.points, c.points.size())).block;
    EXPECT_EQ(block.triangles.size(), c.triangles) << c.type;
    EXPECT_NEAR(std::abs(volumeOf(block)), c.volume, 1e-5) << c.type;
    EXPECT_GT(volumeOf(block), 0) << c.type;
    EXPECT_NEAR(areaOf(block), c.area, 1e-5) << c.type;
    EXPECT_EQ(likelyKind(summariseGeometry(folder_ / "g.vtk")), GeometryKind::Triangles) << c.type;
  }
}

TEST_F(Cells, MiddlesOfEdgesBendTheSurface) {
  Points points = withMiddles(kCubeCorners, kCubeEdges);
  points[12].z = 1.5;  // of the upper edge in front: two triangles of the upper face rise, one in front grows
  const GeometryBlock block = read(grid(25, points, 20)).block;
  double highest = 0;
  for (const auto& t : block.triangles)
    for (uint32_t p : t) highest = std::max(highest, block.points[p].z);
  EXPECT_EQ(highest, 1.5);
}

/// Two cubes beside each other that share four points.
std::string twoCubes(const std::string& arrays = {}) {
  return legacyFile("UNSTRUCTURED_GRID", coordinates({{0, 0, 0},
                                                      {1, 0, 0},
                                                      {1, 1, 0},
                                                      {0, 1, 0},
                                                      {0, 0, 1},
                                                      {1, 0, 1},
                                                      {1, 1, 1},
                                                      {0, 1, 1},
                                                      {2, 0, 0},
                                                      {2, 1, 0},
                                                      {2, 0, 1},
                                                      {2, 1, 1}})) +
         "CELLS 2 18\n8 0 1 2 3 4 5 6 7\n8 1 8 9 2 5 10 11 6\nCELL_TYPES 2\n12\n12\n" + arrays;
}

TEST_F(Cells, FacesThatTwoSolidOnesShareAreInside) {
  const GeometryBlock block = read(twoCubes()).block;
  EXPECT_EQ(block.triangles.size(), 20u);
  EXPECT_NEAR(areaOf(block), 10, 1e-12);
  EXPECT_NEAR(volumeOf(block), 2, 1e-12);
}

TEST_F(Cells, HiddenSolidOnesUncoverTheirNeighboursAndThoseOfOtherPiecesDoNot) {
  const auto ghosts = [](int bits) {
    return "CELL_DATA 2\nFIELD f 1\nvtkGhostType 1 2 unsigned_char\n0 " + std::to_string(bits) + "\n";
  };
  EXPECT_NEAR(areaOf(read(twoCubes(ghosts(32))).block), 6, 1e-12);
  EXPECT_NEAR(areaOf(read(twoCubes(ghosts(1))).block), 5, 1e-12);
}

TEST_F(Cells, ValuesOfCellsColourEachAlike) {
  const std::string squares = legacyFile(
      "POLYDATA", coordinates({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {2, 0, 0}, {2, 1, 0}}) +
                      "POLYGONS 2 10\n4 0 1 2 3\n4 1 4 5 2\nCELL_DATA 2\nSCALARS p float\nLOOKUP_TABLE "
                      "default\n0.25 0.75\n");
  for (const char* array : {"", "p"}) {
    const GeometryContent content = read(squares, "g.vtk", GeometryKind::Triangles, array);
    EXPECT_TRUE(content.ofCells);
    EXPECT_EQ(content.array, "p");
    const GeometryBlock& block = content.block;
    ASSERT_EQ(block.triangles.size(), 4u);
    ASSERT_EQ(block.points.size(), 8u);
    for (size_t t = 0; t < 4; ++t)
      for (uint32_t point : block.triangles[t]) {
        EXPECT_EQ(block.values[point], t < 2 ? 0.25f : 0.75f);
        EXPECT_EQ(block.points[point].x < 1, t < 2 && block.points[point].x != 1);
      }
    EXPECT_NEAR(areaOf(block), 2, 1e-12);
  }
  const GeometryBlock cubes =
      read(twoCubes("CELL_DATA 2\nSCALARS p float\nLOOKUP_TABLE default\n3 4\n")).block;
  ASSERT_EQ(cubes.triangles.size(), 20u);
  for (size_t t = 0; t < 20; ++t)
    for (uint32_t point : cubes.triangles[t]) EXPECT_EQ(cubes.values[point], t < 10 ? 3 : 4);
}

TEST_F(Cells, ValuesOfLinesAndVerticesAreThoseOfTheirCells) {
  const std::string text = legacyFile(
      "POLYDATA", coordinates({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}}) +
                      "VERTICES 1 2\n1 3\nLINES 2 7\n3 0 1 2\n2 2 3\nCELL_DATA 3\nSCALARS p float\n"
                      "LOOKUP_TABLE default\n7 1 2\n");
  const GeometryBlock lines = read(text, "g.vtk", GeometryKind::PathLines).block;
  ASSERT_EQ(lines.segments.size(), 3u);
  EXPECT_EQ(lines.segments[0][1], lines.segments[1][0]);
  EXPECT_EQ(lines.neighbours[0][1], lines.segments[1][1]);
  for (size_t s = 0; s < 3; ++s)
    for (uint32_t point : lines.segments[s]) EXPECT_EQ(lines.values[point], s < 2 ? 1 : 2);
  const GeometryBlock points = read(text, "g.vtk", GeometryKind::Particles).block;
  ASSERT_EQ(points.values.size(), 4u);
  EXPECT_TRUE(std::isnan(points.values[0]));
  EXPECT_EQ(points.values[3], 7);
}

TEST_F(Cells, ArraysOfPointsComeFirstUnlessThoseOfCellsAreActive) {
  const std::string points = "POINT_DATA 12\nFIELD f 1\na 1 12 float\n0 1 2 3 4 5 6 7 8 9 10 11\n";
  const std::string field = "CELL_DATA 2\nFIELD f 1\nb 1 2 float\n3 4\n",
                    scalars = "CELL_DATA 2\nSCALARS b float\nLOOKUP_TABLE default\n3 4\n";
  EXPECT_EQ(read(twoCubes(field + points)).array, "a");
  EXPECT_EQ(read(twoCubes(scalars + points)).array, "b");
  EXPECT_EQ(read(twoCubes(field + points), "g.vtk", GeometryKind::Triangles, "b").array, "b");
  try {
    read(twoCubes(field + points), "g.vtk", GeometryKind::Triangles, "c");
    ADD_FAILURE() << "no error";
  } catch (const Error& e) {
    EXPECT_EQ(e.what(),
              (folder_ / "g.vtk") + std::string(": no array 'c' of points or cells; of points the file "
                                                "has 'a', of cells 'b'"));
  }
}

TEST_F(Cells, StructuredAndRectilinearGridsShowTheirSides) {
  std::string cells = "CELL_DATA 6\nSCALARS p float\nLOOKUP_TABLE default\n0 1 2 3 4 5\n";
  const std::string rectilinear = legacyFile("RECTILINEAR_GRID",
                                             "DIMENSIONS 4 3 2\nX_COORDINATES 4 float\n0 1 2 "
                                             "4\nY_COORDINATES 3 float\n0 1 3\nZ_COORDINATES 2 float\n0 1\n");
  Points points;
  for (double z : {0., 1.})
    for (double y : {0., 1., 3.})
      for (double x : {0., 1., 2., 4.}) points.push_back({x, y, z});
  const std::string structured = legacyFile("STRUCTURED_GRID", "DIMENSIONS 4 3 2\n" + coordinates(points));
  for (const std::string& text : {rectilinear, structured}) {
    const GeometryBlock block = read(text + cells).block;
    EXPECT_EQ(block.triangles.size(), 2u * 2 * (6 + 3 + 2));
    EXPECT_NEAR(volumeOf(block), 12, 1e-12);
    EXPECT_NEAR(areaOf(block), 2 * (12 + 4 + 3), 1e-12);
    for (const auto& t : block.triangles) EXPECT_EQ(block.values[t[0]], block.values[t[2]]);
    // without the middle one of the first row of cells, of volume 1, its neighbours show three more sides
    const std::string hidden = text + cells + "FIELD f 1\nvtkGhostType 1 6 unsigned_char\n0 32 0 0 0 0\n";
    EXPECT_NEAR(volumeOf(read(hidden).block), 11, 1e-12);
  }
}

std::string xml(const std::string& type, const std::string& body) {
  return "<VTKFile type=\"" + type + "\" version=\"0.1\" byte_order=\"LittleEndian\"><" + type + body + "</" +
         type + "></VTKFile>";
}

TEST_F(Cells, XmlGridsShowTheirSides) {
  const std::string points = "0 0 0 1 0 0 0 2 0 1 2 0 0 0 1 1 0 1 0 2 1 1 2 1";
  const std::string structured =
      xml("StructuredGrid",
          " WholeExtent=\"3 4 0 1 0 1\"><Piece Extent=\"3 4 0 1 0 1\"><CellData "
          "Scalars=\"p\"><DataArray type=\"Float32\" Name=\"p\" format=\"ascii\">5</DataArray>"
          "</CellData><Points><DataArray type=\"Float32\" NumberOfComponents=\"3\" "
          "format=\"ascii\">" +
              points + "</DataArray></Points></Piece>");
  const auto axis = [](const char* values) {
    return std::string("<DataArray type=\"Float64\" format=\"ascii\">") + values + "</DataArray>";
  };
  const std::string rectilinear =
      xml("RectilinearGrid",
          " WholeExtent=\"0 1 0 1 0 1\"><Piece Extent=\"0 1 0 1 0 1\"><CellData "
          "Scalars=\"p\"><DataArray type=\"Float32\" Name=\"p\" format=\"ascii\">5</DataArray>"
          "</CellData><Coordinates>" +
              axis("0 1") + axis("0 2") + axis("0 1") + "</Coordinates></Piece>");
  for (const auto& [name, text] : {std::pair("g.vts", structured), std::pair("g.vtr", rectilinear)}) {
    const GeometryBlock block = read(text, name).block;
    EXPECT_NEAR(volumeOf(block), 2, 1e-12) << name;
    EXPECT_EQ(block.values, std::vector<float>(8, 5)) << name;
    std::string cut = text;
    cut.replace(cut.find("<Piece Extent") + 15, 1, "2");
    EXPECT_THROW(read(cut, name), Error) << name;
  }
}

std::string triangle(const std::string& arrays) {
  return xml("PolyData",
             "><Piece NumberOfPoints=\"3\" NumberOfPolys=\"1\"><PointData>" + arrays +
                 "</PointData><Points><DataArray type=\"Float32\" NumberOfComponents=\"3\" "
                 "format=\"ascii\">0 0 0 1 0 0 0 1 0</DataArray></Points><Polys><DataArray "
                 "type=\"Int32\" Name=\"connectivity\" format=\"ascii\">0 1 2</DataArray><DataArray "
                 "type=\"Int32\" Name=\"offsets\" format=\"ascii\">3</DataArray></Polys></Piece>");
}
std::string array(const std::string& name, const std::string& values) {
  return "<DataArray type=\"Float32\" Name=\"" + name + "\" format=\"ascii\">" + values + "</DataArray>";
}

TEST_F(Cells, WordsOfXmlTextThatAreNoNumbersAreErrors) {
  for (const char* word : {"1.0-101", "3.0d2", "1,2", "x"}) {
    try {
      read(triangle(array("a", "0 " + std::string(word) + " 1")), "g.vtp");
      ADD_FAILURE() << "no error: " << word;
    } catch (const Error& e) {
      EXPECT_EQ(e.what(), (folder_ / "g.vtp") + ": array 'a': found \"" + word +
                              "\", expected a number of type float32");
    }
  }
  EXPECT_EQ(read(triangle(array("a", "+1 1e-3 -.5")), "g.vtp").block.values,
            (std::vector<float>{1, 1e-3f, -.5f}));
}

TEST_F(Cells, XmlTextMayEndWithNan) {
  for (const char* end : {"nan", "NaN", "nan\n", "inf"}) {
    const std::vector<float> values =
        read(triangle(array("a", "0 nan " + std::string(end)) + array("b", "1 2 3")), "g.vtp").block.values;
    ASSERT_EQ(values.size(), 3u);
    EXPECT_EQ(values[0], 0);
    EXPECT_TRUE(std::isnan(values[1]));
    EXPECT_FALSE(std::isfinite(values[2]));
  }
}

/// Values of the points of all pieces, on several ranks.
std::vector<float> valuesOfPieces(const std::string& list, int count) {
  std::vector<float> values;
  std::mutex mutex;
  ThreadRanks ranks(count);
  const auto errors = ranks.run([&](Collectives& mine) {
    const LoadedGeometry loaded = loadGeometry(list, GeometryKind::Triangles, "", mine);
    const std::lock_guard lock(mutex);
    values.insert(values.end(), loaded.geometry.block.values.begin(), loaded.geometry.block.values.end());
  });
  EXPECT_EQ(errors, std::vector<std::string>(size_t(count)));
  std::sort(values.begin(), values.end());
  return values;
}

TEST_F(Cells, AllPiecesOfAListHaveTheArrayOfRadii) {
  writeText(folder_ / "0.vtp", triangle(array("a", "1 1 1") + array("b", "2 3 4")));
  writeText(folder_ / "1.vtp", triangle(array("b", "5 6 7") + array("a", "1 1 1")));
  writeText(
      folder_ / "g.pvtp",
      xml("PPolyData",
          " GhostLevel=\"0\"><PPointData><PDataArray type=\"Float32\" Name=\"a\"/><PDataArray "
          "type=\"Float32\" Name=\"b\"/></PPointData><Piece Source=\"0.vtp\"/><Piece Source=\"1.vtp\"/>"));
  const auto radii = [&](const std::string& array, Collectives& mine) {
    ValuesWanted wanted;
    wanted.radii = array;
    return loadGeometry(folder_ / "g.pvtp", GeometryKind::Triangles, wanted, mine);
  };
  for (const int count : {1, 2}) {
    ThreadRanks ranks(count);
    const auto errors = ranks.run([&](Collectives& mine) {
      const LoadedGeometry loaded = radii("b", mine);
      EXPECT_EQ(loaded.geometry.radiusRange, (Range{2, 7}));
      EXPECT_EQ(loaded.geometry.range, (Range{1, 1}));
      EXPECT_EQ(loaded.geometry.block.radiusValues.size(), loaded.geometry.block.points.size());
      EXPECT_EQ(loaded.geometry.block.radiusValues.at(0), mine.rank() == 0 ? 2 : 5);
    });
    EXPECT_EQ(errors, std::vector<std::string>(size_t(count)));
    for (const std::string& error : ranks.run([&](Collectives& mine) { radii("c", mine); }))
      EXPECT_NE(error.find(".vtp: no array 'c' of points with values for radii; the file has 'a', 'b'"),
                std::string::npos)
          << error;
  }
}

TEST_F(Cells, AllPiecesOfAListHaveTheSameArray) {
  writeText(folder_ / "0.vtp", triangle(array("a", "1 1 1") + array("b", "2 2 2")));
  writeText(folder_ / "1.vtp", triangle(array("b", "2 2 2") + array("a", "1 1 1")));
  const std::string pieces = "<Piece Source=\"0.vtp\"/><Piece Source=\"1.vtp\"/>";
  const auto list = [&](const std::string& declared) {
    writeText(folder_ / "g.pvtp", xml("PPolyData", " GhostLevel=\"0\">" + declared + pieces));
    return folder_ / "g.pvtp";
  };
  const std::string arrays =
      "<PDataArray type=\"Float32\" Name=\"b\"/><PDataArray type=\"Float32\" Name=\"a\"/>";
  const std::vector<float> ones(6, 1), twos(6, 2);
  for (int ranks : {1, 2, 3}) {
    EXPECT_EQ(valuesOfPieces(list(""), ranks), ones) << ranks;  // what the first one has first
    EXPECT_EQ(valuesOfPieces(list("<PPointData>" + arrays + "</PPointData>"), ranks), twos) << ranks;
    EXPECT_EQ(valuesOfPieces(list("<PPointData Scalars=\"a\">" + arrays + "</PPointData>"), ranks), ones)
        << ranks;
    writeText(folder_ / "g.part", "{\"parts\": [{\"filename\": \"1.vtp\"}, {\"filename\": \"0.vtp\"}]}");
    EXPECT_EQ(valuesOfPieces(folder_ / "g.part", ranks), twos) << ranks;
  }
}

TEST_F(Cells, AListMayHaveAnyNumberOfPieces) {
  constexpr size_t kPieces = 70000;
  std::string pieces;
  for (size_t i = 0; i < kPieces; ++i) pieces += "<Piece Source=\"p" + std::to_string(i) + ".vtu\"/>";
  writeText(folder_ / "g.pvtu", xml("PUnstructuredGrid", " GhostLevel=\"0\">" + pieces));
  const std::vector<std::string> files = geometryPieces(folder_ / "g.pvtu");
  ASSERT_EQ(files.size(), kPieces);
  EXPECT_EQ(files.back(), folder_ / "p69999.vtu");
  writeText(folder_ / "g.pvtu", xml("PUnstructuredGrid", " GhostLevel=\"0\"><Piece/>"));
  EXPECT_THROW(geometryPieces(folder_ / "g.pvtu"), Error);
}

TEST_F(Cells, WarningsOfAllPiecesReachTheirUser) {
  writeText(folder_ / "0.vtp", triangle(array("a", "1 1 1")));
  writeText(folder_ / "1.vtp", triangle(array("b", "2 2 2")));
  writeText(folder_ / "g.part", "{\"parts\": [{\"filename\": \"0.vtp\"}, {\"filename\": \"1.vtp\"}]}");
  ThreadRanks ranks(2);
  std::vector<std::string> warnings[2];
  const auto errors = ranks.run([&](Collectives& mine) {
    const LoadedGeometry loaded =
        loadGeometry(folder_ / "g.part", GeometryKind::Triangles, "", mine, {}, &warnings[mine.rank()]);
    EXPECT_TRUE(loaded.geometry.block.values.empty());
  });
  EXPECT_EQ(errors, std::vector<std::string>(2));
  EXPECT_EQ(warnings[0],
            std::vector<std::string>{(folder_ / "1.vtp") + ": no array \"a\", so values are not used"});
  EXPECT_TRUE(warnings[1].empty());
}

}  // namespace
}  // namespace gxy

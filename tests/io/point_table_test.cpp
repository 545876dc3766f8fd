// SPDX-License-Identifier: Apache-2.0
// Points as lines of text, and meshes in the Object File Format.
#include <gtest/gtest.h>

#include <cmath>

#include "core/comm/error.h"
#include "core/io/file.h"
#include "core/io/geometry_file.h"
#include "tests/io/fixtures.h"

namespace gxy {
namespace {

using testing::TemporaryFolder;
using Points = std::vector<glm::dvec3>;

class PointTable : public ::testing::Test {
 protected:
  GeometryContent read(const std::string& name, const std::string& text, const std::string& array = {}) {
    writeText(folder_ / name, text);
    return readGeometry(folder_ / name,
                        name.ends_with(".off") ? GeometryKind::Triangles : GeometryKind::Particles, array);
  }
  /// Without the path.
  std::string errorOf(const std::string& name, const std::string& text) {
    try {
      read(name, text);
    } catch (const Error& e) {
      return std::string(e.what()).substr((folder_ / name).size() + 2);
    }
    return "no error";
  }
  const TemporaryFolder folder_;
};

TEST_F(PointTable, CsvFindsCoordinatesByName) {
  const GeometryContent content = read("t.csv", "mass, Z ,X,Y\r\n5,3,1,2\r\n\r\n7,6,4,5\r\n", "mass");
  EXPECT_EQ(content.block.points, (Points{{1, 2, 3}, {4, 5, 6}}));
  EXPECT_EQ(content.block.values, (std::vector<float>{5, 7}));
}

TEST_F(PointTable, CsvComponentsAreOneArray) {
  const GeometryContent content =
      read("t.csv",
           "\"velocity:0\";\"velocity:1\";\"Points:0\";\"Points:1\";\"Points:2\"\n"
           "3;4;1e3;-2;+.5\n",
           "velocity");
  EXPECT_EQ(content.block.points, (Points{{1000, -2, 0.5}}));
  EXPECT_EQ(content.block.values, (std::vector<float>{5})) << "the magnitude";
}

TEST_F(PointTable, CsvWithoutNamesBeginsWithTheCoordinates) {
  const GeometryContent content = read("t.csv", "1\t2\t3\t4\n5\t6\t7\t8\n", "column 4");
  EXPECT_EQ(content.block.points, (Points{{1, 2, 3}, {5, 6, 7}}));
  EXPECT_EQ(content.block.values, (std::vector<float>{4, 8}));
}

TEST_F(PointTable, CsvMayBeFlatHaveTextAndHoles) {
  const GeometryContent content = read("t.csv", "\xef\xbb\xbfname,x,y,t\nsun,1,2,\n\"a, b\",3,4,5\n", "t");
  EXPECT_EQ(content.block.points, (Points{{1, 2, 0}, {3, 4, 0}}));
  ASSERT_EQ(content.block.values.size(), 2u);
  EXPECT_TRUE(std::isnan(content.block.values[0]));
  EXPECT_EQ(content.block.values[1], 5);
  EXPECT_EQ(
      content.warnings,
      (std::vector<std::string>{(folder_ / "t.csv") + ": line 2: 'name': a column of text is passed over"}));
}

TEST_F(PointTable, CsvErrorsSayWhereAndWhatWasExpected) {
  EXPECT_EQ(errorOf("t.csv", "a,b\n1,2\n"), "the columns are 'a', 'b', expected 'x', 'y' and 'z' among them");
  EXPECT_EQ(errorOf("t.csv", "x,y,z\n1,2,3\n1,2\n"), "line 3: 2 fields, expected 3");
  EXPECT_EQ(errorOf("t.csv", "x,y,z\n1,2,three\n"), "line 2: found 'three', expected a coordinate");
  EXPECT_EQ(errorOf("t.csv", "1,2\n"), "line 1: 2 columns, expected three or more");
  EXPECT_EQ(errorOf("t.csv", "\n"), "it is empty, expected columns 'x', 'y' and 'z'");
}

TEST_F(PointTable, XyzIsACloudOfPoints) {
  const GeometryContent content = read("t.xyz", "# a scan\n1 2 3 0.5\n\n4 5 6 0.25 # the last\n", "value 1");
  EXPECT_EQ(content.block.points, (Points{{1, 2, 3}, {4, 5, 6}}));
  EXPECT_EQ(content.block.values, (std::vector<float>{0.5f, 0.25f}));
  EXPECT_EQ(errorOf("t.xyz", "1 2 3\n1 2\n"), "line 2: 2 numbers, expected 3");
  EXPECT_EQ(errorOf("t.xyz", "1 2 x\n"), "line 1: found 'x', expected a number");
}

TEST_F(PointTable, XyzMayBeAtoms) {
  const GeometryContent content =
      read("t.xyz", "3\nwater\nO 0 0 0\nH 0.96 0 0\n1 -0.24 0.93 0\n3\nlater\n", "element");
  EXPECT_EQ(content.block.points, (Points{{0, 0, 0}, {0.96, 0, 0}, {-0.24, 0.93, 0}}));
  EXPECT_EQ(content.block.values, (std::vector<float>{8, 1, 1}));
  EXPECT_EQ(
      content.warnings,
      (std::vector<std::string>{(folder_ / "t.xyz") +
                                ": line 6: what comes after the first atoms is passed over (2 of these)"}));
  EXPECT_EQ(errorOf("t.xyz", "2\n\nO 0 0 0\n"), "line 3: the file ends after 1 of 2 atoms");
  EXPECT_EQ(errorOf("t.xyz", "1\n\nO 0 0\n"), "line 3: expected an atom: a symbol and three coordinates");
}

TEST_F(PointTable, OffIsAMesh) {
  const char* const square =
      "OFF\n# a square\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3  # and a comment\n";
  const GeometryContent content = read("t.off", square);
  EXPECT_EQ(content.block.points, (Points{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}));
  EXPECT_EQ(content.block.triangles, (std::vector<std::array<uint32_t, 3>>{{0, 1, 2}, {0, 2, 3}}));
  EXPECT_TRUE(content.warnings.empty());
  EXPECT_EQ(read("t.off", std::string("OFF 4 2 0") + (square + 20)).block.triangles.size(), 2u);
  EXPECT_EQ(read("t.off", square + 4).block.triangles.size(), 2u) << "without the keyword";
}

TEST_F(PointTable, OffMayHaveNormalsAndColours) {
  const GeometryContent content = read(
      "t.off",
      "CNOFF\n3 2 0\n0 0 0 0 0 1 255 0 0\n1 0 0 0 1 0 0 255 0\n0 1 0 1 0 0 0 0 255\n3 0 1 2 7 7 7\n2 0 1\n");
  EXPECT_EQ(content.block.normals, (std::vector<glm::vec3>{{0, 0, 1}, {0, 1, 0}, {1, 0, 0}}));
  EXPECT_EQ(content.block.triangles.size(), 1u);
  EXPECT_EQ(content.block.colors, (std::vector<glm::vec3>{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}));
  EXPECT_EQ(content.warnings,
            (std::vector<std::string>{(folder_ / "t.off") +
                                      ": line 7: a face of fewer than 3 corners is left out"}));
}

TEST_F(PointTable, OffErrorsSayWhereAndWhatWasExpected) {
  EXPECT_EQ(errorOf("t.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n"),
            "line 6: face 0 refers to vertex 3 of 3");
  EXPECT_EQ(errorOf("t.off", "OFF\n3 1 0\n0 0 0\n1 0\n"), "line 4: the line ends, expected a coordinate");
  EXPECT_EQ(
      errorOf("t.off", "OFF BINARY\n"),
      "line 1: found 'OFF BINARY', expected OFF with ST, C or N before it, as text and of 3 dimensions");
  EXPECT_EQ(errorOf("t.off", "4OFF\n"),
            "line 1: found '4OFF', expected OFF with ST, C or N before it, as text and of 3 dimensions");
  EXPECT_EQ(errorOf("t.off", "OFF\n1000 1 0\n"),
            "line 2: 1000 vertices and 1 faces are more than the file's 13 bytes can hold");
  EXPECT_EQ(errorOf("t.off", "OFF\n1 1 0\n0 0 0\n"), "line 3: the file ends, expected face 1 of 1");
}

}  // namespace
}  // namespace gxy

// SPDX-License-Identifier: Apache-2.0
// PLY, OBJ, STL and legacy VTK files: what is read from sound ones, and that damaged ones give an Error that
// names the file and never more than that.
#include <gtest/gtest.h>

#include <bit>
#include <clocale>
#include <cstring>
#include <functional>
#include <glm/geometric.hpp>

#include "core/comm/error.h"
#include "core/io/file.h"
#include "core/io/geometry_file.h"
#include "core/io/write_geometry.h"
#include "tests/io/fixtures.h"

namespace gxy {
namespace {

using testing::mutated;
using testing::QuietLog;
using testing::TemporaryFolder;

using Triangles = std::vector<std::array<uint32_t, 3>>;

GeometryBlock tetrahedron() {
  GeometryBlock block;
  block.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  block.values = {1, 2, 3, 4};
  block.normals.assign(4, {0, 0, 1});
  block.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  block.ids = {0, 1, 2, 3};
  return block;
}

class MeshReader : public ::testing::Test {
 protected:
  GeometryContent read(const std::string& name, const std::string& bytes,
                       const std::string& array = {}) const {
    writeText(folder_ / name, bytes);
    return readGeometry(folder_ / name, GeometryKind::Triangles, array);
  }

  /// The message of the Error without the path, which it must begin with; for both ways of reading.
  std::string errorOf(const std::string& name, const std::string& bytes) const {
    const std::string path = folder_ / name;
    writeText(path, bytes);
    EXPECT_THROW(summariseGeometry(path), Error);
    try {
      readGeometry(path, GeometryKind::Triangles);
    } catch (const Error& e) {
      const std::string text = e.what();
      EXPECT_TRUE(text.starts_with(path + ": ")) << text;
      return text.substr(std::min(text.size(), path.size() + 2));
    }
    ADD_FAILURE() << "no error";
    return {};
  }

  /// What is told of a file's flaws, each text without the path, which it must begin with.
  std::vector<std::string> warningsOf(const std::string& name, const std::string& bytes,
                                      GeometryKind kind = GeometryKind::Triangles) const {
    writeText(folder_ / name, bytes);
    std::vector<std::string> warnings = readGeometry(folder_ / name, kind).warnings;
    for (std::string& text : warnings) {
      EXPECT_TRUE(text.starts_with((folder_ / name) + ": ")) << text;
      text.erase(0, std::min(text.size(), (folder_ / name).size() + 2));
    }
    return warnings;
  }

  std::string written(const std::string& name) const {
    writeGeometry(folder_ / name, tetrahedron(), GeometryKind::Triangles);
    return readText(folder_ / name);
  }

  const TemporaryFolder folder_;
};

const std::string kXyz = "property float x\nproperty float y\nproperty float z\n";

std::string asciiPly(const std::string& vertexProperties, const std::string& body,
                     const std::string& vertices = "3",
                     const std::string& corners = "property list uchar int vertex_indices\n") {
  return "ply\nformat ascii 1.0\ncomment made here\nelement vertex " + vertices + "\n" + vertexProperties +
         "element face 1\n" + corners + "end_header\n" + body;
}

const std::string kCorner = "0 0 0\n1 0 0\n0 1 0\n";

TEST_F(MeshReader, PlyThatWasWrittenIsReadWithoutLoss) {
  written("g.ply");
  const GeometryContent content = readGeometry(folder_ / "g.ply", GeometryKind::Triangles);
  EXPECT_EQ(content.block, tetrahedron());
  EXPECT_EQ(content.array, "value");
}

TEST_F(MeshReader, PlyIsTheSameInAllThreeEncodings) {
  const std::string header =
      " 1.0\r\nelement note 1\r\nproperty list ushort short words\r\nelement vertex 4\r\nproperty double "
      "x\r\n"
      "property float32 y\r\nproperty int16 z\r\nproperty uchar heat\r\nelement face 1\r\nproperty char "
      "flag\r\n"
      "property list uint8 uint vertex_index\r\nend_header\r\n";
  std::string bytes[2];
  for (const bool big : {false, true}) {
    const auto put = [&](auto value) {
      char raw[sizeof value];
      std::memcpy(raw, &value, sizeof value);
      if (big != (std::endian::native == std::endian::big)) std::reverse(raw, raw + sizeof value);
      bytes[big].append(raw, sizeof value);
    };
    put(uint16_t(2)), put(int16_t(-1)), put(int16_t(7));
    for (int i = 0; i < 4; ++i) put(i + 0.1), put(float(-i)), put(int16_t(i - 300)), put(uint8_t(200 + i));
    put(int8_t(-1)), put(uint8_t(4));
    for (uint32_t i = 0; i < 4; ++i) put(3 - i);
  }
  const GeometryBlock ascii =
      read("a.ply",
           "ply\r\nformat ascii" + header +
               "2 -1 7\r\n0.1 0 -300 200\r\n1.1 -1 -299 201\n2.1 -2 -298 202\n3.1 -3 -297 203\n-1 4 3 2 1 0")
          .block;
  EXPECT_EQ(ascii.points[3], glm::dvec3(3.1, -3, -297));
  EXPECT_EQ(ascii.values, (std::vector<float>{200, 201, 202, 203}));
  EXPECT_EQ(ascii.triangles, (Triangles{{3, 2, 1}, {3, 1, 0}}));
  EXPECT_EQ(read("l.ply", "ply\r\nformat binary_little_endian" + header + bytes[0]).block, ascii);
  EXPECT_EQ(read("b.ply", "ply\r\nformat binary_big_endian" + header + bytes[1]).block, ascii);
}

TEST_F(MeshReader, PlyColorsComeBeforeOtherValues) {
  const std::string text =
      asciiPly(kXyz + "property float heat\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n",
               "0 0 0 9 255 51 0\n1 0 0 9 0 0 0\n0 1 0 9 0 0 255\n3 0 1 2\n");
  const GeometryBlock block = read("g.ply", text).block;
  EXPECT_TRUE(block.values.empty());
  EXPECT_EQ(block.colors, (std::vector<glm::vec3>{{1, 0.2f, 0}, {0, 0, 0}, {0, 0, 1}}));
  EXPECT_EQ(read("g.ply", text, "heat").block.values, (std::vector<float>{9, 9, 9}));
}

TEST_F(MeshReader, PlyWithoutThreeScalarCoordinatesIsAnError) {
  EXPECT_EQ(errorOf("g.ply", asciiPly("property float x\nproperty float y\n", "0 0\n1 0\n0 1\n3 0 1 2\n")),
            "element 'vertex': expected a property 'z' that is a number, found none");
  EXPECT_EQ(errorOf("g.ply", asciiPly("property list uchar float x\nproperty float y\nproperty float z\n",
                                      "1 0 0 0\n1 1 0 0\n1 0 1 0\n3 0 1 2\n")),
            "element 'vertex': expected a property 'x' that is a number, found a list");
}

TEST_F(MeshReader, PlyFacesOfMissingVerticesAreAnError) {
  EXPECT_EQ(errorOf("g.ply", asciiPly(kXyz, kCorner + "3 0 1 2000000\n")),
            "line 14: face 0: refers to vertex 2000000 of 3");
  EXPECT_EQ(errorOf("g.ply", asciiPly(kXyz, kCorner + "3 0 1 -1\n")),
            "line 14: face 0: refers to vertex -1 of 3");
}

TEST_F(MeshReader, PlyCountsThatTheFileCannotHoldAreAnError) {
  EXPECT_EQ(errorOf("g.ply", asciiPly(kXyz, kCorner + "3 0 1 2\n", "-5")),
            "line 4: element 'vertex' has no valid count: expected an integer from 0 on");
  for (const char* count : {"2000000000", "18446744073709551615"})
    EXPECT_NE(errorOf("g.ply", asciiPly(kXyz, kCorner + "3 0 1 2\n", count)).find("the file ends too early"),
              std::string::npos);
  EXPECT_EQ(errorOf("g.ply", asciiPly(kXyz, kCorner + "4000000000 0 1 2\n", "3",
                                      "property list uint int vertex_indices\n")),
            "line 14: face 0: the file ends within list 'vertex_indices' of 4000000000 entries");
  EXPECT_EQ(errorOf("g.ply", "ply\nformat ascii 1.0\nelement nothing 9999999999999\nelement vertex 0\n" +
                                 kXyz + "end_header\n"),
            "element 'nothing' has no properties");
}

TEST_F(MeshReader, PlyListsOfNegativeLengthAreAnError) {
  const std::string header = "ply\nformat binary_little_endian 1.0\nelement vertex 1\n" + kXyz +
                             "element face 1\nproperty list int int vertex_indices\nend_header\n";
  EXPECT_EQ(errorOf("g.ply", header + std::string(12, '\0') + std::string(4, '\xff')),
            "face 0: list 'vertex_indices' has -1 entries");
}

TEST_F(MeshReader, PlyFacesThatAreNoListsOfIntegersAreAnError) {
  for (const char* corners : {"property float vertex_indices\n", "property list uchar float vertex_indices\n",
                              "property list uchar int corners\n"})
    EXPECT_EQ(errorOf("g.ply", asciiPly(kXyz, kCorner + "3 0 1 2\n", "3", corners)),
              "element 'face': expected a property list of integers 'vertex_indices'");
}

TEST_F(MeshReader, NumbersDoNotDependOnTheLocale) {
  const std::string before = std::setlocale(LC_ALL, nullptr);
  for (const char* name : {"de_DE.UTF-8", "fr_FR.UTF-8", "C.UTF-8"})
    if (std::setlocale(LC_ALL, name)) break;
  const GeometryBlock ply = read("g.ply", asciiPly(kXyz, "+0.5 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")).block;
  const GeometryBlock obj = read("g.obj", "v 0.5 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").block;
  std::setlocale(LC_ALL, before.c_str());
  EXPECT_EQ(ply.points[0].x, 0.5);
  EXPECT_EQ(obj.points[0].x, 0.5);
}

TEST_F(MeshReader, EveryTruncationOfABinaryMeshIsAnError) {
  for (const char* name : {"g.ply", "g.stl"}) {
    const std::string whole = written(name);
    for (size_t size = 0; size < whole.size(); ++size) errorOf(name, whole.substr(0, size));
  }
}

TEST_F(MeshReader, ObjCornersHaveFourFormsAndCountFromEitherEnd) {
  const std::string vertices =
      "v 0 0 0\nv 1 0 0 # second\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 0.5\nvn 0 0 2\nvn 0 1 0\n";
  for (const char* face : {"f 1 2 3 4", "f 1/1 2/2 3/1 4/2", "f 1//1 2//1 3//1 4//1",
                           "f 1/1/1 2/1/1 3/1/1 4/1/1", "f -4 -3 -2 -1", "f -4/-2/-2 2/-1/1 3/1/1 -1/1/1"})
    EXPECT_EQ(read("g.obj", vertices + face).block.triangles, (Triangles{{0, 1, 2}, {0, 2, 3}})) << face;
  EXPECT_EQ(read("g.obj", vertices + "f 1//1 2//1 3//1\n").block.normals[0], glm::vec3(0, 0, 1));
  EXPECT_TRUE(read("g.obj", vertices + "f 1//1 2//1 3\n").block.normals.empty());
}

TEST_F(MeshReader, ObjLinesGoOnAfterABackslash) {
  const std::string vertices = "v 0 0 0\nv 1 \\\n0 0\nv 1 1 0\nv 0 1 0\n";
  for (const char* face :
       {"f 1 2 \\\n3 4\n", "f 1 2\\\r\n3\\\r\n4", "f 1 2 3 4 \\\n", "f 1 2 3 4\\", "# no more \\\nf 1 2 3 4"})
    EXPECT_EQ(read("g.obj", vertices + face).block.triangles, (Triangles{{0, 1, 2}, {0, 2, 3}})) << face;
}

TEST_F(MeshReader, ObjVerticesWithTwoNormalsBecomeTwoPoints) {
  const GeometryBlock block = read("g.obj",
                                   "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvn 0 0 1\nvn 1 0 0\n"
                                   "f 1//1 2//1 3//1\nf 1//2 3//2 4//2\nf 1//2 2//1 4//2\n")
                                  .block;
  ASSERT_EQ(block.points.size(), 6u);
  EXPECT_EQ(block.triangles, (Triangles{{0, 1, 2}, {4, 5, 3}, {4, 1, 3}}));
  EXPECT_EQ(block.points[5], block.points[2]);
  EXPECT_EQ(block.normals[2], glm::vec3(0, 0, 1));
  EXPECT_EQ(block.normals[5], glm::vec3(1, 0, 0));
}

TEST_F(MeshReader, ObjLinesArePathLines) {
  writeText(folder_ / "g.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nl 1 2 3\n");
  EXPECT_EQ(readGeometry(folder_ / "g.obj", GeometryKind::PathLines).block.segments.size(), 2u);
}

TEST_F(MeshReader, ObjNormalsAndCoordinatesThatDoNotExistAreNotUsed) {
  using Warnings = std::vector<std::string>;
  const std::string vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\n";
  EXPECT_EQ(warningsOf("g.obj", vertices + "f 1 2 3\nf 1//7 2//8 3//9\n"),
            Warnings{"face 2: a normal that is not there is not used (3 of these)"});
  EXPECT_EQ(warningsOf("g.obj", vertices + "f 1/1 2/5 3/-4\n"),
            Warnings{"line 5: texture coordinates that are not there are not used (2 of these)"});
  for (const char* face : {"f 1//7 2//8 3//9\n", "f 1/1/-1 2/5/-1 3/1/-1\n"}) {
    const GeometryBlock block = read("g.obj", vertices + face).block;
    EXPECT_EQ(block.triangles, (Triangles{{0, 1, 2}}));
    EXPECT_TRUE(block.normals.empty());
  }
}

TEST_F(MeshReader, ObjCornersMayEndWithSlashes) {
  for (const char* face : {"f 1/ 2/ 3/", "f 1// 2// 3//", "f 1/1/ 2/1/ 3/1/"}) {
    const std::string text = std::string("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\n") + face;
    EXPECT_EQ(read("g.obj", text).block.triangles, (Triangles{{0, 1, 2}})) << face;
    EXPECT_EQ(warningsOf("g.obj", text),
              std::vector<std::string>{
                  "line 5: a corner ends with '/', so that it has no more than is before (3 of these)"});
  }
}

TEST_F(MeshReader, ObjMayBeginWithAByteOrderMark) {
  const GeometryBlock block =
      read("g.obj", "\xef\xbb\xbfv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\n").block;
  EXPECT_EQ(block.points, (std::vector<glm::dvec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}));
  EXPECT_EQ(block.triangles, (Triangles{{0, 1, 2}}));
}

TEST_F(MeshReader, LinesOfObjAndStlMayEndWithCarriageReturnsAlone) {
  const std::string obj = "v 0 0 0\rv 1 0 0\rv 0 1 0\rv 1 1 0\r# end\rf 1 2 3\r";
  EXPECT_EQ(read("g.obj", obj).block.triangles, (Triangles{{0, 1, 2}}));
  EXPECT_EQ(read("g.obj", obj).block.points.size(), 4u);
  EXPECT_EQ(errorOf("g.obj", obj + "f 1 2 x"),
            "line 7: found the corner 'x', expected v, v/t, v//n or v/t/n with numbers that are not 0");
  EXPECT_EQ(read("g.stl",
                 "solid a\rfacet normal 0 0 1\router loop\rvertex 0 0 0\rvertex 1 0 0\rvertex 0 1 0\r"
                 "endloop\rendfacet\rendsolid a\r")
                .block.triangles.size(),
            1u);
}

TEST_F(MeshReader, ObjCornersThatDoNotExistAreAnError) {
  const std::string vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\n";
  EXPECT_EQ(errorOf("g.obj", vertices + "f 1 2 3\nf 1 2 99999\n"), "face 2 refers to vertex 99999 of 3");
  EXPECT_EQ(errorOf("g.obj", vertices + "f -1 -2 -9\n"), "line 5: refers to vertex -9 of 3");
}

TEST_F(MeshReader, ObjMalformedStatementsAreAnError) {
  const std::string vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  for (const char* corner : {"0", "/1", "//1", "1/2/3/4", "1.5", "x", "9223372036854775808"})
    EXPECT_EQ(errorOf("g.obj", vertices + "f 1 2 " + corner),
              "line 4: found the corner '" + std::string(corner) +
                  "', expected v, v/t, v//n or v/t/n with numbers that are not 0");
  EXPECT_EQ(errorOf("g.obj", "v 0 0\n"), "line 1: found '', expected a number");
}

TEST_F(MeshReader, BinaryStlMustHaveTheSizeItStates) {
  const std::string whole = written("g.stl");
  EXPECT_NE(errorOf("g.stl", whole.substr(0, 84 + 2 * 50)).find("184 bytes for 4 facets"), std::string::npos);
  EXPECT_NE(errorOf("g.stl", whole.substr(0, 84 + 3 * 50 + 49)).find("of 284 bytes"), std::string::npos);
  std::string header = whole;
  header.replace(0, 5, "solid");  // as some programs begin binary files
  EXPECT_EQ(read("g.stl", header).block, read("g.stl", whole).block);
}

TEST_F(MeshReader, BinaryStlMayGoOnAfterItsFacetsOrStateNone) {
  using Warnings = std::vector<std::string>;
  const std::string whole = written("g.stl");
  const GeometryBlock block = read("g.stl", whole).block;
  ASSERT_EQ(block.triangles.size(), 4u);
  for (const std::string& rest : {std::string("x"), std::string(70, 'y')}) {
    EXPECT_EQ(read("g.stl", whole + rest).block, block);
    EXPECT_EQ(warningsOf("g.stl", whole + rest),
              Warnings{"byte 284: what is after the last facet is passed over"});
  }
  std::string none = whole;
  none.replace(80, 4, 4, '\0');
  EXPECT_EQ(read("g.stl", none).block, block);
  EXPECT_EQ(warningsOf("g.stl", none), Warnings{"header: it states no facets, and is read to its end"});
  EXPECT_TRUE(warningsOf("g.stl", whole).empty());
}

TEST_F(MeshReader, AsciiStlNeedsNoNormalsAndNoEnd) {
  const std::string facet = "outer loop vertex 0 0 0 vertex 1 0 0 vertex 0 1 0 endloop endfacet\n";
  const std::string text = "solid a\nfacet normal 0 0 1 " + facet + "facet normal -1.#IND nan 0 " + facet;
  EXPECT_EQ(read("g.stl", text).block.triangles, (Triangles{{0, 1, 2}, {3, 4, 5}}));
  EXPECT_EQ(warningsOf("g.stl", text),
            (std::vector<std::string>{"line 3: a normal that is no number is not used",
                                      "line 4: the file ends without 'endsolid'"}));
  EXPECT_EQ(errorOf("g.stl", text + "facets"), "line 4: expected 'facet' or 'endsolid'");
}

TEST_F(MeshReader, AsciiStlIsReadInAnyCaseAndWithSeveralSolids) {
  const std::string solid =
      "solid a part\n facet normal 0 0 1\n  OUTER LOOP\n   vertex 0 0 0\n   vertex 1e0 0 0\n   vertex 0 1 0\n"
      "  endloop\n endfacet\nendsolid a part\n";
  EXPECT_EQ(read("g.stl", solid + solid).block.triangles, (Triangles{{0, 1, 2}, {3, 4, 5}}));
  EXPECT_EQ(errorOf("g.stl", solid.substr(0, solid.find(" 0 1 0"))),
            "line 6: the file ends, expected a number");
}

std::string legacy(const std::string& body, const std::string& type = "POLYDATA") {
  return "# vtk DataFile Version 3.0\nt\nASCII\nDATASET " + type + "\nPOINTS 3 float\n0 0 0 1 0 0 0 1 0\n" +
         body;
}

TEST_F(MeshReader, LegacyCellsWhoseSizesDoNotAddUpAreAnError) {
  EXPECT_EQ(
      errorOf("g.vtk", legacy("POLYGONS 1 4\n9999999 0 1 2\n")),
      "line 8: POLYGONS: cell 0 of 1 has 9999999 points, but 3 of the stated 4 integers are left for it");
  EXPECT_EQ(errorOf("g.vtk", legacy("LINES 1 4\n-1 0 1 2\n")),
            "line 8: LINES: cell 0 of 1 has -1 points, but 3 of the stated 4 integers are left for it");
  EXPECT_EQ(errorOf("g.vtk", legacy("VERTICES 2 2\n1 0\n")),
            "line 8: VERTICES: cell 1 of 2 is missing: 0 of the stated 2 integers are left for it");
  EXPECT_EQ(errorOf("g.vtk", legacy("POLYGONS 1 5\n3 0 1 2 0\n")),
            "line 8: POLYGONS: 1 cells take 4 integers, not 5");
  std::string binary = legacy("");
  binary.replace(binary.find("ASCII"), 5, "BINARY");
  binary.resize(binary.find("0 0 0 1"));
  binary +=
      std::string(36, '\0') + "POLYGONS 1 4\n" + std::string("\x7f\xff\xff\xff", 4) + std::string(12, '\0');
  EXPECT_NE(errorOf("g.vtk", binary).find("has 2147483647 points"), std::string::npos);
}

TEST_F(MeshReader, LegacyCellsOfMissingPointsAreAnError) {
  for (const char* id : {"3", "-1"})
    EXPECT_EQ(errorOf("g.vtk", legacy("POLYGONS 1 4\n3 0 1 " + std::string(id) + "\n")),
              "cell 0 refers to point " + std::string(id) + " of 3");
}

TEST_F(MeshReader, LegacyVersionsThatVtkCannotParseAreAnError) {
  for (const char* version : {"5.M-E", "5.", "x.0", "99999999999.0", ""}) {
    std::string text = legacy("POLYGONS 2 3\nOFFSETS vtktypeint64\n0 3\nCONNECTIVITY vtktypeint64\n0 1 2\n");
    text.replace(text.find("3.0"), 3, version);
    EXPECT_EQ(errorOf("g.vtk", text), "line 1: expected '# vtk DataFile Version' and two numbers, as 3.0");
  }
}

TEST_F(MeshReader, CellsWithTooFewPointsForTheirKindAreLeftOut) {
  using Warnings = std::vector<std::string>;
  const std::string face = "a face of fewer than 3 corners is left out",
                    line = "a line of fewer than 2 points is left out";
  EXPECT_EQ(warningsOf("g.vtk", legacy("POLYGONS 4 10\n3 0 1 2\n2 0 1\n1 0\n0\n")),
            Warnings{"cell 1: " + face + " (3 of these)"});
  EXPECT_EQ(warningsOf("g.vtk", legacy("LINES 2 5\n2 0 1\n1 0\n"), GeometryKind::PathLines),
            Warnings{"cell 1: " + line});
  EXPECT_EQ(warningsOf("g.ply", asciiPly(kXyz, kCorner + "2 0 1\n")), Warnings{"cell 0: " + face});
  EXPECT_EQ(warningsOf("g.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2\nl 1\nl 2\n"),
            (Warnings{"line 5: " + face, "line 6: " + line + " (2 of these)"}));
  EXPECT_EQ(read("g.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2\nf 1 2 3\n").block.triangles,
            (Triangles{{0, 1, 2}}));
}

TEST_F(MeshReader, PlyStripsTurnAtEachTriangleAndEndAtMinusOne) {
  const std::string text = "ply\nformat ascii 1.0\nelement vertex 5\n" + kXyz +
                           "element tristrips 1\nproperty list int int vertex_indices\nend_header\n"
                           "0 0 0\n1 0 0\n0 1 0\n1 1 0\n2 0 0\n9 0 1 2 3 -1 4 3 1 -1\n";
  EXPECT_EQ(read("g.ply", text).block.triangles, (Triangles{{0, 1, 2}, {2, 1, 3}, {4, 3, 1}}));
  std::string bad = text;
  bad.replace(bad.find("-1"), 2, "-2");
  EXPECT_EQ(errorOf("g.ply", bad), "line 15: tristrips 0: refers to vertex -2 of 5");
}

TEST_F(MeshReader, PixelsWithoutFourPointsAreAnError) {
  EXPECT_EQ(errorOf("g.vtk", legacy("CELLS 1 4\n3 0 1 2\nCELL_TYPES 1\n8\n", "UNSTRUCTURED_GRID")),
            "cell 0 is a pixel, but has not 4 points");
}

TEST_F(MeshReader, ConcavePolygonsAreCutInside) {
  // an L of area 3, whose notch a fan from its first corner would cover
  const std::string text = "v 0 2 0\nv 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nf 4 5 6 1 2 3\n";
  const GeometryBlock block = read("g.obj", text).block;
  ASSERT_EQ(block.triangles.size(), 4u);
  double area = 0;
  for (const auto& [a, b, c] : block.triangles)
    area += glm::length(glm::cross(block.points[b] - block.points[a], block.points[c] - block.points[a])) / 2;
  EXPECT_NEAR(area, 3, 1e-12);
}

TEST_F(MeshReader, LegacyOffsetsThatDoNotRiseAreAnError) {
  const auto text = [](const char* offsets) {
    std::string all = legacy("POLYGONS 3 6\nOFFSETS vtktypeint64\n" + std::string(offsets) +
                             "\nCONNECTIVITY vtktypeint64\n0 1 2 0 2 1\n");
    all[all.find("3.0")] = '5';
    return all;
  };
  EXPECT_EQ(read("g.vtk", text("0 3 6")).block.triangles, (Triangles{{0, 1, 2}, {0, 2, 1}}));
  for (const char* offsets : {"0 3 7", "0 -3 6", "1 3 6", "0 9 6", "0 3 5"})
    EXPECT_EQ(errorOf("g.vtk", text(offsets)),
              "the offsets of the cells do not rise from 0 to the 6 point ids that there are");
}

TEST_F(MeshReader, LegacyCountsThatTheFileCannotHoldAreAnError) {
  EXPECT_EQ(
      errorOf("g.vtk", legacy("CELLS 3 12\n3 0 1 2 3 0 1 2 3 0 1 2\nCELL_TYPES 1\n5\n", "UNSTRUCTURED_GRID")),
      "line 11: 1 CELL_TYPES for 3 CELLS");
  std::string many = legacy("");
  many.replace(many.find("POINTS 3"), 8, "POINTS 4000000000");
  EXPECT_NE(errorOf("g.vtk", many).find("ends too early for an array of 12000000000 values"),
            std::string::npos);
}

TEST_F(MeshReader, ArraysWithoutOneEntryPerPointOrCellAreAnError) {
  EXPECT_EQ(errorOf("g.vtk", legacy("POLYGONS 2 8\n3 0 1 2\n3 0 1 2\nCELL_DATA 2\nFIELD f 1\n"
                                    "vtkGhostType 1 1 unsigned_char\n0\n")),
            "array 'vtkGhostType' has 1 entries for 2 cells");
  EXPECT_EQ(
      errorOf("g.vtk",
              legacy("VERTICES 1 2\n1 0\nPOINT_DATA 3\nFIELD f 1\nvtkGhostType 1 1 unsigned_char\n0\n")),
      "array 'vtkGhostType' has 1 entries for 3 points");
}

TEST_F(MeshReader, LegacyFieldsAndMetadataBeforeTheCellsArePassedOver) {
  std::string text =
      legacy("METADATA\nINFORMATION 1\nNAME R LOCATION x\nDATA 2 0 1\n\nPOLYGONS 1 4\n3 0 1 2\n");
  text.insert(text.find("POINTS"),
              "FIELD FieldData 2\nTIME 1 1 double\n0.5\nnames 1 2 string\na b\nPOLYGONS 9 9\n");
  EXPECT_EQ(read("g.vtk", text).block.triangles, (Triangles{{0, 1, 2}}));
}

// While bytes are read, while they are parsed, and while cells are looked through.
TEST_F(MeshReader, ReadingEndsWhereverItsWatchSaysSo) {
  GeometryBlock many = tetrahedron();
  many.triangles.resize(150000, many.triangles[0]);
  for (size_t i = many.ids.size(); i < many.triangles.size(); ++i) many.ids.push_back(i);
  for (const char* const name : {"many.obj", "many.vtp"}) {
    const std::string path = folder_ / name;
    if (extensionOf(path) == ".obj") {
      std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
      for (int i = 0; i < 150000; ++i) text += "f 1 2 3  # and words\n";
      writeText(path, text);
    } else {
      writeGeometry(path, many, GeometryKind::Triangles);
    }
    int asked = 0, endsAt = -1;
    const ReadWatch watch([&] {
      if (++asked == endsAt) throw Error("enough");
    });
    readGeometry(path, GeometryKind::Triangles);
    const int all = asked;
    EXPECT_GE(all, 7) << name;
    for (endsAt = 1; endsAt <= all; ++endsAt) {
      asked = 0;
      EXPECT_THROW(readGeometry(path, GeometryKind::Triangles), Error) << name << ": " << endsAt;
      EXPECT_EQ(asked, endsAt) << name;
    }
  }
}

TEST_F(MeshReader, DamagedFilesGiveAResultOrAnError) {
  const std::string obj =
      "v 0 0 0\nv 1 0 0\nv 1 1 0\nvt 0 0\nvt 1 1\nvn 0 0 1\nf 1/1/1 2/2/1 3/1/1\nf 1//1 2//1 -1//1\nl 1 2 "
      "3\np 1\n";
  const std::string solid =
      "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 "
      "0\nendloop\nendfacet\nendsolid\n";
  const std::pair<std::string, std::string> whole[] = {
      {"a.ply", asciiPly(kXyz + "property uchar heat\n", "0 0 0 1\n1 0 0 2\n0 1 0 3\n3 0 1 2\n")},
      {"b.ply", written("b.ply")},
      {"a.stl", solid},
      {"b.stl", written("b.stl")},
      {"a.obj", obj},
      {"a.vtk", legacy("POLYGONS 2 8\n3 0 1 2\n3 0 2 1\nLINES 1 3\n2 0 1\nPOINT_DATA 3\nFIELD f 1\n"
                       "vtkGhostType 1 3 unsigned_char\n0 1 0\n")},
      {"b.vtk", legacy("CELLS 2 8\n3 0 1 2\n3 0 2 1\nCELL_TYPES 2\n5 5\n", "UNSTRUCTURED_GRID")},
      {"c.ply", asciiPly(kXyz + "property uchar red\nproperty uchar green\nproperty uchar blue\n",
                         "0 0 0 9 8 7\n1 0 0 1 2 3\n0 1 0 4 5 6\n3 0 1 2 0.1 0.2 0.3 1\n", "3",
                         "property list uchar int vertex_indices\nproperty float r\nproperty float "
                         "g\nproperty float b\nproperty float a\n")},
      {"c.obj", "v 0 0 0 1 0 0\nv 1 0 0 0 1 0 0.5\nv 0 1 0\nf 1 2 3\n"},
      {"c.off", "COFF\n3 2 0\n0 0 0 255 0 0\n1 0 0 0 255 0 255\n0 1 0 0 0 85\n3 0 1 2 0.5 1 0\n3 2 1 0 7\n"},
      {"c.vtk", legacy("POLYGONS 1 4\n3 0 1 2\nPOINT_DATA 3\nCOLOR_SCALARS c 3\n1 0 0 0 1 0 0 0 0.3\n")}};
  const QuietLog quiet;
  std::mt19937 random(3);
  size_t sound = 0, damaged = 0;
  for (const auto& [name, bytes] : whole)
    for (int i = 0; i < 200; ++i) {
      const std::string path = folder_ / name;
      writeText(path, mutated(bytes, random));
      try {
        const GeometryKind kind = likelyKind(summariseGeometry(path));
        const GeometryBlock block = readGeometry(path, kind).block;
        for (const auto& triangle : block.triangles)
          for (uint32_t point : triangle) ASSERT_LT(point, block.points.size()) << path;
        for (const glm::vec3& color : block.colors)
          for (int c = 0; c < 3; ++c) ASSERT_TRUE(color[c] >= 0 && color[c] <= 1) << path;
        EXPECT_NO_THROW(validate(block, kind));
        ++sound;
      } catch (const Error& e) {
        EXPECT_TRUE(std::string(e.what()).starts_with(path + ": ")) << e.what();
        ++damaged;
      }
    }
  EXPECT_GT(sound, 100u);
  EXPECT_GT(damaged, 400u);
}

}  // namespace
}  // namespace gxy

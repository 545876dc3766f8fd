// SPDX-License-Identifier: Apache-2.0
// gxydata and gxydiff as a user runs them: exit status and files.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <glm/geometric.hpp>

#include "core/image/image.h"
#include "core/io/file.h"
#include "core/io/geometry_file.h"
#include "core/io/volume_file.h"
#include "core/io/write_geometry.h"
#include "tests/support/mesh_files.h"
#include "tests/support/temporary_folder.h"

namespace gxy {
namespace {

class DataTools : public ::testing::Test {
 protected:
  std::string at(const std::string& name) const { return (folder_ / name).string(); }
  int run(const char* program, const std::string& arguments, const char* errors = "/dev/null") const {
    const std::string command =
        "cd " + folder_.string() + " && " + program + " " + arguments + " >/dev/null 2>" + errors;
    const int status = std::system(command.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  int data(const std::string& arguments) const { return run(GXYDATA, arguments); }
  /// What gxydata says on standard error.
  std::string saidBy(const std::string& arguments) const {
    run(GXYDATA, arguments, "said");
    return readText(at("said"));
  }
  /// What gxydiff says on standard output.
  std::string saidByDiff(const std::string& arguments) const {
    std::system(("cd " + folder_.string() + " && " + GXYDIFF + " " + arguments + " >said").c_str());
    return readText(at("said"));
  }
  int diff(const std::string& arguments) const { return run(GXYDIFF, arguments); }

  static std::vector<float> samples(const VolumeFile& file) {
    std::vector<float> values(size_t(wholeOf(file.grid).count()));
    readVolume(file, wholeOf(file.grid), std::as_writable_bytes(std::span(values)));
    return values;
  }
  const test::TemporaryFolder temporary_;
  const std::filesystem::path folder_ = temporary_.path();
};

TEST_F(DataTools, RadialFieldsAreTheDistancesTheyClaim) {
  ASSERT_EQ(data("radial -r 9,7,5 r.vti"), 0);
  const VolumeFile one = openVolume(at("r.vti"), "oneBall"), eight = openVolume(at("r.vti"), "eightBalls");
  EXPECT_EQ(one.grid.points, (Index3{9, 7, 5}));
  const auto a = samples(one), b = samples(eight);
  size_t n = 0;
  for (int k = 0; k < 5; ++k)
    for (int j = 0; j < 7; ++j)
      for (int i = 0; i < 9; ++i, ++n) {
        const double x = i / 4.0 - 1, y = j / 3.0 - 1, z = k / 2.0 - 1;
        ASSERT_NEAR(a[n], std::hypot(x, y, z), 1e-6);
        ASSERT_NEAR(b[n], std::hypot(std::abs(x) - 0.5, std::abs(y) - 0.5, std::abs(z) - 0.5), 1e-6);
      }
}

TEST_F(DataTools, MarschnerLobbIsItsFormula) {
  ASSERT_EQ(data("marschner-lobb m.vol"), 0);
  const VolumeFile file = openVolume(at("m.vol"));
  ASSERT_EQ(file.grid.points, (Index3{41, 41, 41}));
  const auto values = samples(file);
  const double pi = std::acos(-1.0), z = 7 / 20.0 - 1, r = std::hypot(3 / 20.0 - 1, 11 / 20.0 - 1);
  const double expected =
      (1 - std::sin(pi * z / 2) + 0.25 * (1 + std::cos(12 * pi * std::cos(pi * r / 2)))) / 2.5;
  EXPECT_NEAR(values[size_t((7 * 41 + 11) * 41 + 3)], expected, 1e-6);
}

TEST_F(DataTools, SeedsDecideAndStepsDiffer) {
  ASSERT_EQ(data("turbulence -r 12 --seed 3 a.vol"), 0);
  ASSERT_EQ(data("turbulence -r 12 --seed 3 b.json"), 0);
  ASSERT_EQ(data("turbulence -r 12 --seed 4 c.vol"), 0);
  ASSERT_EQ(data("turbulence -r 12 --seed 3 -t 2 t.vol"), 0);
  const auto a = samples(openVolume(at("a.vol")));
  EXPECT_EQ(a, samples(openVolume(at("b.json"))));
  EXPECT_NE(a, samples(openVolume(at("c.vol"))));
  EXPECT_EQ(a, samples(openVolume(at("t_0000.vol"))));
  EXPECT_NE(a, samples(openVolume(at("t_0001.vol"))));
}

TEST_F(DataTools, SparseIsMostlyExactZero) {
  ASSERT_EQ(data("sparse -r 40 s.vol"), 0);
  const auto values = samples(openVolume(at("s.vol")));
  const auto zeros = size_t(std::count(values.begin(), values.end(), 0.f));
  EXPECT_GT(zeros, values.size() * 3 / 4);
  EXPECT_LT(zeros, values.size());
}

TEST_F(DataTools, ConvertAndPartitionMoveNothing) {
  ASSERT_EQ(data("radial -r 20 r.vti"), 0);
  ASSERT_EQ(data("convert r.vti --array y r.json"), 0);
  ASSERT_EQ(data("partition r.vti -n 6 p.pvti"), 0);
  const VolumeFile original = openVolume(at("r.vti"), "y"), raw = openVolume(at("r.json")),
                   pieces = openVolume(at("p.pvti"), "y");
  EXPECT_EQ(original.grid, raw.grid);
  EXPECT_EQ(original.grid, pieces.grid);
  EXPECT_EQ(samples(original), samples(raw));
  EXPECT_EQ(samples(original), samples(pieces));
}

TEST_F(DataTools, RawSamplesAndSamplesOfCellsAreConverted) {
  ASSERT_EQ(data("radial -r 3,2,2 --array x r.vol"), 0);
  ASSERT_EQ(data("convert r.raw raw.vti --dimensions 3,2,2 --type float --spacing 1,2,3 --origin 5,6,7"), 0);
  EXPECT_EQ(openVolume(at("raw.vti")).grid, (Grid{{5, 6, 7}, {1, 2, 3}, {3, 2, 2}}));
  EXPECT_EQ(samples(openVolume(at("raw.vti"))), samples(openVolume(at("r.vol"))));
  EXPECT_EQ(data("convert r.raw raw.vti --dimensions 3,2,2 --type number"), 2);
  for (const char* wrong : {"1,2", "1,2,3x", "1,2,3,4", "x,2,3"})
    EXPECT_EQ(data(std::string("convert r.raw raw.vti --dimensions 3,2,2 --type float --spacing ") + wrong),
              2)
        << wrong;
  EXPECT_EQ(data("convert r.raw raw.vti --dimensions 3,2,3 --type float"), 1);

  writeText(at("c.vti"), R"(<VTKFile type="ImageData" version="1.0" byte_order="LittleEndian">
<ImageData WholeExtent="0 2 0 1 0 1" Origin="0 0 0" Spacing="1 1 1"><Piece Extent="0 2 0 1 0 1"><CellData>
<DataArray type="UInt8" Name="vtkGhostType" format="ascii">0 0</DataArray>
<DataArray type="Float32" Name="p" format="ascii">1 3</DataArray></CellData></Piece></ImageData></VTKFile>)");
  ASSERT_EQ(data("convert c.vti d.vti"), 0);
  const VolumeFile file = openVolume(at("d.vti"));
  EXPECT_EQ(file.arrays.size(), 1u) << "what says which are hidden is no array of its own";
  EXPECT_EQ(file.grid, openVolume(at("c.vti")).grid);
  EXPECT_EQ(samples(file), samples(openVolume(at("c.vti"))));
  EXPECT_EQ(data("convert c.vti d.vol"), 1) << "it has no place for samples of cells";
}

TEST_F(DataTools, AnUnknownEndingIsAnsweredByWhatCanBeRead) {
  writeText(at("x.foo"), "");
  const std::string said = saidBy("info x.foo");
  EXPECT_NE(said.find("expected volumes as .vti"), said.npos) << said;
  EXPECT_NE(said.find("geometry as .vtu"), said.npos) << said;
}

TEST_F(DataTools, AnUnknownCommandIsAnsweredByTheNearest) {
  EXPECT_EQ(data("convrt a.vti b.vti"), 2);
  const std::string said = saidBy("convrt a.vti b.vti");
  EXPECT_NE(said.find("unknown command \"convrt\"; did you mean `convert`?"), said.npos) << said;
}

TEST_F(DataTools, NothingThatIsReadIsOverwritten) {
  ASSERT_EQ(data("radial -r 8 --array x noise.vol"), 0);
  const auto before = samples(openVolume(at("noise.vol")));
  EXPECT_EQ(data("convert noise.vol noise.json"), 1);  // both have noise.raw
  EXPECT_EQ(data("convert noise.vol noise.vol"), 1);
  std::filesystem::create_hard_link(at("noise.raw"), at("other.raw"));
  EXPECT_EQ(data("convert noise.vol other.json"), 1);
  EXPECT_FALSE(std::filesystem::exists(at("noise.json")) || std::filesystem::exists(at("other.json")));
  EXPECT_EQ(samples(openVolume(at("noise.vol"))), before);

  ASSERT_EQ(data("partition noise.vol -n 2 pp.pvti"), 0);
  EXPECT_EQ(data("partition pp.pvti -n 4 pp.pvti"), 1);
  EXPECT_EQ(data("convert pp.pvti pp_1.vti"), 1);
  EXPECT_EQ(samples(openVolume(at("pp.pvti"))), before);

  ASSERT_EQ(data("sphere-mesh -r 8 s.vtp"), 0);
  ASSERT_EQ(data("partition s.vtp -n 4 q.pvtp"), 0);
  EXPECT_EQ(data("partition q.pvtp -n 2 q.pvtp"), 1);
  EXPECT_EQ(data("convert q.pvtp q_1.vtp"), 1);
  EXPECT_EQ(data("convert q.pvtp q.vtp"), 0);
  EXPECT_EQ(summariseGeometry(at("q.vtp")).triangles, 2u * 16 * 7);
}

TEST_F(DataTools, PiecesWithoutCellsDoNotDecideTheKind) {
  ASSERT_EQ(data("sphere-mesh -r 16 s.vtp"), 0);
  ASSERT_EQ(data("partition s.vtp -g 6,6,6 q.pvtp"), 0);
  ASSERT_EQ(summariseGeometry(at("q_0.vtp")).triangles, 0u);  // a corner of the box
  ASSERT_EQ(data("convert q.pvtp back.vtp"), 0);
  EXPECT_EQ(summariseGeometry(at("back.vtp")).triangles, 2u * 32 * 15);
  writeText(at("none.pvtu"), "<VTKFile type=\"PUnstructuredGrid\"><PUnstructuredGrid/></VTKFile>");
  EXPECT_EQ(data("convert none.pvtu none.vtu"), 1);
}

TEST_F(DataTools, ConvertSaysWhatIsLost) {
  ASSERT_EQ(data("radial -r 4 r.vti"), 0);
  EXPECT_EQ(saidBy("convert r.vti all.vti"), "");
  EXPECT_EQ(saidBy("convert r.vti --array x x.vol"), "");
  const std::string said = saidBy("convert r.vti one.json");
  EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 4);
  EXPECT_NE(said.find("gxydata: r.vti: array 'eightBalls' is left out\n"), std::string::npos) << said;

  writeText(at("g.vtk"), R"(# vtk DataFile Version 3.0
two arrays
ASCII
DATASET POLYDATA
POINTS 3 double
0 0 0 1 0 0 0 1 0
POLYGONS 1 4
3 0 1 2
POINT_DATA 3
SCALARS s double 1
LOOKUP_TABLE default
1 2 3
VECTORS v float
1 0 0 0 1 0 0 0 1
)");
  for (const char* out : {"g.vtp", "g.vtu"}) {
    EXPECT_EQ(saidBy(std::string("convert g.vtk ") + out), "");
    const GeometrySummary summary = summariseGeometry(at(out));
    ASSERT_EQ(summary.arrays.size(), 2u) << out;
    EXPECT_EQ(summary.arrays[0].name + " " + summary.arrays[0].type, "s double");
    EXPECT_EQ(summary.arrays[1].name + " " + summary.arrays[1].type, "v float");
    EXPECT_EQ(summary.arrays[1].components, 3);
    EXPECT_EQ(summary.triangles, 1u);
    EXPECT_EQ(readGeometry(at(out), GeometryKind::Triangles).block.values, (std::vector<float>{1, 2, 3}));
  }
  EXPECT_EQ(saidBy("convert g.vtk g.ply"),
            "gxydata: g.vtk: array 's' is rounded from double to float\n"
            "gxydata: g.vtk: array 'v' is left out\n");
  EXPECT_EQ(saidBy("convert g.vtk --array v v.vtp"),
            "gxydata: g.vtk: array 'v' becomes the magnitude of its 3 components\n");
  EXPECT_EQ(saidBy("convert v.vtp v2.vtu"), "");
}

TEST_F(DataTools, ConvertKeepsAllCells) {
  writeText(at("mixed.vtk"), R"(# vtk DataFile Version 3.0
a point, a line, two triangles and a strip
ASCII
DATASET POLYDATA
POINTS 5 float
0 0 0 1 0 0 0 1 0 1 1 0 2 2 1
VERTICES 1 2
1 4
LINES 1 4
3 0 1 4
POLYGONS 2 8
3 0 1 2
3 1 3 2
TRIANGLE_STRIPS 1 5
4 0 1 2 3
CELL_DATA 5
SCALARS number int 1
LOOKUP_TABLE default
10 11 12 13 14
)");
  for (const char* out : {"mixed.vtp", "mixed.vtu"}) {
    EXPECT_EQ(saidBy(std::string("convert mixed.vtk ") + out), "");
    const GeometrySummary summary = summariseGeometry(at(out));
    EXPECT_EQ(summary.vertices, 1u) << out;
    EXPECT_EQ(summary.segments, 2u) << out;
    EXPECT_EQ(summary.triangles, 4u) << out;
    ASSERT_EQ(summary.arrays.size(), 1u);
    EXPECT_EQ(summary.arrays[0].type, "int");
    for (const auto& [kind, values] : {std::pair(GeometryKind::PathLines, std::vector<float>{11, 11, 11}),
                                       {GeometryKind::Triangles, {12, 12, 12, 13, 13, 13, 14, 14, 14, 14}}})
      EXPECT_EQ(readGeometry(at(out), kind).block.values, values) << out;
  }
  writeText(at("cube.vtk"), R"(# vtk DataFile Version 3.0
a hexahedron
ASCII
DATASET UNSTRUCTURED_GRID
POINTS 8 float
0 0 0 1 0 0 1 1 0 0 1 0 0 0 1 1 0 1 1 1 1 0 1 1
CELLS 1 9
8 0 1 2 3 4 5 6 7
CELL_TYPES 1
12
)");
  ASSERT_EQ(data("info cube.vtk | tee said"), 0);
  EXPECT_NE(readText(at("said")).find("\ncells       hexahedra (1)\n"), std::string::npos)
      << readText(at("said"));
  EXPECT_EQ(saidBy("convert cube.vtk cube.vtu"), "");
  EXPECT_EQ(summariseGeometry(at("cube.vtu")).solids, 1u);
  EXPECT_EQ(saidBy("convert cube.vtk cube.vtp"),
            "gxydata: cube.vtk: of solid cells only the outer surface is kept\n");
  EXPECT_EQ(summariseGeometry(at("cube.vtp")).triangles, 12u);
}

// A hexahedron beside two wedges that cut the face between them, and apart from these an inverted tetrahedron, the same again, a duplicate, a
// triangle, and a tetrahedron of which a point has no value and another lies in a face of the hexahedron.
TEST_F(DataTools, MakesCellsOfBothKinds) {
  ASSERT_EQ(data("turbulence -r 5,4,3 --cells tetrahedra --displacement 0.1 t.vtu"), 0);
  ASSERT_EQ(data("info t.vtu | tee said"), 0);
  const std::string tetrahedra = readText(at("said"));
  EXPECT_NE(tetrahedra.find("  points               60\n  tetrahedra           144\n"), std::string::npos)
      << tetrahedra;
  EXPECT_EQ(tetrahedra.find("inverted"), std::string::npos) << tetrahedra;
  ASSERT_EQ(data("marschner-lobb -r 4 --displacement 0.2 h.vtu"), 0);
  ASSERT_EQ(data("info h.vtu | tee said"), 0);
  const std::string hexahedra = readText(at("said"));
  EXPECT_NE(hexahedra.find("  points               64\n  hexahedra            27\n"), std::string::npos)
      << hexahedra;
  ASSERT_EQ(data("scene h.vtu | tee said"), 0);
  EXPECT_NE(readText(at("said")).find("\"type\": \"Triangles\""), std::string::npos) << "the outer surface";
  ASSERT_EQ(data("scene h.vtu --iso 0.5 | tee said"), 0);
  EXPECT_NE(readText(at("said")).find("\"type\": \"Volume\""), std::string::npos) << "what is inside";
  EXPECT_EQ(data("turbulence --cells tetrahedra n.vol"), 1);
  EXPECT_NE(saidBy("turbulence --cells tetrahedra n.vol").find("expected a .vtu"), std::string::npos);
  EXPECT_EQ(data("turbulence -r 5,1,5 n.vtu"), 1);
  EXPECT_EQ(data("turbulence --cells cubes n.vtu"), 2);
}

TEST_F(DataTools, InfoTellsWhatAnImportFindsInAMesh) {
  test::GridFile grid;
  for (const double x : {0, 1, 2})
    for (const auto& [y, z] : {std::pair(0, 0), {1, 0}, {1, 1}, {0, 1}}) grid.points.emplace_back(x, y, z);
  for (const auto& p :
       {glm::dvec3(5, 0, 0), glm::dvec3(6, 0, 0), glm::dvec3(5, 1, 0), glm::dvec3(5, 0, 1),
        glm::dvec3(0, 0.5, 0.5), glm::dvec3(-1, 0, 0), glm::dvec3(-1, 1, 0), glm::dvec3(-1, 0, 1)})
    grid.points.push_back(p);
  grid.cells = {{12, {0, 4, 5, 1, 3, 7, 6, 2}},
                {13, {4, 5, 6, 8, 9, 10}},
                {13, {4, 6, 7, 8, 10, 11}},
                {10, {12, 14, 13, 15}},
                {10, {12, 14, 13, 15}},
                {10, {12, 13, 14, 15}},
                {5, {12, 13, 14}},
                {10, {17, 19, 18, 16}}};
  grid.pointArrays.push_back({"heat", "Float32", 1, std::vector<double>(grid.points.size(), 1)});
  grid.pointArrays[0].values[17] = double(NAN);
  grid.cellArrays.push_back({"vtkGhostType", "UInt8", 1, {0, 0, 0, 0, 0, 1, 0, 0}});
  writeText(at("flawed.vtu"), grid.vtu());
  ASSERT_EQ(data("info flawed.vtu | tee said"), 0);
  const std::string said = readText(at("said"));
  EXPECT_NE(said.find("\nas a volume flawed:heat, values of points\n"
                      "  points               20\n"
                      "  tetrahedra           2\n"
                      "  wedges               2\n"
                      "  hexahedra            1\n"
                      "  flat cells           1\n"
                      "  ghost cells          1\n"
                      "  repeated cells       1\n"),
            std::string::npos)
      << said;
  for (const char* line : {"\n  inverted cells       ", "\n  hanging points       1\n",
                           "\n  split faces          2\n", "\n  points without data  1\n"})
    EXPECT_NE(said.find(line), std::string::npos) << line << said;
  grid.cells.push_back({25, std::vector<uint32_t>(20, 0)});
  grid.cellArrays.clear();
  writeText(at("curved.vtu"), grid.vtu());
  ASSERT_EQ(data("info curved.vtu | tee said"), 0);
  EXPECT_NE(readText(at("said"))
                .find("\nas a volume not possible: curved.vtu: it has cells that an unstructured "
                      "volume cannot have yet: quadratic hexahedra (1)"),
            std::string::npos)
      << readText(at("said"));
}

TEST_F(DataTools, ColoursAreKept) {
  writeText(at("c.ply"), R"(ply
format ascii 1.0
element vertex 4
property float x
property float y
property float z
property uchar red
property uchar green
property uchar blue
property uchar alpha
element face 2
property list uchar int vertex_indices
end_header
0 0 0 255 0 0 255
1 0 0 0 255 0 255
0 1 0 0 0 51 255
1 1 0 0 0 0 255
3 0 1 2
3 1 3 2
)");
  const std::vector<glm::vec3> colors{{1, 0, 0}, {0, 1, 0}, {0, 0, 0.2f}, {0, 0, 0}};
  EXPECT_EQ(saidBy("convert c.ply c.vtp"), "");
  EXPECT_EQ(saidBy("convert c.vtp c.vtu"), "");
  EXPECT_EQ(saidBy("convert c.vtu back.ply"), "gxydata: c.vtu: the opacity in array 'RGB' is left out\n");
  ASSERT_EQ(data("partition back.ply -g 2,1,1 c.pvtp"), 0);
  ASSERT_EQ(data("convert c.pvtp joined.vtp"), 0);
  for (const char* name : {"c.ply", "c.vtp", "c.vtu", "back.ply", "joined.vtp"}) {
    const GeometryBlock block = readGeometry(at(name), GeometryKind::Triangles).block;
    ASSERT_EQ(block.triangles.size(), 2u) << name;
    ASSERT_EQ(block.colors.size(), block.points.size()) << name;
    for (size_t i = 0; i < block.points.size(); i++)
      EXPECT_EQ(block.colors[i], colors[size_t(block.points[i].x + 2 * block.points[i].y)]) << name;
  }
  EXPECT_NE(readText(at("c_0.vtp")).find("type=\"UInt8\" Name=\"RGB\""), std::string::npos);
  EXPECT_EQ(saidBy("convert c.ply c.stl"),
            "gxydata: c.ply: coordinates are rounded to float\ngxydata: c.ply: array 'RGB' is left out\n");
  ASSERT_EQ(data("info c.vtp | tee said"), 0);
  EXPECT_NE(readText(at("said")).find("point array 'RGB': unsigned char, 4 components, colours 0 to 255"),
            std::string::npos);
}

TEST_F(DataTools, GeometryKindsHoldWhatTheyClaim) {
  ASSERT_EQ(data("particles -r 500 p.vtp"), 0);
  ASSERT_EQ(data("sphere-mesh -r 16 m.vtp"), 0);
  ASSERT_EQ(data("helix -r 3 h.vtu"), 0);
  EXPECT_EQ(summariseGeometry(at("p.vtp")).points, 500u);
  ASSERT_EQ(data("particles -r 5,4,3 q.vtp"), 0);
  EXPECT_EQ(summariseGeometry(at("q.vtp")).points, 60u);
  EXPECT_EQ(summariseGeometry(at("h.vtu")).segments, 3u * 256);
  const GeometryBlock mesh = readGeometry(at("m.vtp"), GeometryKind::Triangles).block;
  ASSERT_EQ(mesh.triangles.size(), 2u * 32 * 15);
  for (const auto& t :
       mesh.triangles) {  // on the unit sphere, normals outwards, corners counter-clockwise from outside
    const glm::dvec3 a = mesh.points[t[0]], b = mesh.points[t[1]], c = mesh.points[t[2]];
    EXPECT_NEAR(glm::length(a), 1, 1e-12);
    EXPECT_NEAR(glm::length(a - glm::dvec3(mesh.normals[t[0]])), 0, 1e-4);
    EXPECT_GT(glm::dot(glm::cross(b - a, c - a), a + b + c), 0);
  }
}

TEST_F(DataTools, ExitStatusTellsUsageFromFailure) {
  EXPECT_EQ(data("--help"), 0);
  EXPECT_EQ(data(""), 2);
  EXPECT_EQ(data("nonsense x.vti"), 2);
  EXPECT_EQ(data("radial -r 0 x.vti"), 2);
  EXPECT_EQ(data("particles -r 5,4 x.vtp"), 2);
  EXPECT_EQ(data("particles -r 100000,100000,2 x.vtp"), 2);
  EXPECT_EQ(data("partition x.vti y.pvti"), 2);
  EXPECT_EQ(data("info missing.vti"), 1);
  EXPECT_EQ(data("radial x.txt"), 1);
}

TEST_F(DataTools, DiffAppliesItsLimits) {
  Image a{10, 10, LargeVector<float>(400, 0.5f)}, b = a;
  b.rgba[4 * 37] += 0.25f;
  writeImage(at("a.exr"), a);
  writeImage(at("b.exr"), b);
  writeImage(at("a.raw"), a);
  writeImage(at("c.exr"), {5, 20, a.rgba});
  EXPECT_EQ(diff("a.exr a.exr"), 0);
  EXPECT_EQ(diff("a.exr a.raw --size 10x10"), 0);
  EXPECT_EQ(diff("a.exr b.exr"), 1);
  EXPECT_EQ(diff("a.exr b.exr --max 0.26"), 0);
  EXPECT_EQ(diff("a.exr b.exr --max 0.24"), 1);
  EXPECT_EQ(diff("a.exr b.exr --fraction 0.01 --output d.png"), 0);
  EXPECT_EQ(diff("a.exr b.exr --max 0.25"), 0);  // which is what they differ by
  EXPECT_EQ(diff("a.exr b.exr --fraction 0.00999"), 1);
  EXPECT_EQ(diff("a.exr c.exr"), 1);
  writeImage(at("tall.exr"), {10, 20, LargeVector<float>(800, 0.5f)});
  writeImage(at("wide.exr"), {20, 10, LargeVector<float>(800, 0.5f)});
  EXPECT_EQ(saidByDiff("a.exr tall.exr"), "different: 10 x 10 and 10 x 20 pixels\n");
  EXPECT_EQ(saidByDiff("wide.exr a.exr"), "different: 20 x 10 and 10 x 10 pixels\n");
  EXPECT_EQ(diff("a.exr tall.exr"), 1);
  EXPECT_EQ(diff("a.exr missing.exr"), 2);
  EXPECT_EQ(diff("a.exr"), 2);
  EXPECT_EQ(diff("a.raw a.raw"), 2);
  EXPECT_EQ(diff("a.raw a.raw --size 10"), 2);
  EXPECT_EQ(saidByDiff("a.exr b.exr --max 0.001"),
            "different: max 0.25 (63.75/255), rms 0.0144338, pixels over 0.001: 1 %\n");
  Image opaque = a;
  for (size_t i = 3; i < opaque.rgba.size(); i += 4) opaque.rgba[i] = 1;
  writeImage(at("opaque.exr"), opaque);
  EXPECT_EQ(diff("a.exr opaque.exr"), 0);
  EXPECT_EQ(diff("a.exr opaque.exr --alpha"), 1);
  Image nothing = a;
  nothing.rgba[4 * 37] = NAN;
  writeImage(at("nan.raw"), nothing);
  EXPECT_EQ(diff("nan.raw nan.raw --size 10x10"), 0);
  EXPECT_EQ(diff("a.raw nan.raw --size 10x10 --max 1e30"), 1) << "as far as can be";
  const Image d = readImage(at("d.png"));
  EXPECT_EQ(d.rgba[4 * 37], 1.f);
  EXPECT_EQ(d.rgba[0], 0.f);
}

}  // namespace
}  // namespace gxy

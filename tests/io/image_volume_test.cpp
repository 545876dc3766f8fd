// SPDX-License-Identifier: Apache-2.0
// Images whose samples are cells', hidden, turned, or in one layer, and legacy files, written here byte by byte.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/io/file.h"
#include "core/io/import_volume.h"
#include "core/io/write_volume.h"
#include "tests/io/fixtures.h"

namespace gxy {
namespace {

using testing::TemporaryFolder;

std::vector<double> valuesIn(const VolumeFile& file, const Extent& extent) {
  std::vector<std::byte> bytes(size_t(extent.count()) * file.bytesPerPoint());
  readVolume(file, extent, bytes);
  std::vector<double> values;
  withType(file.array.type, [&](auto value) {
    for (size_t at = 0; at < bytes.size(); at += sizeof value) {
      std::memcpy(&value, &bytes[at], sizeof value);
      values.push_back(static_cast<double>(value));
    }
  });
  return values;
}
std::vector<double> valuesOf(const VolumeFile& file) { return valuesIn(file, wholeOf(file.grid)); }

class ImageVolume : public ::testing::Test {
 protected:
  /// A .vti of one piece of text: attributes of the image beside its extent, and what is in its piece.
  std::string vti(const std::string& extent, const std::string& attributes, const std::string& data) const {
    const std::string path = folder_ / "v.vti";
    writeText(
        path,
        "<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\"><ImageData WholeExtent=\"" +
            extent + "\" " + attributes + "><Piece Extent=\"" + extent + "\">" + data +
            "</Piece></ImageData></VTKFile>");
    return path;
  }
  static std::string array(const std::string& name, const std::string& type, const std::string& numbers) {
    return "<DataArray type=\"" + type + "\" Name=\"" + name + "\" format=\"ascii\">" + numbers +
           "</DataArray>";
  }
  static std::string points(const std::string& arrays) { return "<PointData>" + arrays + "</PointData>"; }
  static std::string cells(const std::string& arrays) { return "<CellData>" + arrays + "</CellData>"; }

  std::string vtk(const std::string& text) const {
    writeText(folder_ / "v.vtk", text);
    return folder_ / "v.vtk";
  }
  std::string errorOf(const std::string& path, const std::string& wanted = {}) const {
    try {
      openVolume(path, wanted);
    } catch (const Error& e) {
      EXPECT_TRUE(std::string(e.what()).starts_with(path)) << e.what();
      return std::string(e.what()).substr(path.size());
    }
    ADD_FAILURE() << "no error";
    return {};
  }

  const TemporaryFolder folder_;
};

using Values = std::vector<double>;

TEST_F(ImageVolume, CellsBecomeTheirCentresWithALayerRepeatedOutside) {
  const VolumeFile file = openVolume(
      vti("0 2 0 1 0 1", "Origin=\"10 0 0\" Spacing=\"2 1 1\"", cells(array("p", "UInt8", "1 3"))));
  EXPECT_TRUE(file.array.ofCells);
  EXPECT_EQ(file.grid.points, (Index3{4, 3, 3}));
  EXPECT_EQ(file.grid.origin, glm::dvec3(9, -0.5, -0.5)) << "the centres stand at 11 and 13";
  EXPECT_EQ(file.grid.box(), (Box{{10, 0, 0}, {14, 1, 1}})) << "what there is ends with the cells";
  const Values row{1, 1, 3, 3};
  Values all;
  for (int i = 0; i < 9; ++i) all.insert(all.end(), row.begin(), row.end());
  EXPECT_EQ(valuesOf(file), all);
  EXPECT_EQ(valuesIn(file, {{2, 1, 1}, {2, 1, 1}}), (Values{3, 3}));
}

TEST_F(ImageVolume, OneArrayIsChosenAmongThoseOfPointsAndCells) {
  const std::string path = vti("0 1 0 1 0 1", "Origin=\"0 0 0\" Spacing=\"1 1 1\"",
                               cells(array("p", "UInt8", "9") + array("c", "UInt8", "7")) +
                                   points(array("p", "UInt8", "0 1 2 3 4 5 6 7")));
  EXPECT_FALSE(openVolume(path).array.ofCells);
  EXPECT_FALSE(openVolume(path, "p").array.ofCells) << "points come first";
  const VolumeFile file = openVolume(path, "c");
  EXPECT_EQ(valuesOf(file), Values(27, 7));
  EXPECT_EQ(file.arrays.size(), 3u);
  EXPECT_EQ(errorOf(path, "q"), ": no array 'q'; the file has 'p', 'p', 'c'");
}

TEST_F(ImageVolume, CellsOfPiecesMakeOneVolume) {
  for (const auto& [name, extent, value] :
       {std::tuple{"a.vti", "0 1 0 1 0 1", "1"}, {"b.vti", "1 2 0 1 0 1", "3"}}) {
    vti(extent, "Origin=\"0 0 0\" Spacing=\"1 1 1\"", cells(array("p", "Float32", value)));
    std::filesystem::rename(folder_ / "v.vti", folder_ / name);
  }
  writeText(folder_ / "v.pvti", R"(<VTKFile type="PImageData" version="1.0" byte_order="LittleEndian">
<PImageData WholeExtent="0 2 0 1 0 1" Origin="0 0 0" Spacing="1 1 1"><PCellData><PDataArray type="Float32" Name="p"/></PCellData>
<Piece Extent="0 1 0 1 0 1" Source="a.vti"/><Piece Extent="1 2 0 1 0 1" Source="b.vti"/></PImageData></VTKFile>)");
  const VolumeFile file = openVolume(folder_ / "v.pvti");
  EXPECT_EQ(valuesIn(file, {{0, 1, 1}, {4, 1, 1}}), (Values{1, 1, 3, 3}));
}

TEST_F(ImageVolume, AnImportOfCellsKeepsTheirRangeAndCutsAnywhere) {
  const std::string path =
      vti("0 4 0 3 0 2", "Origin=\"0 0 0\" Spacing=\"1 1 1\"",
          cells(array("p", "Float32", "0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23")));
  const Grid grid = openVolume(path).grid;
  for (const int parts : {1, 2, 4}) {
    SingleRank one;
    const auto volume = importVolume(path, "", decomposed(grid, parts, 1), kGhostLayers, one);
    EXPECT_EQ(volume->ranges[0], (Range{0, 23}));
    EXPECT_TRUE(volume->grid.rim);
  }
}

// As VTK numbers them: 2 hides a point, 32 a cell. Type 1 (another piece has it, too) hides nothing.
TEST_F(ImageVolume, HiddenPointsAreNoData) {
  const VolumeFile file = openVolume(vti(
      "0 1 0 1 0 1", "Origin=\"0 0 0\" Spacing=\"1 1 1\"",
      points(array("vtkGhostType", "UInt8", "0 2 0 0 1 0 0 0") + array("p", "Int16", "0 1 2 3 4 5 6 7"))));
  EXPECT_EQ(file.array.name, "p") << "what says which are hidden is not shown";
  EXPECT_EQ(file.arrays.size(), 1u);
  EXPECT_EQ(file.array.type, ScalarType::Float32);
  const Values values = valuesOf(file);
  for (size_t i = 0; i < 8; ++i)
    if (i == 1)
      EXPECT_TRUE(std::isnan(values[i]));
    else
      EXPECT_EQ(values[i], double(i));
  EXPECT_EQ(errorOf(vti("0 1 0 1 0 1", "", points(array("vtkGhostType", "UInt8", "0 2 0 0 1 0 0 0")))),
            ": there is no numeric array of points or cells");
}

TEST_F(ImageVolume, PointsThatOnlyHiddenCellsTouchAreNoData) {
  const VolumeFile file =
      openVolume(vti("0 3 0 1 0 1", "Origin=\"0 0 0\" Spacing=\"1 1 1\"",
                     cells(array("vtkGhostType", "UInt8", "0 32 32")) +
                         points(array("p", "Float64", "0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15"))));
  const Values values = valuesOf(file);
  for (size_t i = 0; i < 16; ++i) EXPECT_EQ(std::isnan(values[i]), i % 4 >= 2) << i;
  EXPECT_EQ(valuesIn(file, {{1, 1, 1}, {1, 1, 1}}), Values{13});
}

TEST_F(ImageVolume, HiddenCellsAndCellsWithAHiddenCornerAreNoData) {
  const std::string p = array("p", "Int32", "5 6 7");
  const auto middle = [&](const std::string& ghosts) {
    return valuesIn(openVolume(vti("0 3 0 1 0 1", "Origin=\"0 0 0\" Spacing=\"1 1 1\"", ghosts)),
                    {{1, 1, 1}, {3, 1, 1}});
  };
  Values values = middle(cells(array("vtkGhostType", "UInt8", "0 32 1") + p));
  EXPECT_EQ(values[0], 5);
  EXPECT_TRUE(std::isnan(values[1]));
  EXPECT_EQ(values[2], 7);
  values = middle(points(array("vtkGhostType", "UInt8", "0 0 0 0 0 0 0 0 0 0 0 2 0 0 0 0")) + cells(p));
  EXPECT_EQ(values[1], 6);
  EXPECT_TRUE(std::isnan(values[2])) << "its corner is the last point of a row";
}

// 2 x 3 x 2 points, the value of each 100 i + 10 j + k.
std::string numbered() {
  std::string text;
  for (int k = 0; k < 2; ++k)
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i < 2; ++i) text += std::to_string(100 * i + 10 * j + k) + " ";
  return text;
}

TEST_F(ImageVolume, AxesThatAreTurnedArePutRight) {
  const auto open = [&](const std::string& direction) {
    return openVolume(vti("1 2 0 2 0 1", "Origin=\"5 6 7\" Spacing=\"1 2 3\" Direction=\"" + direction + "\"",
                          points(array("p", "Int16", numbered()))));
  };
  // by the definition: point (i, j, k) of the file lies at origin + direction * (spacing * (i + 1, j, k))
  for (const std::string direction :
       {"1 6e-17 0 -6e-17 1 0 0 0 1", "-1 0 0 0 -1 0 0 0 1", "0 1 0 1 0 0 0 0 1", "0 0 -1 1 0 0 0 1 0"}) {
    double d[9];
    std::stringstream text(direction);
    for (double& x : d) text >> x;
    const VolumeFile file = open(direction);
    const Values values = valuesOf(file);
    for (int k = 0; k < 2; ++k)
      for (int j = 0; j < 3; ++j)
        for (int i = 0; i < 2; ++i) {
          const double at[3] = {1.0 * (i + 1), 2.0 * j, 3.0 * k};
          int64_t index[3];
          for (int w = 0; w < 3; ++w) {
            const double place = (w == 0   ? 5
                                  : w == 1 ? 6
                                           : 7) +
                                 d[3 * w] * at[0] + d[3 * w + 1] * at[1] + d[3 * w + 2] * at[2];
            index[w] = std::llround((place - file.grid.origin[w]) / file.grid.spacing[w]);
            EXPECT_NEAR(file.grid.origin[w] + file.grid.spacing[w] * double(index[w]), place, 1e-12);
          }
          const Index3& n = file.grid.points;
          EXPECT_EQ(values[size_t((index[2] * n[1] + index[1]) * n[0] + index[0])], 100 * i + 10 * j + k)
              << direction;
        }
  }
  EXPECT_EQ(open("1 0 0 0 1 0 0 0 1").grid.origin, glm::dvec3(6, 6, 7));
}

TEST_F(ImageVolume, RotatedAxesAreTurnedToTheNearestAboutTheCentre) {
  const auto open = [&](const std::string& direction) {
    return openVolume(vti("0 1 0 2 0 1", "Origin=\"5 6 7\" Spacing=\"1 2 3\" Direction=\"" + direction + "\"",
                          points(array("p", "Int16", numbered()))));
  };
  // by 36.87 degrees about z; the same of an image that is mirrored; and of one whose axes are in another order
  for (const auto& [rotated, nearest] : {std::pair("0.8 -0.6 0 0.6 0.8 0 0 0 1", "1 0 0 0 1 0 0 0 1"),
                                         {"-0.8 -0.6 0 -0.6 0.8 0 0 0 1", "-1 0 0 0 1 0 0 0 1"},
                                         {"0.6 -0.8 0 0.8 0.6 0 0 0 1", "0 -1 0 1 0 0 0 0 1"},
                                         {"0 0.8 -0.6 0 0.6 0.8 1 0 0", "0 1 0 0 0 1 1 0 0"}}) {
    const VolumeFile file = open(rotated);
    const Values values = valuesOf(file);
    const VolumeFile straight = open(nearest);  // in the same place
    EXPECT_EQ(values, valuesOf(straight)) << rotated;
    EXPECT_EQ(file.grid.points, straight.grid.points);
    EXPECT_EQ(file.grid.spacing, straight.grid.spacing);
    double d[9];
    std::stringstream text(rotated);
    for (double& x : d) text >> x;
    const glm::dvec3 half(0.5, 2, 1.5);  // spacing times half the image, along its axes
    const glm::dvec3 middle = 0.5 * (file.grid.box().lo + file.grid.box().hi);
    for (int w = 0; w < 3; ++w)
      EXPECT_NEAR(middle[w], 5 + w + d[3 * w] * half[0] + d[3 * w + 1] * half[1] + d[3 * w + 2] * half[2],
                  1e-12);
    ASSERT_EQ(file.warnings.size(), 1u);
    EXPECT_NE(file.warnings[0].find(": the image is rotated by 36.9 degrees against the nearest axes"),
              std::string::npos)
        << file.warnings[0];
    EXPECT_TRUE(straight.warnings.empty());
  }
  const std::string path =
      vti("0 1 0 2 0 1", "Direction=\"1 0.3 0 0 1 0 0 0 1\"", points(array("p", "Int16", numbered())));
  EXPECT_EQ(errorOf(path), ": the axes of the image, expected to be at right angles, are not");
  EXPECT_EQ(
      errorOf(vti("0 1 0 2 0 1", "Direction=\"1 1 0 1 0 0 0 0 1\"", points(array("p", "Int16", numbered())))),
      ": the axes of the image, expected to be at right angles, are not");
}

TEST_F(ImageVolume, OneLayerIsTwoEqualOnesAroundIt) {
  const VolumeFile file = openVolume(vti("0 2 0 1 4 4", "Origin=\"0 0 0\" Spacing=\"1 1 0.5\"",
                                         points(array("p", "Float32", "0 1 2 10 11 12"))));
  EXPECT_EQ(file.grid.points, (Index3{3, 2, 2}));
  EXPECT_EQ(file.grid.box(), (Box{{0, 0, 1.75}, {2, 1, 2.25}})) << "the image is at z = 2";
  EXPECT_EQ(valuesOf(file), (Values{0, 1, 2, 10, 11, 12, 0, 1, 2, 10, 11, 12}));
  const VolumeFile ofCells = openVolume(
      vti("0 2 0 1 4 4", "Origin=\"0 0 0\" Spacing=\"1 1 0.5\"", cells(array("p", "Float32", "1 3"))));
  EXPECT_EQ(ofCells.grid.box(), (Box{{0, 0, 1.75}, {2, 1, 2.25}}));
}

TEST_F(ImageVolume, LegacyFilesAreReadWhereverTheirArraysStand) {
  const std::string head = "# vtk DataFile Version 3.0\nSTRUCTURED_POINTS CELL_DATA\n";
  const std::string text =
      head +
      "ascii\ndataset structured_points\nDIMENSIONS 3 2 2\norigin 1 2 3\naspect_ratio 1 1 2\n"
      "FIELD FieldData 1\nTIME 1 1 double\n0.5\n"
      "CELL_DATA 2\nSCALARS c short\nLOOKUP_TABLE default\n1 3\n"
      "point_data 12\nVECTORS v%20w float\n";
  std::string vectors, scalars;
  for (int i = 0; i < 12; ++i) {
    vectors += std::to_string(i) + " 0 0\n";
    scalars += std::to_string(i) + " ";
  }
  const std::string path =
      vtk(text + vectors + "METADATA\nINFORMATION 0\n\nscalars s double 1\nlookup_table mine\n" + scalars +
          "\nLOOKUP_TABLE mine 2\n0 0 0 1 1 1 1 1\nFIELD F 1\nf 1 12 int\n" + scalars);
  const VolumeFile file = openVolume(path);
  EXPECT_EQ(file.array.name, "s") << "the scalars that are active";
  EXPECT_EQ(file.grid, (Grid{{1, 2, 3}, {1, 1, 2}, {3, 2, 2}}));
  Values counted(12);
  for (size_t i = 0; i < 12; ++i) counted[i] = double(i);
  EXPECT_EQ(valuesOf(file), counted);
  EXPECT_EQ(valuesOf(openVolume(path, "f")), counted);
  EXPECT_EQ(openVolume(path, "v w").array.components, 3);
  EXPECT_EQ(valuesIn(openVolume(path, "c"), {{0, 1, 1}, {4, 1, 1}}), (Values{1, 1, 3, 3}));
  // binary: most significant byte first, from the line's end on
  using namespace std::string_literals;
  const std::string binary =
      vtk(head +
          "BINARY\nDATASET STRUCTURED_POINTS\nEXTENT 2 3 0 1 -1 0\nSPACING 1 1 1\nORIGIN 0 0 0\n"
          "POINT_DATA 8\nSCALARS s unsigned_short\nLOOKUP_TABLE default\n" +
          "\x01\x00\x00\x01\x00\x02\x00\x03\x00\x04\x00\x05\x00\x06\x00\x07"s + "\n");
  EXPECT_EQ(valuesOf(openVolume(binary)), (Values{256, 1, 2, 3, 4, 5, 6, 7}));
  EXPECT_EQ(openVolume(binary).grid.origin, glm::dvec3(2, 0, -1)) << "where the extent begins";
}

TEST_F(ImageVolume, LegacyFilesThatEndOrSaySomethingElseAreErrors) {
  const std::string head =
      "# vtk DataFile Version 3.0\nt\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 2 2 2\n";
  for (const auto& [rest, error] :
       {std::pair{"POINT_DATA 7\n", "arrays of 7 points, expected 8"},
        {"POINT_DATA 8\nNOTHING v\n", "found \"NOTHING\", expected a kind of array"},
        {"POINT_DATA 8\nSCALARS s float\nLOOKUP_TABLE default\n0 1 2 3",
         "the file ends, expected 4 more numbers"},
        {"POINT_DATA 8\nSCALARS s float 1 0\n", "found \"1 0\", expected a number of components"},
        {"ORIGIN 0 zero 0\n", "found \"zero\", expected a number"}}) {
    const std::string said = errorOf(vtk(head + rest));
    EXPECT_NE(said.find(error), said.npos) << said;
  }
  std::mt19937 random(8);
  const std::string sound =
      readText(vtk(head + "POINT_DATA 8\nSCALARS s float\nLOOKUP_TABLE default\n0 1 2 3 4 5 6 7\n"));
  int errors = 0;
  for (int i = 0; i < 500; ++i) try {
      valuesIn(openVolume(vtk(testing::mutated(sound, random))), {{0, 0, 0}, {1, 1, 1}});
    } catch (const Error&) {
      ++errors;
    }
  EXPECT_GT(errors, 100);
}

}  // namespace
}  // namespace gxy

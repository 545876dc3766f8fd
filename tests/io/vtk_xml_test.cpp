// SPDX-License-Identifier: Apache-2.0
// VTK's XML files whose arrays are compressed: sound ones are read whatever the compressor and the encoding, and what a
// file states is told, or refused, before VTK's reader takes memory for it.
#include "core/io/vtk_xml.h"

#include <gtest/gtest.h>
#include <vtkBitArray.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkDoubleArray.h>
#include <vtkFloatArray.h>
#include <vtkImageData.h>
#include <vtkLZ4DataCompressor.h>
#include <vtkLZMADataCompressor.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataWriter.h>
#include <vtkStringArray.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLImageDataWriter.h>
#include <vtkXMLPolyDataWriter.h>
#include <vtkXMLUnstructuredGridWriter.h>
#include <vtkZLibDataCompressor.h>

#include <functional>
#include <map>
#include <numeric>

#include "core/comm/error.h"
#include "core/io/geometry_file.h"
#include "tests/io/fixtures.h"

namespace gxy {
namespace {

using testing::TemporaryFolder;

struct Form {
  vtkSmartPointer<vtkDataCompressor> compressor;
  int mode = vtkXMLWriter::Appended;
  bool base64 = false, wide = false, big = false;
};

std::vector<Form> allForms() {
  const auto lzma = vtkSmartPointer<vtkLZMADataCompressor>::New();
  lzma->SetCompressionLevel(1);  // higher ones take much memory for each block
  std::vector<Form> forms;
  for (const vtkSmartPointer<vtkDataCompressor>& compressor :
       {vtkSmartPointer<vtkDataCompressor>(vtkSmartPointer<vtkZLibDataCompressor>::New()),
        vtkSmartPointer<vtkDataCompressor>(vtkSmartPointer<vtkLZ4DataCompressor>::New()),
        vtkSmartPointer<vtkDataCompressor>(lzma)})
    for (const auto& [mode, base64] :
         {std::pair{vtkXMLWriter::Appended, false}, std::pair{vtkXMLWriter::Appended, true},
          std::pair{vtkXMLWriter::Binary, false}, std::pair{vtkXMLWriter::Ascii, false}})
      for (bool wide : {false, true})
        for (bool big : {false, true})
          if (compressor->IsA("vtkZLibDataCompressor") || (mode != vtkXMLWriter::Ascii && !big))
            forms.push_back({compressor, mode, base64, wide, big});
  return forms;
}

const Form kRaw{vtkSmartPointer<vtkZLibDataCompressor>::New(), vtkXMLWriter::Appended, false, true, false};

template <class Writer>
void write(const std::string& path, vtkDataObject* data, const Form& form) {
  const auto writer = vtkSmartPointer<Writer>::New();
  writer->SetFileName(path.c_str());
  writer->SetInputData(data);
  writer->SetCompressor(form.compressor);
  writer->SetDataMode(form.mode);
  writer->SetEncodeAppendedData(form.base64);
  writer->SetHeaderType(form.wide ? vtkXMLWriter::UInt64 : vtkXMLWriter::UInt32);
  if (form.big) writer->SetByteOrderToBigEndian();
  writer->SetBlockSize(256);
  ASSERT_EQ(writer->Write(), 1);
}

template <class Array>
void addArray(vtkFieldData* to, const char* name, vtkIdType size) {
  const auto array = vtkSmartPointer<Array>::New();
  array->SetName(name);
  array->SetNumberOfValues(size);
  for (vtkIdType i = 0; i < size; ++i) array->SetVariantValue(i, vtkVariant(int(i % 2)));
  to->AddArray(array);
}

constexpr vtkIdType kPoints = 100, kCells = kPoints - 2;

/// A strip of triangles over so many points, with arrays of all that readers may meet.
template <class Mesh>
vtkSmartPointer<Mesh> mesh() {
  const auto set = vtkSmartPointer<Mesh>::New();
  const auto points = vtkSmartPointer<vtkPoints>::New();
  for (vtkIdType i = 0; i < kPoints; ++i) points->InsertNextPoint(double(i / 2), double(i % 2), 0);
  set->SetPoints(points);
  const auto cells = vtkSmartPointer<vtkCellArray>::New();
  for (vtkIdType i = 0; i < kCells; ++i) {
    const vtkIdType corners[3] = {i, i + 1, i + 2};
    cells->InsertNextCell(3, corners);
  }
  if constexpr (std::is_same_v<Mesh, vtkPolyData>)
    set->SetPolys(cells);
  else
    set->SetCells(VTK_TRIANGLE, cells);
  addArray<vtkDoubleArray>(set->GetPointData(), "data", kPoints);
  addArray<vtkBitArray>(set->GetPointData(), "bits", kPoints);
  addArray<vtkStringArray>(set->GetPointData(), "names", kPoints);
  addArray<vtkFloatArray>(set->GetCellData(), "of cells", kCells);
  addArray<vtkFloatArray>(set->GetFieldData(), "of all", 7);
  addArray<vtkStringArray>(set->GetFieldData(), "title", 3);
  return set;
}

vtkSmartPointer<vtkImageData> image() {
  const auto set = vtkSmartPointer<vtkImageData>::New();
  set->SetDimensions(10, 10, 10);
  addArray<vtkFloatArray>(set->GetPointData(), "data", 1000);
  addArray<vtkStringArray>(set->GetFieldData(), "title", 3);
  return set;
}

class VtkXmlFile : public ::testing::Test {
 protected:
  std::string vtp(const Form& form = kRaw) const {
    write<vtkXMLPolyDataWriter>(folder_ / "g.vtp", mesh<vtkPolyData>(), form);
    return folder_ / "g.vtp";
  }
  std::string vtu(const Form& form = kRaw) const {
    write<vtkXMLUnstructuredGridWriter>(folder_ / "g.vtu", mesh<vtkUnstructuredGrid>(), form);
    return folder_ / "g.vtu";
  }
  std::string vti(const Form& form = kRaw) const {
    write<vtkXMLImageDataWriter>(folder_ / "v.vti", image(), form);
    return folder_ / "v.vti";
  }

  /// Replaces words of the header of an appended raw array: number of blocks, bytes of each, bytes of the
  /// last, of each when compressed.
  static void state(const std::string& path, const std::string& array, const std::vector<uint64_t>& header) {
    std::string text = readText(path);
    const size_t name = text.find("Name=\"" + array + "\""), offset = text.find("offset=\"", name) + 8;
    const size_t place = text.find('_', text.find("<AppendedData")) + 1 + std::stoul(text.substr(offset));
    text.replace(place, header.size() * 8, reinterpret_cast<const char*>(header.data()), header.size() * 8);
    writeText(path, text);
  }
  static void change(const std::string& path, const std::string& from, const std::string& to) {
    std::string text = readText(path);
    const size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    writeText(path, text.replace(at, from.size(), to));
  }

  /// The message of the Error without the path, before any memory was taken.
  static std::string errorOf(const std::string& path) {
    try {
      if (path.ends_with(".vti")) {
        openVolume(path);
      } else {
        readGeometry(path, GeometryKind::Triangles, {}, [](int64_t) { ADD_FAILURE() << "memory was taken"; });
      }
    } catch (const Error& e) {
      const std::string text = e.what();
      EXPECT_TRUE(text.starts_with(path + ": ")) << text;
      return text.substr(std::min(text.size(), path.size() + 2));
    }
    ADD_FAILURE() << "no error";
    return {};
  }

  /// What is asked for first, and is refused.
  static int64_t asked(const std::string& path) {
    int64_t bytes = -1;
    EXPECT_THROW(readGeometry(path, GeometryKind::Triangles, {},
                              [&](int64_t some) {
                                bytes = some;
                                throw Error("no");
                              }),
                 Error);
    return bytes;
  }

  const TemporaryFolder folder_;
  const testing::QuietLog quiet_;
};

TEST_F(VtkXmlFile, CompressedMeshesAreReadInEveryForm) {
  for (const Form& form : allForms())
    for (const std::string& path : {vtp(form), vtu(form)}) {
      const GeometryContent content = readGeometry(path, GeometryKind::Triangles);
      ASSERT_EQ(content.block.triangles.size(), size_t(kCells));
      EXPECT_EQ(content.block.triangles[kCells - 1],
                (std::array<uint32_t, 3>{kPoints - 3, kPoints - 2, kPoints - 1}));
      EXPECT_EQ(content.block.points[kPoints - 1], glm::dvec3(49, 1, 0));
      EXPECT_EQ(content.array, "data");
      EXPECT_EQ(content.block.values[kPoints - 1], 1);
      EXPECT_EQ(readGeometry(path, GeometryKind::Particles, "bits").block.values[3], 1);
    }
}

constexpr vtkIdType kMany = 100'001;  // in several blocks of every form

glm::dvec3 placeOf(vtkIdType i) { return {double(i) * 0.25, double(i % 977), -0.5 * double(i)}; }
double valueOf(vtkIdType i) { return double(i % 1021) + 0.5; }

vtkSmartPointer<vtkPolyData> manyPoints() {
  const auto points = vtkSmartPointer<vtkPoints>::New();
  const auto data = vtkSmartPointer<vtkDoubleArray>::New();
  data->SetName("data");
  for (vtkIdType i = 0; i < kMany; ++i) {
    points->InsertNextPoint(&placeOf(i)[0]);
    data->InsertNextValue(valueOf(i));
  }
  const auto set = vtkSmartPointer<vtkPolyData>::New();
  set->SetPoints(points);
  set->GetPointData()->SetScalars(data);
  return set;
}

void writeMany(const std::string& path, int mode, bool base64, bool compressed, bool big) {
  const auto writer = vtkSmartPointer<vtkXMLPolyDataWriter>::New();
  writer->SetFileName(path.c_str());
  writer->SetInputData(manyPoints());
  writer->SetDataMode(mode);
  writer->SetEncodeAppendedData(base64);
  compressed ? writer->SetCompressorTypeToZLib() : writer->SetCompressorTypeToNone();
  if (big) writer->SetByteOrderToBigEndian();
  ASSERT_EQ(writer->Write(), 1);
}

void expectMany(const std::string& path, const std::string& how) {
  const GeometryBlock block = readGeometry(path, GeometryKind::Particles).block;
  ASSERT_EQ(block.points.size(), size_t(kMany));
  for (vtkIdType i = 0; i < kMany; ++i) {
    ASSERT_EQ(block.points[size_t(i)], placeOf(i)) << i << " " << how;
    ASSERT_EQ(block.values[size_t(i)], float(valueOf(i))) << i << " " << how;
  }
}

TEST_F(VtkXmlFile, ManyPointsAreReadInEveryForm) {
  const std::string path = folder_ / "many.vtp";
  for (const auto& [mode, base64] :
       {std::pair{vtkXMLWriter::Ascii, false}, std::pair{vtkXMLWriter::Binary, false},
        std::pair{vtkXMLWriter::Appended, true}, std::pair{vtkXMLWriter::Appended, false}})
    for (const bool compressed : {false, true})
      for (const bool big : {false, true}) {
        writeMany(path, mode, base64, compressed, big);
        expectMany(path, std::to_string(mode) + (base64 ? " base64" : "") +
                             (compressed ? " compressed" : "") + (big ? " big" : ""));
      }
}

// VTK itself writes no such lines.
TEST_F(VtkXmlFile, Base64InLinesIsReadUnlessItIsCompressed) {
  const std::string path = folder_ / "lines.vtp";
  for (const bool compressed : {false, true}) {
    writeMany(path, vtkXMLWriter::Binary, false, compressed, false);
    std::string lines;
    size_t inLine = 0;
    for (const char c : readText(path)) {
      const bool isDigit = std::isalnum(uint8_t(c)) != 0 || c == '+' || c == '/' || c == '=';
      inLine = isDigit ? inLine + 1 : 0;
      if (inLine > 76) lines += '\n', inLine = 1;
      lines += c;
    }
    writeText(path, lines);
    if (!compressed) {
      expectMany(path, "lines");
      continue;
    }
    EXPECT_THROW(readGeometry(path, GeometryKind::Particles), Error);
  }
}

TEST_F(VtkXmlFile, PiecesThatHaveAnArrayAsFloatsAndAsIntegersAreAnError) {
  const std::string path = folder_ / "two.vtp";
  const auto piece = [](const char* type, const char* values) {
    return std::string("<Piece NumberOfPoints=\"2\"><PointData Scalars=\"a\"><DataArray type=\"") + type +
           "\" Name=\"a\" format=\"ascii\">" + values +
           "</DataArray></PointData><Points><DataArray type=\"Float32\" NumberOfComponents=\"3\" "
           "format=\"ascii\">0 0 0 1 1 1</DataArray></Points></Piece>";
  };
  const auto write = [&](const char* second) {
    writeText(path, "<?xml version=\"1.0\"?><VTKFile type=\"PolyData\" version=\"1.0\"><PolyData>" +
                        piece("Float32", "1 2.5") + piece(second, "3 4") + "</PolyData></VTKFile>");
  };
  write("Float32");
  EXPECT_EQ(readGeometry(path, GeometryKind::Particles).block.values, (std::vector<float>{1, 2.5f, 3, 4}));
  write("Int32");
  try {
    readGeometry(path, GeometryKind::Particles);
    ADD_FAILURE() << "no error";
  } catch (const Error& e) {
    EXPECT_EQ(
        std::string(e.what()),
        path + ": array 'a' is of type int32 in one piece and of another one in another, expected one type");
  }
}

TEST_F(VtkXmlFile, CompressedImagesAreReadInEveryForm) {
  for (const Form& form : allForms()) {
    const VolumeFile file = openVolume(vti(form));
    std::vector<float> samples(1000);
    readVolume(file, wholeOf(file.grid), std::as_writable_bytes(std::span(samples)));
    for (size_t i = 0; i < samples.size(); ++i) ASSERT_EQ(samples[i], float(i % 2)) << i;
  }
}

TEST_F(VtkXmlFile, ArraysAreToldBeforeTheyAreReadThenTheirBlock) {
  // points, data, ids and ends of cells, all in 8 bytes but for the points; not bits and data of cells, which nothing shows
  const int64_t arrays = kPoints * 12 + kPoints * 8 + kCells * 3 * 8 + kCells * 8;
  const int64_t block = kPoints * (24 + 12 + 4) + kCells * (12 + 8);
  using Told = std::vector<int64_t>;
  for (const auto& [path, more] : {std::pair{vtp(), kCells * 8}, std::pair{vtu(), kCells}}) {
    Told told;
    readGeometry(path, GeometryKind::Triangles, {}, [&](int64_t bytes) { told.push_back(bytes); });
    ASSERT_EQ(told.size(), 2u);
    EXPECT_EQ(told[0], std::max<int64_t>(arrays + more, int64_t(std::filesystem::file_size(path)))) << path;
    EXPECT_EQ(told[1], block) << path;
    Told summary;  // for which all arrays are read
    summariseGeometry(path, [&](int64_t bytes) { summary.push_back(bytes); });
    ASSERT_EQ(summary.size(), 1u) << path;
    EXPECT_GE(summary[0], arrays) << path;
    EXPECT_THROW(summariseGeometry(path, [](int64_t) { throw Error("no memory"); }), Error);
  }
}

TEST_F(VtkXmlFile, OnlyArraysThatGeometryIsMadeOfAreReadAndTheyAreThoseThatAreTakenWhereAllAreRead) {
  using Attributes = vtkDataSetAttributes::AttributeTypes;
  struct Case {
    std::vector<std::pair<std::string, int>> arrays;  ///< name, components
    std::map<Attributes, const char*> active;
    std::string wanted, taken;  ///< values
    uint64_t leftOut;
  };
  for (const Case& c : {
           Case{{{"a", 1}, {"b", 1}, {"data", 1}, {"d", 3}}, {}, "", "data", 4},
           Case{{{"a", 1}, {"b", 1}, {"d", 3}}, {}, "", "a", 3},
           Case{{{"Normals", 3}, {"d", 3}, {"b", 1}}, {}, "", "d", 2},
           Case{{{"Normals", 1}, {"b", 1}}, {}, "", "Normals", 2},
           Case{{{"n", 3}, {"b", 1}, {"data", 1}}, {{Attributes::NORMALS, "n"}}, "b", "b", 2},
           Case{{{"t", 2}, {"b", 1}}, {{Attributes::TCOORDS, "t"}}, "", "b", 2},
           Case{{{"a", 1}, {"b", 1}, {"data", 1}}, {{Attributes::SCALARS, "b"}}, "", "b", 3},
           Case{{{"a", 1}, {"vtkGhostType", 1}, {"b", 1}}, {}, "b", "b", 2},
           Case{{{"vtkGhostType", 1}}, {}, "", "of cells", 0},
           Case{{{"Normals_", 3}}, {}, "Normals_", "Normals_", 1},
       }) {
    const auto set = mesh<vtkPolyData>();
    for (const char* name : {"data", "bits", "names"}) set->GetPointData()->RemoveArray(name);
    for (const auto& [name, components] : c.arrays) {
      const bool ghosts = name == vtkDataSetAttributes::GhostArrayName();
      vtkSmartPointer<vtkDataArray> array;
      if (ghosts)
        array = vtkSmartPointer<vtkUnsignedCharArray>::New();
      else
        array = vtkSmartPointer<vtkFloatArray>::New();
      array->SetName(name.c_str());
      array->SetNumberOfComponents(components);
      array->SetNumberOfTuples(kPoints);
      for (vtkIdType i = 0; i < kPoints * components; ++i)
        array->SetComponent(i / components, int(i % components), ghosts ? 0 : double(i + name.back()));
      set->GetPointData()->AddArray(array);
    }
    for (const auto& [attribute, name] : c.active) set->GetPointData()->SetActiveAttribute(name, attribute);
    write<vtkXMLPolyDataWriter>(folder_ / "g.vtp", set, kRaw);
    const auto legacy = vtkSmartPointer<vtkPolyDataWriter>::New();
    legacy->SetFileName((folder_ / "g.vtk").c_str());
    legacy->SetInputData(set);
    legacy->SetFileTypeToBinary();
    ASSERT_EQ(legacy->Write(), 1);
    const GeometryContent some = readGeometry(folder_ / "g.vtp", GeometryKind::Triangles, c.wanted),
                          all = readGeometry(folder_ / "g.vtk", GeometryKind::Triangles, c.wanted);
    EXPECT_EQ(some.array, c.taken);
    EXPECT_EQ(some.array, all.array);
    EXPECT_EQ(some.block, all.block) << c.taken;
    EXPECT_EQ(some.leftOut.arrays, c.leftOut) << c.taken;
    EXPECT_EQ(all.leftOut.arrays, 0u);
  }
  write<vtkXMLPolyDataWriter>(folder_ / "g.vtp", mesh<vtkPolyData>(), kRaw);
  EXPECT_EQ(readGeometry(folder_ / "g.vtp", GeometryKind::Particles).leftOut.bytes,
            (kPoints + 7) / 8 + kCells * 4);
}

TEST_F(VtkXmlFile, SmallFilesThatStateMuchAreRefusedBeforeTheyAreRead) {
  // 24 GB of zeros in some kilobytes: the header is what it should be
  std::string path = vtp();
  change(path, "NumberOfPoints=\"100\"", "NumberOfPoints=\"2000000000\"");
  state(path, "Points", {1, 24000000000, 0});
  state(path, "data", {1, 16000000000, 0});
  EXPECT_GT(asked(path), 40000000000);
  path = vtu();
  state(path, "connectivity", {1, 24000000000, 0});
  EXPECT_GT(asked(path), 24000000000);
}

TEST_F(VtkXmlFile, HeadersOfBlocksMustComeToWhatTheArraysState) {
  const std::string expected = " bytes when it is decompressed, expected ";
  for (const uint64_t size : {uint64_t(2000000000), uint64_t(1) << 40}) {
    const auto error = [&](const std::string& path, const std::string& array, int64_t bytes) {
      state(path, array, {1, size, 0});
      EXPECT_EQ(errorOf(path),
                "array '" + array + "' has " + std::to_string(size) + expected + std::to_string(bytes));
    };
    error(vtp(), "Points", kPoints * 12);
    error(vtp(), "data", kPoints * 8);
    error(vtu(), "offsets", kCells * 8);
    error(vtu(), "types", kCells);
    error(vti(), "data", 4000);
  }
  const std::string path = vti();
  state(path, "data", {16, 256, 0});  // one of them too many, as the last is not full
  EXPECT_EQ(errorOf(path), "array 'data' has 4096" + expected + "4000");
}

TEST_F(VtkXmlFile, ArraysThatNothingShowsAreNotLookedAt) {
  const GeometryBlock sound = readGeometry(vtp(), GeometryKind::Triangles).block;
  const std::string path = vtp();
  for (const char* array : {"bits", "of cells"}) state(path, array, {1, uint64_t(1) << 40, 0});
  EXPECT_EQ(readGeometry(path, GeometryKind::Triangles).block, sound);
  EXPECT_THROW(summariseGeometry(path), Error);
}

TEST_F(VtkXmlFile, HeadersOfBlocksThatCannotBeFollowedAreErrors) {
  const auto error = [&](const std::string& array, const std::vector<uint64_t>& header) {
    const std::string path = vtu();
    state(path, array, header);
    return errorOf(path);
  };
  for (const char* array : {"Points", "connectivity"}) {
    const std::string begin = "array '" + std::string(array) + "' is compressed in ";
    EXPECT_EQ(error(array, {uint64_t(1) << 60, 1, 0}),
              begin + "1152921504606846976 blocks, whose sizes the file cannot hold");
    const std::string least = ", expected 64 or more, and no more in the last";
    EXPECT_EQ(error(array, {2, 0, 100}), begin + "2 blocks of 0 bytes, the last of 100" + least);
    EXPECT_EQ(error(array, {2, 64, 1136}), begin + "2 blocks of 64 bytes, the last of 1136" + least);
    EXPECT_EQ(error(array, {100, 12, 12}), begin + "100 blocks of 12 bytes, the last of 12" + least);
    EXPECT_EQ(error(array, {3, ~uint64_t(0), 0}), begin + "3 blocks of 18446744073709551615 bytes: too many");
  }
  EXPECT_EQ(error("Points", {5, 256, 176, 100, uint64_t(1) << 40}),
            "array 'Points' is compressed to 1099511627776 bytes in block 1, more than the file has");
  // VTK reads the headers of arrays without entries as well.
  const std::string path = vtu();
  change(path, "NumberOfCells=\"98\"", "NumberOfCells=\"0\"");
  try {
    summariseGeometry(path);
    ADD_FAILURE() << "no error";
  } catch (const Error& e) {
    EXPECT_EQ(e.what(), path + ": array 'of cells' has 392 bytes when it is decompressed, expected 0");
  }
}

TEST_F(VtkXmlFile, HeadersAreFoundInEveryForm) {
  for (const Form& form : allForms()) {
    if (form.mode == vtkXMLWriter::Ascii) continue;
    const std::string path = vti(form);
    const VtkXml xml(path, "ImageData");
    vtkXMLDataElement* array = xml.data()
                                   ->FindNestedElementWithName("Piece")
                                   ->FindNestedElementWithName("PointData")
                                   ->FindNestedElementWithName("DataArray");
    EXPECT_EQ(xml.dataBytes(array), 4000);
    EXPECT_NO_THROW(xml.checkCompressed(array, 4000));
    EXPECT_THROW(xml.checkCompressed(array, 3996), Error);
    change(path, "WholeExtent=\"0 9 ", "WholeExtent=\"0 8 ");
    change(path, "Extent=\"0 9 0 9 0 9\"", "Extent=\"0 8 0 9 0 9\"");
    EXPECT_EQ(errorOf(path), "array 'data' has 4000 bytes when it is decompressed, expected 3600");
  }
}

TEST_F(VtkXmlFile, TheSecondOfTwoListsOfArraysIsCheckedToo) {
  const std::string path = vti();
  const std::string text = readText(path);
  const size_t begin = text.find("<PointData"), end = text.find("</PointData>") + 12;
  std::string list = text.substr(begin, end - begin);
  list.replace(list.find("offset=\"") + 8, 1, "8");  // not where a header begins
  writeText(path, text.substr(0, end) + list + text.substr(end));
  EXPECT_EQ(errorOf(path).substr(0, 12), "array 'data'");
}

TEST_F(VtkXmlFile, AnOffsetMakesAnArrayAppendedWhateverItsFormat) {
  const std::string path = vti();
  change(path, "format=\"appended\"", "format=\"ascii\"");
  const VolumeFile file = openVolume(path);
  std::vector<float> samples(1000);
  readVolume(file, wholeOf(file.grid), std::as_writable_bytes(std::span(samples)));
  EXPECT_EQ(samples[999], 1);
  state(path, "data", {1, 2000000000, 0});
  EXPECT_EQ(errorOf(path), "array 'data' has 2000000000 bytes when it is decompressed, expected 4000");
}

TEST_F(VtkXmlFile, DamagedFilesGiveAResultOrAnError) {
  std::mt19937 random(5);
  const auto most = [](int64_t bytes) {
    if (bytes > 1 << 20) throw Error("too much");
  };
  size_t sound = 0, damaged = 0;
  for (const Form& form : {kRaw, Form{kRaw.compressor, vtkXMLWriter::Binary, false, false, false}})
    for (const std::string& path : {vtp(form), vtu(form), vti(form)}) {
      const std::string text = readText(path);
      for (int i = 0; i < 300; ++i) {
        writeText(path, testing::mutated(text, random));
        try {
          if (path.ends_with(".vti")) {
            const VolumeFile file = openVolume(path);
            std::vector<std::byte> point(file.bytesPerPoint());
            readVolume(file, {{0, 0, 0}, {1, 1, 1}}, point);
          } else {
            readGeometry(path, GeometryKind::Triangles, {}, most);
          }
          ++sound;
        } catch (const Error&) {
          ++damaged;
        }
      }
    }
  EXPECT_GT(sound, 100u);
  EXPECT_GT(damaged, 400u);
}

TEST_F(VtkXmlFile, FieldDataAreNotRead) {
  for (const std::string& path : {vtp(), vtu()}) {
    state(path, "of all", {uint64_t(1) << 60, 1, 0});
    EXPECT_EQ(readGeometry(path, GeometryKind::Triangles).block.triangles.size(), size_t(kCells));
  }
  const std::string path = vti();
  state(path, "title", {1, uint64_t(1) << 40, 0});
  const VolumeFile file = openVolume(path);
  std::vector<float> samples(1000);
  EXPECT_NO_THROW(readVolume(file, wholeOf(file.grid), std::as_writable_bytes(std::span(samples))));
}

TEST_F(VtkXmlFile, XmlOfManyOrDeepElementsIsAnError) {
  const auto times = [](int n, const std::string& text) {
    std::string all;
    for (int i = 0; i < n; ++i) all += text;
    return all;
  };
  const std::string begin = "<VTKFile type=\"ImageData\"><ImageData>", end = "</ImageData></VTKFile>";
  for (const std::string& inside : {times(70000, "<a/>"), times(10000, "<a>") + times(10000, "</a>")}) {
    writeText(folder_ / "x.vti", begin + inside + end);
    EXPECT_EQ(errorOf(folder_ / "x.vti"),
              "too many XML elements, expected at most 65536 and at most 64 in one another");
  }
}

TEST_F(VtkXmlFile, ArraysThatVtkWouldLookForInVainAreErrors) {
  std::string path = vtp();
  const std::string text = readText(path);
  const size_t begin = text.find("<DataArray", text.find("<CellData")), end = text.find("</CellData>");
  writeText(path, text.substr(0, end) + text.substr(begin, end - begin) + text.substr(end));
  EXPECT_EQ(errorOf(path), "array 'of cells' is there twice in one list");
  path = vtu();
  change(path, "type=\"Float32\" Name=\"of cells\"", "type=\"Float33\" Name=\"of cells\"");
  EXPECT_THROW(readGeometry(path, GeometryKind::Triangles), Error);
}

TEST_F(VtkXmlFile, PiecesOfLessThanNothingAreErrors) {
  const std::string path = vtp();
  change(path, "NumberOfPoints=\"100\"", "NumberOfPoints=\"-99\"");
  EXPECT_EQ(errorOf(path), "attribute NumberOfPoints of a <Piece>: expected a number, 0 or more");
}

}  // namespace
}  // namespace gxy

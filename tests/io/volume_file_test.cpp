// SPDX-License-Identifier: Apache-2.0
#include "core/io/volume_file.h"

#include <gtest/gtest.h>
#include <vtkDataArray.h>
#include <vtkImageData.h>
#include <vtkPointData.h>
#include <vtkSmartPointer.h>
#include <vtkStructuredPoints.h>
#include <vtkStructuredPointsWriter.h>
#include <vtkXMLImageDataWriter.h>

#include "core/comm/error.h"
#include "core/io/file.h"
#include "core/io/write_volume.h"
#include "tests/io/fixtures.h"

namespace gxy {
namespace {

using testing::pattern;
using testing::TemporaryFolder;

const Grid kSmallGrid{{-1, 0.5, 100}, {0.1, 0.2, 0.3}, {7, 6, 5}};

/// Random boxes of points inside a grid, the whole one first.
std::vector<Extent> someExtents(const Grid& grid, int count) {
  std::mt19937 random(3);
  std::vector<Extent> extents{wholeOf(grid)};
  while (int(extents.size()) < count) {
    Extent e;
    for (size_t a = 0; a < 3; ++a) {
      e.first[a] = int64_t(random() % uint64_t(grid.points[a]));
      e.points[a] = 1 + int64_t(random() % uint64_t(grid.points[a] - e.first[a]));
    }
    extents.push_back(e);
  }
  return extents;
}

/// Every sample of every box equals the one at its place in `whole`.
void expectBlocks(const VolumeFile& file, const std::vector<std::byte>& whole) {
  const size_t point = file.bytesPerPoint();
  for (const Extent& e : someExtents(file.grid, 60)) {
    std::vector<std::byte> got(size_t(e.count()) * point);
    readVolume(file, e, got);
    size_t at = 0;
    bool same = true;
    for (int64_t k = 0; k < e.points[2]; ++k)
      for (int64_t j = 0; j < e.points[1]; ++j)
        for (int64_t i = 0; i < e.points[0]; ++i, at += point) {
          const int64_t global =
              ((e.first[2] + k) * file.grid.points[1] + e.first[1] + j) * file.grid.points[0] + e.first[0] +
              i;
          same = same && std::memcmp(&got[at], &whole[size_t(global) * point], point) == 0;
        }
    EXPECT_TRUE(same) << file.path;
  }
}

void expectGrid(const Grid& got, const Grid& expected) {
  EXPECT_EQ(got.points, expected.points);
  for (int a = 0; a < 3; ++a) {
    EXPECT_NEAR(got.origin[a], expected.origin[a], 1e-14 * std::max(1.0, std::abs(expected.origin[a])));
    EXPECT_DOUBLE_EQ(got.spacing[a], expected.spacing[a]);
  }
}

int vtkTypeOf(ScalarType type) {
  switch (type) {
    case ScalarType::Int8:
      return VTK_SIGNED_CHAR;
    case ScalarType::UInt8:
      return VTK_UNSIGNED_CHAR;
    case ScalarType::Int16:
      return VTK_SHORT;
    case ScalarType::UInt16:
      return VTK_UNSIGNED_SHORT;
    case ScalarType::Int32:
      return VTK_INT;
    case ScalarType::UInt32:
      return VTK_UNSIGNED_INT;
    case ScalarType::Int64:
      return VTK_LONG_LONG;
    case ScalarType::UInt64:
      return VTK_UNSIGNED_LONG_LONG;
    case ScalarType::Float32:
      return VTK_FLOAT;
    case ScalarType::Float64:
      break;
  }
  return VTK_DOUBLE;
}

template <class Image>
vtkSmartPointer<Image> vtkImage(const Grid& grid, ScalarType type, int components,
                                const std::vector<std::byte>& samples) {
  const auto image = vtkSmartPointer<Image>::New();
  image->SetDimensions(int(grid.points[0]), int(grid.points[1]), int(grid.points[2]));
  image->SetOrigin(grid.origin.x, grid.origin.y, grid.origin.z);
  image->SetSpacing(grid.spacing.x, grid.spacing.y, grid.spacing.z);
  image->AllocateScalars(vtkTypeOf(type), components);
  image->GetPointData()->GetScalars()->SetName("field");
  std::memcpy(image->GetScalarPointer(), samples.data(), samples.size());
  return image;
}

TEST(VolumeFile, WhatIsWrittenIsReadByBlockInEveryFormatAndType) {
  const TemporaryFolder folder;
  for (int t = 0; t <= int(ScalarType::Float64); ++t)
    for (const char* extension : {".vti", ".vol", ".json"}) {
      const ScalarType type = ScalarType(t);
      const int components = std::string(extension) == ".vol" ? 1 : 2;
      const auto samples = pattern(wholeOf(kSmallGrid).count() * components, type);
      const std::string path = folder / (std::string("v") + extension);
      VolumeWriter(path, kSmallGrid, {{"field", type, components, {}}}).write(0, 0, samples);
      const VolumeFile file = openVolume(path);
      EXPECT_EQ(file.array.type, type);
      EXPECT_EQ(file.array.components, components);
      expectGrid(file.grid, kSmallGrid);
      expectBlocks(file, samples);
    }
}

TEST(VolumeFile, ImagesThatVtkWroteAreReadInEveryEncoding) {
  const TemporaryFolder folder;
  const auto samples = pattern(wholeOf(kSmallGrid).count() * 3, ScalarType::Float64);
  const auto image = vtkImage<vtkImageData>(kSmallGrid, ScalarType::Float64, 3, samples);
  for (int mode : {vtkXMLWriter::Ascii, vtkXMLWriter::Binary, vtkXMLWriter::Appended})
    for (bool compressed : {false, true})
      for (bool big : {false, true})
        for (bool base64 : {false, true}) {
          const auto writer = vtkSmartPointer<vtkXMLImageDataWriter>::New();
          const std::string path = folder / "v.vti";
          writer->SetFileName(path.c_str());
          writer->SetInputData(image);
          writer->SetDataMode(mode);
          writer->SetEncodeAppendedData(base64);
          if (!compressed) writer->SetCompressorTypeToNone();
          if (big) writer->SetByteOrderToBigEndian();
          ASSERT_EQ(writer->Write(), 1);
          const VolumeFile file = openVolume(path, "field");
          expectGrid(file.grid, kSmallGrid);
          expectBlocks(file, samples);
        }
}

TEST(VolumeFile, LegacyStructuredPointsAreReadInEveryType) {
  const TemporaryFolder folder;
  for (int t = 0; t <= int(ScalarType::Float64); ++t)
    for (bool binary : {false, true}) {  // binary legacy files are big-endian
      SCOPED_TRACE(std::string(nameOf(ScalarType(t))) + (binary ? ", binary" : ", text"));
      const auto samples = pattern(wholeOf(kSmallGrid).count(), ScalarType(t));
      const auto writer = vtkSmartPointer<vtkStructuredPointsWriter>::New();
      const std::string path = folder / "v.vtk";
      writer->SetFileName(path.c_str());
      writer->SetInputData(vtkImage<vtkStructuredPoints>(kSmallGrid, ScalarType(t), 1, samples));
      binary ? writer->SetFileTypeToBinary() : writer->SetFileTypeToASCII();
      ASSERT_EQ(writer->Write(), 1);
      const VolumeFile file = openVolume(path);
      EXPECT_EQ(file.array.type, ScalarType(t));
      EXPECT_EQ(file.grid.points, kSmallGrid.points);
      expectBlocks(file, samples);
    }
}

TEST(VolumeFile, LegacyKeywordsHaveNoCase) {
  const TemporaryFolder folder;
  writeText(folder / "v.vtk",
            "# vtk DataFile Version 3.0\nx\nascii\ndataset structured_points\ndimensions 2 2 2\n"
            "spacing 1 1 1\norigin 0 0 0\npoint_data 8\nscalars v float\nlookup_table default\n"
            "0 1 2 3 4 5 6 7\n");
  EXPECT_TRUE(isVolumeFile(folder / "v.vtk"));
  const VolumeFile file = openVolume(folder / "v.vtk");
  EXPECT_EQ(file.array.name, "v");
  std::vector<float> samples(8);
  readVolume(file, wholeOf(file.grid), std::as_writable_bytes(std::span(samples)));
  EXPECT_EQ(samples, (std::vector<float>{0, 1, 2, 3, 4, 5, 6, 7}));
}

TEST(VolumeFile, WordsInALegacyTitleDoNotTellTheType) {
  const TemporaryFolder folder;
  for (const auto& [title, type] : {std::pair("DATASET STRUCTURED_POINTS", "POLYDATA"),
                                    std::pair("DATASET POLYDATA", "STRUCTURED_POINTS")}) {
    writeText(folder / "v.vtk",
              std::string("# vtk DataFile Version 3.0\n") + title + "\nASCII\nDATASET " + type + "\n");
    EXPECT_EQ(isVolumeFile(folder / "v.vtk"), std::string(type) == "STRUCTURED_POINTS") << title;
  }
}

TEST(VolumeFile, BigEndianRawIsSwapped) {
  const TemporaryFolder folder;
  for (ScalarType type : {ScalarType::UInt8, ScalarType::Int16, ScalarType::Float32, ScalarType::Float64}) {
    const auto samples = pattern(wholeOf(kSmallGrid).count(), type);
    auto swapped = samples;
    swapBytes(swapped, bytesOf(type));
    const std::string path = folder / "v.json";
    VolumeWriter(path, kSmallGrid, {{"field", type, 1, {}}}).write(0, 0, swapped);
    std::string text = readText(path);
    text.replace(text.find("little"), 6, "big");
    writeText(path, text);
    expectBlocks(openVolume(path), samples);
  }
}

TEST(VolumeFile, PiecesMakeOneImage) {
  const TemporaryFolder folder;
  const auto samples = pattern(wholeOf(kSmallGrid).count(), ScalarType::Float32);
  const std::string whole = folder / "w.vti";
  VolumeWriter(whole, kSmallGrid, {{"field", ScalarType::Float32, 1, {}}}).write(0, 0, samples);
  std::vector<ImagePiece> pieces;
  for (const Extent& e :
       {Extent{{0, 0, 0}, {4, 6, 5}}, Extent{{3, 0, 0}, {4, 3, 5}}, Extent{{3, 2, 0}, {4, 4, 5}}}) {
    std::vector<std::byte> part(size_t(e.count()) * 4);
    readVolume(openVolume(whole), e, part);
    Grid grid = kSmallGrid;
    grid.points = e.points;
    for (int a = 0; a < 3; ++a) grid.origin[a] += grid.spacing[a] * double(e.first[size_t(a)]);
    const std::string name = "p" + std::to_string(pieces.size()) + ".vti";
    VolumeWriter(folder / name, grid, {{"field", ScalarType::Float32, 1, {}}}, e.first).write(0, 0, part);
    pieces.push_back({e, name});
  }
  const std::vector<ArrayInfo> arrays{{"field", ScalarType::Float32, 1, {}}};
  writePvti(folder / "v.pvti", kSmallGrid, arrays, pieces);
  const VolumeFile file = openVolume(folder / "v.pvti");
  expectGrid(file.grid, kSmallGrid);
  expectBlocks(file, samples);

  pieces.pop_back();
  writePvti(folder / "hole.pvti", kSmallGrid, arrays, pieces);
  std::vector<std::byte> out(samples.size());
  EXPECT_THROW(readVolume(openVolume(folder / "hole.pvti"), wholeOf(kSmallGrid), out), Error);
}

TEST(VolumeFile, ArraysAreChosenByNameElseTheActiveOne) {
  const TemporaryFolder folder;
  const std::string path = folder / "v.vti";
  VolumeWriter(path, kSmallGrid,
               {{"a", ScalarType::Float32, 1, {}}, {"b", ScalarType::UInt8, 1, Range{1, 2}}});
  EXPECT_EQ(openVolume(path).array.name, "a");
  EXPECT_EQ(openVolume(path, "b").array.type, ScalarType::UInt8);
  EXPECT_EQ(openVolume(path, "b").array.range, (Range{1, 2}));
  EXPECT_THROW(openVolume(path, "c"), Error);
}

TEST(VolumeFile, WrongSizesAreErrors) {
  const TemporaryFolder folder;
  const auto samples = pattern(wholeOf(kSmallGrid).count(), ScalarType::Float32);
  for (const char* name : {"v.vol", "v.json", "v.vti"}) {
    const std::string path = folder / name;
    VolumeWriter(path, kSmallGrid, {{"field", ScalarType::Float32, 1, {}}}).write(0, 0, samples);
    const std::string data = extensionOf(path) == ".vti" ? path : folder / "v.raw";
    const auto size = std::filesystem::file_size(data);
    std::filesystem::resize_file(data, size - 100);
    EXPECT_THROW(openVolume(path), Error) << name;
    if (data == path) continue;
    std::filesystem::resize_file(data, size + 1);
    EXPECT_THROW(openVolume(path), Error) << name;
  }
  EXPECT_THROW(openVolume(folder / "missing.vti"), Error);
  EXPECT_THROW(openVolume(folder / "v.txt"), Error);
}

TEST(VolumeFile, DamagedHeadersGiveAnErrorAndPrintNothing) {
  const TemporaryFolder folder;
  const std::string path = folder / "v.vti";
  VolumeWriter(path, kSmallGrid, {{"field", ScalarType::Float32, 1, {}}})
      .write(0, 0, pattern(wholeOf(kSmallGrid).count(), ScalarType::Float32));
  const std::string text = readText(path), header = text.substr(0, text.find('_')),
                    rest = text.substr(header.size());
  std::mt19937 random(11);
  int errors = 0;
  ::testing::internal::CaptureStderr();
  for (int i = 0; i < 500; ++i) {
    writeText(path, testing::mutated(header, random) + rest);
    try {
      const VolumeFile file = openVolume(path);
      std::vector<std::byte> point(file.bytesPerPoint());
      readVolume(file, {{0, 0, 0}, {1, 1, 1}}, point);
    } catch (const Error&) {
      ++errors;
    }
  }
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
  EXPECT_GT(errors, 100);
}

}  // namespace
}  // namespace gxy

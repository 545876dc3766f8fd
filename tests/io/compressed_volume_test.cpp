// SPDX-License-Identifier: Apache-2.0
// Encoded volumes: each block is decoded once an import, whatever it is cut into, and an import ends when it is told to.
#include <gtest/gtest.h>
#include <vtkDataCompressor.h>
#include <vtkFloatArray.h>
#include <vtkImageData.h>
#include <vtkLZ4DataCompressor.h>
#include <vtkLZMADataCompressor.h>
#include <vtkPointData.h>
#include <vtkSmartPointer.h>
#include <vtkXMLImageDataWriter.h>
#include <vtkZLibDataCompressor.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include "core/io/byte_stream.h"
#include "core/io/file.h"
#include "core/io/import_volume.h"
#include "core/io/write_volume.h"
#include "tests/io/fixtures.h"

namespace gxy {
namespace {

using testing::EndsAt;
using testing::TemporaryFolder;

constexpr int64_t kSide = 48;
const Grid kCube{{0, 0, 0}, {1, 1, 1}, {kSide, kSide, kSide}};

vtkSmartPointer<vtkDataCompressor> compressorOf(const std::string& name) {
  if (name == "lz4") return vtkSmartPointer<vtkLZ4DataCompressor>::New();
  if (name == "zlib") return vtkSmartPointer<vtkZLibDataCompressor>::New();
  const auto lzma = vtkSmartPointer<vtkLZMADataCompressor>::New();
  lzma->SetCompressionLevel(1);  // higher ones take much memory for each block
  return lzma;
}

float valueAt(int64_t i) { return float(i * 7919 % 1021); }

/// Sample number i is valueAt(i).
void writeCube(const std::string& path, const std::string& compressor, size_t block, bool base64) {
  const auto image = vtkSmartPointer<vtkImageData>::New();
  image->SetDimensions(kSide, kSide, kSide);
  const auto array = vtkSmartPointer<vtkFloatArray>::New();
  array->SetName("data");
  array->SetNumberOfValues(kSide * kSide * kSide);
  for (int64_t i = 0; i < kSide * kSide * kSide; ++i) array->SetValue(i, valueAt(i));
  image->GetPointData()->SetScalars(array);
  const auto writer = vtkSmartPointer<vtkXMLImageDataWriter>::New();
  writer->SetFileName(path.c_str());
  writer->SetInputData(image);
  writer->SetCompressor(compressorOf(compressor));
  writer->SetEncodeAppendedData(base64);
  writer->SetBlockSize(block);
  ASSERT_EQ(writer->Write(), 1);
}

TEST(CompressedVolume, EachBlockIsDecodedOnceAnImport) {
  const TemporaryFolder folder;
  const size_t whole = size_t(kSide * kSide * kSide) * 4;
  std::vector<float> expected(whole / 4);
  for (size_t i = 0; i < expected.size(); ++i) expected[i] = valueAt(int64_t(i));
  for (const char* compressor : {"zlib", "lz4", "lzma"})
    for (const bool base64 : {false, true})
      for (const size_t block : {whole, size_t(4096)}) {
        writeCube(folder / "v.vti", compressor, block, base64);
        SingleRank one;
        const VolumeFile file = openVolume(folder / "v.vti");
        const auto volume = importVolume(file, decomposed(kCube, 8, 1), kGhostLayers, one);
        EXPECT_EQ(file.decoded->blocks, whole / block) << compressor;
        EXPECT_EQ(file.decoded->bytes, whole);
        EXPECT_EQ(volume->blocks.size(), 8u);
        EXPECT_EQ(volume->ranges[0], (Range{0, 1020}));
        std::vector<float> samples(whole / 4);
        readVolume(file, wholeOf(kCube), std::as_writable_bytes(std::span(samples)));
        const auto differs = std::mismatch(samples.begin(), samples.end(), expected.begin()).first;
        ASSERT_EQ(differs - samples.begin(), int64_t(samples.size())) << compressor;
      }
}

TEST(CompressedVolume, BlocksThatARankDoesNotNeedAreNotDecoded) {
  const TemporaryFolder folder;
  writeCube(folder / "v.vti", "zlib", 4096, false);
  const VolumeFile file = openVolume(folder / "v.vti");
  const int64_t slice = kSide * kSide;
  std::vector<float> samples(static_cast<size_t>(slice));
  readVolume(file, {{0, 0, 40}, {kSide, kSide, 1}}, std::as_writable_bytes(std::span(samples)));
  EXPECT_EQ(samples[5], valueAt(40 * slice + 5));
  EXPECT_EQ(file.decoded->blocks, uint64_t(41 * slice * 4 - 1) / 4096 - uint64_t(40 * slice * 4) / 4096 + 1);
}

/// 32 MiB of zeros in one block, which takes some kilobytes of the disk.
std::string oneLargeBlock(const TemporaryFolder& folder) {
  const auto image = vtkSmartPointer<vtkImageData>::New();
  image->SetDimensions(256, 256, 128);
  image->AllocateScalars(VTK_FLOAT, 1);
  std::memset(image->GetScalarPointer(), 0, size_t(32) << 20);
  const auto writer = vtkSmartPointer<vtkXMLImageDataWriter>::New();
  const std::string path = folder / "large.vti";
  writer->SetFileName(path.c_str());
  writer->SetInputData(image);
  writer->SetBlockSize(size_t(32) << 20);
  EXPECT_EQ(writer->Write(), 1);
  return path;
}

TEST(CompressedVolume, LittleIsDecodedOnceAnImportIsToEnd) {
  const TemporaryFolder folder;
  const std::string path = oneLargeBlock(folder);
  for (const int asked : {1, 5, 20}) {
    const VolumeFile file = openVolume(path);
    EndsAt ends(asked);
    // the points of the first half are not wanted, but decoded
    const Partitioning cut = Partitioning::lattice(
        {std::vector<double>{0, 255}, std::vector<double>{0, 255}, std::vector<double>{0, 64, 127}}, 2);
    EXPECT_THROW(importVolume(file, cut, 0, ends), Error);
    EXPECT_EQ(ends.asked, asked) << "it goes on for nothing";
    EXPECT_LE(file.decoded->bytes, uint64_t(asked + 1) << 20);
    EXPECT_EQ(file.decoded->blocks, 1u);
  }
}

// Wide samples are read, looked through, converted and put into bricks: of 48 layers each.
TEST(CompressedVolume, AnImportEndsWhereverItIs) {
  const TemporaryFolder folder;
  VolumeWriter(folder / "v.json", kCube, {{"field", ScalarType::Float64, 1, {}}})
      .write(0, 0, std::vector<std::byte>(size_t(wholeOf(kCube).count()) * 8));
  const Partitioning cut = decomposed(kCube, 2, 1);
  EndsAt never(-1);
  importVolume(folder / "v.json", "", cut, kGhostLayers, never);
  EXPECT_GT(never.asked, 20);
  for (int asked = 1; asked <= never.asked; ++asked) {
    EndsAt ends(asked);
    EXPECT_THROW(importVolume(folder / "v.json", "", cut, kGhostLayers, ends), Error) << asked;
    EXPECT_EQ(ends.asked, asked);
  }
}

TEST(CompressedVolume, ReadingOfAnyFileEndsWhenItsWatchSaysSo) {
  const TemporaryFolder folder;
  writeText(folder / "f", "");
  std::filesystem::resize_file(folder / "f", uint64_t(64) << 20);
  int asked = 0;
  const ReadWatch watch([&] {
    if (++asked == 3) throw Error("enough");
  });
  EXPECT_THROW(readText(folder / "f"), Error);
  EXPECT_EQ(asked, 3);
  // XML, whose parser reads for itself
  std::string text = R"(<VTKFile type="ImageData" version="1.0" byte_order="LittleEndian">)";
  while (text.size() < size_t(6) << 20) text += "<!--" + std::string(4000, ' ') + "-->\n";
  writeText(folder / "v.vti", text);
  asked = 0;
  try {
    openVolume(folder / "v.vti");
    FAIL() << "it was read";
  } catch (const Error& e) {
    EXPECT_EQ(std::string(e.what()), "enough");
  }
  EXPECT_EQ(asked, 3);
}

TEST(CompressedVolume, TextMayEndWithANumberAndMayHoldNoNumber) {
  const TemporaryFolder folder;
  const std::string path = folder / "v.vti";
  const auto image = [&](const std::string& numbers) {
    writeText(path,
              R"(<VTKFile type="ImageData" version="1.0" byte_order="BigEndian">
<ImageData WholeExtent="0 1 0 1 0 1" Origin="0 0 0" Spacing="1 1 1"><Piece Extent="0 1 0 1 0 1"><PointData>
<DataArray type="Float32" Name="p" format="ascii">)" +
                  numbers + "</DataArray></PointData></Piece></ImageData></VTKFile>");
    std::vector<float> samples(8);
    const VolumeFile file = openVolume(path);
    readVolume(file, wholeOf(file.grid), std::as_writable_bytes(std::span(samples)));
    return samples;
  };
  const std::vector<float> samples = image("0 1e-60 -2.5\n3 4 +5 inf NaN");
  EXPECT_EQ(std::vector<float>(samples.begin(), samples.begin() + 6),
            (std::vector<float>{0, 0, -2.5, 3, 4, 5}));
  EXPECT_TRUE(std::isinf(samples[6]));
  EXPECT_TRUE(std::isnan(samples[7]));
  const auto errorOf = [&](const std::string& numbers) -> std::string {
    try {
      image(numbers);
    } catch (const Error& e) {
      return std::string(e.what()).substr(path.size() + 2);
    }
    return {};
  };
  EXPECT_EQ(errorOf("0 1 2 3 1.0-101 5 6 7"),
            "array 'p': found \"1.0-101\", expected a number of type float32");
  EXPECT_EQ(errorOf("0 1 2"), "array 'p': the samples end before point 3, expected 8");
}

/// A volume of text whose samples are many words of many lengths, here and there with much white space between them.
struct ManyNumbers {
  static constexpr Index3 kPoints{61, 59, 75};
  std::vector<std::string> words;
  std::vector<float> values;

  ManyNumbers() {
    for (int64_t i = 0; i < kPoints[0] * kPoints[1] * kPoints[2]; ++i) {
      char word[32];
      std::snprintf(word, sizeof word, "%.*g", int(i % 9) + 1, double(i % 5003) * 0.37 - 900);
      words.push_back(word);
      values.push_back(std::strtof(word, nullptr));
    }
  }
  /// Writes the words up to number `end` and returns what is read of them.
  std::vector<float> read(const std::string& path, size_t end) const {
    std::string text = R"(<VTKFile type="ImageData" version="1.0" byte_order="LittleEndian">
<ImageData WholeExtent="0 60 0 58 0 74" Origin="0 0 0" Spacing="1 1 1"><Piece Extent="0 60 0 58 0 74"><PointData>
<DataArray type="Float32" Name="p" format="ascii">)";
    for (size_t i = 0; i < end; ++i) {
      if (i > 0) text += i % 10 > 0 ? " " : "\n  ";
      if (i % 100'000 == 99'999) text += std::string(150'000, ' ');
      text += words[i];
    }
    writeText(path, text + "</DataArray></PointData></Piece></ImageData></VTKFile>");
    std::vector<float> samples(values.size());
    readVolume(openVolume(path), {{0, 0, 0}, kPoints}, std::as_writable_bytes(std::span(samples)));
    return samples;
  }
  std::string errorOf(const std::string& path, size_t end) const {
    try {
      read(path, end);
    } catch (const Error& e) {
      return std::string(e.what()).substr(path.size() + 2);
    }
    return {};
  }
};

TEST(CompressedVolume, NumbersOfTextAreTheSameWhereverItsBlocksBegin) {
  const TemporaryFolder folder;
  const ManyNumbers numbers;
  EXPECT_EQ(numbers.read(folder / "v.vti", numbers.words.size()), numbers.values);
}

TEST(CompressedVolume, OfWordsOfTextThatAreNoNumbersTheFirstIsTold) {
  const TemporaryFolder folder;
  const std::string path = folder / "v.vti";
  ManyNumbers numbers;
  const size_t count = numbers.words.size();
  ASSERT_GT(count, 4u * 65536);
  for (const size_t place : {count - 1, size_t(3 * 65536), size_t(65536), size_t(65535), size_t(0)}) {
    const std::string bad = "x" + std::to_string(place);
    numbers.words[place] = bad;  // others are behind it
    EXPECT_EQ(numbers.errorOf(path, count),
              "array 'p': found \"" + bad + "\", expected a number of type float32");
  }
}

TEST(CompressedVolume, WhereTextEndsTooEarlyTheFirstPointThatIsMissingIsTold) {
  const TemporaryFolder folder;
  const ManyNumbers numbers;
  for (const size_t end : {size_t(0), size_t(1), size_t(65535), size_t(65536), size_t(200'000)})
    EXPECT_EQ(numbers.errorOf(folder / "v.vti", end), "array 'p': the samples end before point " +
                                                          std::to_string(end) + ", expected " +
                                                          std::to_string(numbers.words.size()));
}

std::shared_ptr<const File> fileOf(const TemporaryFolder& folder, const std::string& bytes) {
  writeText(folder / "bytes", bytes);
  return std::make_shared<const File>(File::open(folder / "bytes"));
}

std::string decodedText(const TemporaryFolder& folder, const std::string& bytes, Compression compression) {
  const auto stream = decompressed(fileBytes(fileOf(folder, bytes), 0, 1 << 20), compression, "f");
  std::string text(100, '\0');
  text.resize(stream->read(std::as_writable_bytes(std::span(text))));
  return text;
}

// Examples after the description of the format: literals, a copy that overlaps itself, a long length, the last literals.
TEST(CompressedVolume, BlocksOfLz4AreDecodedAsTheFormatSays) {
  const TemporaryFolder folder;
  using namespace std::string_literals;
  EXPECT_EQ(decodedText(folder,
                        "\x30"
                        "abc"s,
                        Compression::Lz4),
            "abc");
  EXPECT_EQ(decodedText(folder,
                        "\x24"
                        "ab\x02\x00\x10z"s,
                        Compression::Lz4),
            "abababababz");
  EXPECT_EQ(decodedText(folder,
                        "\x1f"
                        "a\x01\x00\x05\x10z"s,
                        Compression::Lz4),
            std::string(25, 'a') + "z");
  EXPECT_EQ(decodedText(folder, "\xf0\x05"s + std::string(20, 'q'), Compression::Lz4), std::string(20, 'q'));
  for (const std::string& damaged : {"\x24"
                                     "ab\x03\x00\x10z"s,
                                     "\x24"
                                     "ab\x00\x00\x10z"s,
                                     "\x30"
                                     "ab"s,
                                     "\x24"
                                     "ab\x02"s})
    EXPECT_THROW(decodedText(folder, damaged, Compression::Lz4), Error);
  for (const Compression c : {Compression::Zlib, Compression::Lzma})
    EXPECT_THROW(decodedText(folder, "no", c), Error);
}

}  // namespace
}  // namespace gxy

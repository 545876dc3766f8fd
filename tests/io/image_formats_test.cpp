// SPDX-License-Identifier: Apache-2.0
// Headers and raw samples after the formats' public descriptions, composed here byte by byte.
#include <gtest/gtest.h>
#include <zlib.h>

#include <bit>
#include <cmath>

#include "core/io/file.h"
#include "core/io/import_volume.h"
#include "core/io/referenced_files.h"
#include "tests/io/fixtures.h"

namespace gxy {
namespace {

using namespace std::string_literals;
using testing::TemporaryFolder;

/// The bytes of values, least significant first, or last.
template <class T>
std::string bytesOf(const std::vector<T>& values, bool big = false) {
  std::string bytes(values.size() * sizeof(T), '\0');
  std::memcpy(bytes.data(), values.data(), bytes.size());
  if (big) swapBytes(std::as_writable_bytes(std::span(bytes)), sizeof(T));
  return bytes;
}

std::string gzipped(const std::string& bytes) {
  std::string out(bytes.size() + 1000, '\0');
  z_stream s{};
  deflateInit2(&s, 6, Z_DEFLATED, MAX_WBITS + 16, 8, Z_DEFAULT_STRATEGY);
  s.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  s.avail_in = uInt(bytes.size());
  s.next_out = reinterpret_cast<Bytef*>(out.data());
  s.avail_out = uInt(out.size());
  deflate(&s, Z_FINISH);
  out.resize(s.total_out);
  deflateEnd(&s);
  return out;
}

template <class T>
std::vector<T> valuesOf(const VolumeFile& file) {
  std::vector<T> values(size_t(wholeOf(file.grid).count()) * size_t(file.array.components));
  EXPECT_EQ(sizeof(T), bytesOf(file.array.type));
  readVolume(file, wholeOf(file.grid), std::as_writable_bytes(std::span(values)));
  return values;
}

/// Of 3 x 2 x 2 points.
template <class T>
std::vector<T> twelve() {
  std::vector<T> values;
  for (int i = 0; i < 12; ++i) values.push_back(T(10 * i + 1));
  return values;
}
constexpr Index3 kSize{3, 2, 2};

class ImageFormats : public ::testing::Test {
 protected:
  std::string file(const std::string& name, const std::string& bytes) const {
    writeText(folder_ / name, bytes);
    return folder_ / name;
  }
  std::string errorOf(const std::string& path, const RawOptions& options = {}) const {
    try {
      const VolumeFile file = openVolume(path, {}, options);
      std::vector<std::byte> samples(size_t(wholeOf(file.grid).count()) * file.bytesPerPoint());
      readVolume(file, wholeOf(file.grid), samples);
    } catch (const Error& e) {
      return e.what();
    }
    return "no error";
  }
  void expectError(const std::string& path, const std::string& part, const RawOptions& options = {}) const {
    const std::string error = errorOf(path, options);
    EXPECT_NE(error.find(part), error.npos) << error;
    EXPECT_TRUE(error.starts_with(folder_ / "")) << error;
  }
  const TemporaryFolder folder_;
};

const std::string kMeta =
    "ObjectType = Image\nNDims = 3\nDimSize = 3 2 2\nElementSpacing = 1 2 3\nOffset = 5 6 7\n";

TEST_F(ImageFormats, MetaImagesOfEveryTypeInBothByteOrders) {
  const auto read = [&](const std::string& type, auto zero) {
    using T = decltype(zero);
    for (const bool big : {false, true}) {
      const VolumeFile volume =
          openVolume(file("v.mha", kMeta + "BinaryDataByteOrderMSB = " + (big ? "True" : "False") +
                                       "\nElementType = " + type + "\nElementDataFile = LOCAL\n" +
                                       bytesOf(twelve<T>(), big)));
      EXPECT_EQ(volume.grid, (Grid{{5, 6, 7}, {1, 2, 3}, kSize}));
      EXPECT_EQ(valuesOf<T>(volume), twelve<T>()) << type;
    }
  };
  read("MET_CHAR", int8_t{});
  read("MET_UCHAR", uint8_t{});
  read("MET_SHORT", int16_t{});
  read("MET_USHORT", uint16_t{});
  read("MET_INT", int32_t{});
  read("MET_UINT", uint32_t{});
  read("MET_LONG_LONG", int64_t{});
  read("MET_ULONG_LONG", uint64_t{});
  read("MET_FLOAT", float{});
  read("MET_DOUBLE", double{});
}

TEST_F(ImageFormats, MetaImagesBesideTheirHeadersCompressedTurnedAndAsText) {
  file("v.raw", bytesOf(twelve<int16_t>()));
  const std::string type = "ElementType = MET_SHORT\n";
  const std::string beside = file("v.mhd", kMeta + type + "ElementDataFile = v.raw\n");
  EXPECT_EQ(valuesOf<int16_t>(openVolume(beside)), twelve<int16_t>());
  EXPECT_EQ(filesOpenedFor(beside), (std::vector<std::string>{beside, folder_ / "v.raw"}));
  // the rows of the matrix are the axes: the first runs along -x
  const VolumeFile turned = openVolume(
      file("t.mhd", kMeta + type + "TransformMatrix = -1 0 0 0 1 0 0 0 1\nElementDataFile = v.raw\n"));
  EXPECT_EQ(turned.grid.origin, glm::dvec3(3, 6, 7));
  EXPECT_EQ(valuesOf<int16_t>(turned)[0], 21);
  const std::vector<int16_t> samples = twelve<int16_t>();
  std::string zlib(1000, '\0');
  uLongf size = zlib.size();
  compress(reinterpret_cast<Bytef*>(zlib.data()), &size, reinterpret_cast<const Bytef*>(samples.data()), 24);
  zlib.resize(size);
  EXPECT_EQ(valuesOf<int16_t>(openVolume(
                file("z.mha", kMeta + type + "CompressedData = True\nElementDataFile = LOCAL\n" + zlib))),
            samples);
  EXPECT_EQ(
      valuesOf<int16_t>(openVolume(file(
          "a.mha", kMeta + type +
                       "BinaryData = False\nElementDataFile = LOCAL\n1 11 21 31 41 51 61 71 81 91 101 111"))),
      samples);
  EXPECT_EQ(
      valuesOf<int16_t>(openVolume(file(
          "h.mha", kMeta + type + "HeaderSize = -1\nElementDataFile = LOCAL\nwhatever" + bytesOf(samples)))),
      samples);
  expectError(file("s.mha", kMeta + type + "ElementDataFile = LOCAL\n" + bytesOf(samples).substr(1)),
              "truncated: 23 bytes, expected 24");
  expectError(
      file("s.mha", kMeta + type + "CompressedData = True\nElementDataFile = LOCAL\n" + zlib.substr(0, 10)),
      "compressed data cannot be read");
  expectError(file("s.mhd", kMeta + type + "ElementDataFile = s%d.raw\n"), "a file for each slice");
  expectError(file("s.mhd", "DimSize = 3 2 2\n"), ":1: expected NDims first");
  expectError(file("s.mhd", kMeta + "ElementType = MET_STRING\n"), "unknown ElementType \"MET_STRING\"");
}

TEST_F(ImageFormats, NrrdsInEveryEncoding) {
  const std::string head = "NRRD0004\n# a comment\ntype: float\ndimension: 3\nsizes: 3 2 2\nkey:=value\n";
  const std::string raw = bytesOf(twelve<float>()), swapped = bytesOf(twelve<float>(), true);
  const std::string place =
      "space: left-posterior-superior\nspace directions: (0,0,2) (1,0,0) (0,3,0)\nspace origin: (5,6,7)\n";
  VolumeFile volume =
      openVolume(file("v.nrrd", head + "encoding: raw\nendian: little\nspacings: 1 2 3\n\n" + raw));
  EXPECT_EQ(volume.grid, (Grid{{0, 0, 0}, {1, 2, 3}, kSize}));
  EXPECT_EQ(valuesOf<float>(volume), twelve<float>());
  volume = openVolume(file("v.nrrd", head + place + "endian: big\nencoding: gzip\n\n" + gzipped(swapped)));
  EXPECT_EQ(volume.grid, (Grid{{5, 6, 7}, {1, 3, 2}, {2, 2, 3}})) << "its first axis runs along z";
  EXPECT_EQ(valuesOf<float>(volume), (std::vector<float>{1, 31, 61, 91, 11, 41, 71, 101, 21, 51, 81, 111}));
  file("v.raw", "head" + raw);
  volume =
      openVolume(file("v.nhdr", head + "encoding: raw\nendian: little\nbyte skip: 4\ndata file: v.raw\n"));
  EXPECT_EQ(valuesOf<float>(volume), twelve<float>());
  EXPECT_EQ(filesOpenedFor(folder_ / "v.nhdr").back(), folder_ / "v.raw");
  volume = openVolume(file("v.nrrd", head + "encoding: ascii\n\n1 11 21 31 41 51\n61 71 81 91 101 111\n"));
  EXPECT_EQ(valuesOf<float>(volume), twelve<float>());
  volume = openVolume(
      file("v.nrrd",
           "NRRD0005\ntype: unsigned char\ndimension: 4\nsizes: 3 2 2 2\nkinds: vector domain domain domain\n"
           "space directions: none (1,0,0) (0,1,0) (0,0,1)\nencoding: raw\n\n" +
               std::string(24, 'x')));
  EXPECT_EQ(volume.array.components, 3);
  expectError(file("v.nrrd", head + "encoding: bzip2\n\n"),
              "encoding \"bzip2\", expected raw, gzip or ascii");
  expectError(file("v.nrrd", head + "encoding: raw\n\n" + raw.substr(1)), "truncated: 47 bytes, expected 48");
  expectError(file("v.nrrd", head + "space directions: (1,1,0) (0,1,0) (0,0,1)\nencoding: raw\n\n" + raw),
              "at right angles");
}

/// A NIfTI-1 header of 3 x 2 x 2 samples of 2 bytes: each field at its place.
class Nifti {
 public:
  explicit Nifti(bool big = false) : big_(big) {
    set<int32_t>(0, 348);
    for (size_t i = 0; i < 8; ++i) set<int16_t>(40 + 2 * i, std::vector<int16_t>{3, 3, 2, 2, 1, 1, 1, 1}[i]);
    set<int16_t>(70, 4);
    set<int16_t>(72, 16);
    for (size_t i = 0; i < 4; ++i) set<float>(76 + 4 * i, std::vector<float>{1, 1, 2, 3}[i]);
    set<float>(108, 352);
    bytes_.replace(344, 4, "n+1\0"s);
  }
  template <class T>
  Nifti& set(size_t place, T value) {
    bytes_.replace(place, sizeof(T), bytesOf(std::vector<T>{value}, big_));
    return *this;
  }
  std::string with(const std::string& samples) const { return bytes_ + samples; }

 private:
  bool big_;
  std::string bytes_ = std::string(352, '\0');
};

TEST_F(ImageFormats, NiftiImagesInBothByteOrdersAndCompressed) {
  const std::vector<int16_t> samples = twelve<int16_t>();
  for (const bool big : {false, true}) {
    const std::string bytes = Nifti(big).with(bytesOf(samples, big));
    for (const std::string& path : {file("v.nii", bytes), file("v.nii.gz", gzipped(bytes))}) {
      const VolumeFile volume = openVolume(path);
      EXPECT_EQ(volume.grid, (Grid{{0, 0, 0}, {1, 2, 3}, kSize}));
      EXPECT_EQ(valuesOf<int16_t>(volume), samples);
    }
  }
  // one import decodes what is compressed once
  const VolumeFile volume = openVolume(folder_ / "v.nii.gz");
  SingleRank one;
  importVolume(volume, decomposed(volume.grid, 2, 1), kGhostLayers, one);
  EXPECT_EQ(volume.decoded->blocks, 1u);
  EXPECT_EQ(volume.decoded->bytes, 24u);
}

TEST_F(ImageFormats, NiftiImagesStandWhereTheirTransformsSay) {
  const std::string samples = bytesOf(twelve<int16_t>());
  Nifti rows;  // x = 10 - 2 i, y = 20 + 3 k, z = 30 + j
  rows.set<int16_t>(254, 1);
  rows.set<float>(280, -2)
      .set<float>(292, 10)
      .set<float>(304, 3)
      .set<float>(308, 20)
      .set<float>(316, 1)
      .set<float>(324, 30);
  VolumeFile volume = openVolume(file("v.nii", rows.with(samples)));
  EXPECT_EQ(volume.grid, (Grid{{6, 20, 30}, {2, 3, 1}, {3, 2, 2}}));
  EXPECT_EQ(valuesOf<int16_t>(volume)[0], 21) << "the last sample of its row";
  EXPECT_EQ(valuesOf<int16_t>(volume)[3], 81) << "the next along y is the next slice";
  Nifti half;  // turned by pi about z: b = c = 0, d = 1
  half.set<int16_t>(252, 1).set<float>(264, 1).set<float>(268, 5).set<float>(272, 6).set<float>(276, 7);
  volume = openVolume(file("v.nii", half.with(samples)));
  EXPECT_EQ(volume.grid, (Grid{{3, 4, 7}, {1, 2, 3}, kSize}));
  EXPECT_EQ(valuesOf<int16_t>(volume)[0], 51);
  Nifti scaled;
  scaled.set<float>(112, 0.5f).set<float>(116, -1);
  volume = openVolume(file("v.nii", scaled.with(samples)));
  EXPECT_EQ(volume.array.type, ScalarType::Float32);
  EXPECT_EQ(valuesOf<float>(volume)[11], 0.5f * 111 - 1);
  expectError(file("v.nii", Nifti().set<int16_t>(70, 32).with(samples)), "datatype 32, expected integers");
  expectError(file("v.nii", Nifti().set<float>(108, 12).with(samples)),
              "the samples begin within the header");
  expectError(file("v.nii", Nifti().with(samples).substr(0, 300)), "ends within its header");
  expectError(file("v.nii.gz", gzipped(Nifti().with(samples.substr(1)))),
              "the samples end before point 11, expected 12");
}

std::string npy(const std::string& dictionary, const std::string& samples) {
  return "\x93NUMPY\x01\x00"s + char(dictionary.size()) + '\0' + dictionary + samples;
}

TEST_F(ImageFormats, NumPyArraysWithSpacing) {
  const std::string samples = bytesOf(twelve<double>());
  RawOptions options;
  options.spacing = {1, 2, 3};
  VolumeFile volume = openVolume(
      file("v.npy", npy("{'descr': '<f8', 'fortran_order': False, 'shape': (2, 2, 3), }\n", samples)), {},
      options);
  EXPECT_EQ(volume.grid, (Grid{{0, 0, 0}, {1, 2, 3}, kSize})) << "the last axis is the fastest";
  EXPECT_EQ(valuesOf<double>(volume), twelve<double>());
  volume = openVolume(file("v.npy", npy("{'descr': '>i2', 'fortran_order': True, 'shape': (3, 2, 2), }\n",
                                        bytesOf(twelve<int16_t>(), true))));
  EXPECT_EQ(volume.grid.points, kSize);
  EXPECT_EQ(valuesOf<int16_t>(volume), twelve<int16_t>());
  volume = openVolume(file("v.npy", npy("{'descr': '|u1', 'fortran_order': False, 'shape': (2, 2, 3, 2)}\n",
                                        std::string(24, 'x'))));
  EXPECT_EQ(volume.array.components, 2);
  volume = openVolume(
      file("v.npy", npy("{'descr': '|b1', 'fortran_order': False, 'shape': (2, 3)}\n", "\0\1\0\1\0\1"s)));
  EXPECT_EQ(volume.grid.points, kSize) << "one layer is two";
  expectError(file("v.npy", npy("{'descr': '<f8', 'fortran_order': False, 'shape': (2, 2, 4)}\n", samples)),
              "truncated");
  expectError(file("v.npy", npy("{'descr': '<c8', 'fortran_order': False, 'shape': (2, 2, 3)}\n", samples)),
              "type \"'<c8'\"");
  expectError(file("v.npy", "\x93NUMPY\x01"), "expected a file of NumPy's form");
}

TEST_F(ImageFormats, RawSamplesByOptions) {
  RawOptions options;
  options.dimensions = kSize;
  options.type = ScalarType::UInt16;
  options.bigEndian = true;
  options.skip = 3;
  options.spacing = {1, 2, 3};
  options.origin = {5, 6, 7};
  const std::string path = file("head.bin", "abc" + bytesOf(twelve<uint16_t>(), true));
  const VolumeFile volume = openVolume(path, {}, options);
  EXPECT_EQ(volume.grid, (Grid{{5, 6, 7}, {1, 2, 3}, kSize}));
  EXPECT_EQ(valuesOf<uint16_t>(volume), twelve<uint16_t>());
  options.skip = 2;
  expectError(path, "too long: 25 bytes, expected 24", options);
  options.type.reset();
  expectError(path, "expected both the dimensions and the type", options);
}

TEST_F(ImageFormats, AnUnknownEndingIsAnsweredByAllThatCanBeRead) {
  EXPECT_FALSE(isVolumeFile(folder_ / "v.xyz"));
  expectError(folder_ / "v.xyz", ".mha .mhd .nrrd .nhdr .nii .nii.gz .npy, geometry as .vtu");
  EXPECT_FALSE(isVolumeFile(folder_ / "v.gz"));
  for (const char* known : {"v.mha", "V.MHD", "v.nrrd", "v.nhdr", "v.nii", "v.nii.gz", "V.NII.GZ", "v.npy"})
    EXPECT_TRUE(isVolumeFile(folder_ / known)) << known;
  RawOptions spacing;
  spacing.spacing = {1, 1, 1};
  expectError(folder_ / "v.vti", "spacing and origin may be given for", spacing);
}

TEST_F(ImageFormats, DamagedHeadersGiveAResultOrAnError) {
  std::mt19937 random(4);
  const std::string short12 = bytesOf(twelve<int16_t>());
  int errors = 0;
  for (const auto& [name, text] :
       {std::pair{"v.mha"s, kMeta + "ElementType = MET_SHORT\nElementDataFile = LOCAL\n" + short12},
        {"v.nrrd", "NRRD0004\ntype: short\ndimension: 3\nsizes: 3 2 2\nencoding: raw\n\n" + short12},
        {"v.nii", Nifti().with(short12)},
        {"v.npy", npy("{'descr': '<i2', 'fortran_order': False, 'shape': (2, 2, 3)}\n", short12)}})
    for (int i = 0; i < 300; ++i) {
      try {
        const VolumeFile volume = openVolume(file(name, testing::mutated(text, random)));
        std::vector<std::byte> point(volume.bytesPerPoint());
        readVolume(volume, {{0, 0, 0}, {1, 1, 1}}, point);
      } catch (const Error&) {
        ++errors;
      }
    }
  EXPECT_GT(errors, 300);
}

}  // namespace
}  // namespace gxy

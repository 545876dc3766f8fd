// SPDX-License-Identifier: Apache-2.0
// Opens files that consist of a header and raw samples as volumes.
#include <cmath>
#include <cstring>

#include "core/comm/error.h"
#include "core/io/file.h"
#include "core/io/image_header.h"
#include "core/io/number_text.h"
#include "core/io/raw_samples.h"
#include "core/io/streamed_samples.h"
#include "core/io/volume_formats.h"

namespace gxy {
namespace {

/// Samples of integers whose values a file scales. They become float, or double if float might round them.
class ScaledSamples final : public SampleSource {
 public:
  ScaledSamples(std::shared_ptr<const SampleSource> source, ScalarType type, int components, double slope,
                double intercept)
      : source_(std::move(source)),
        type_(type),
        components_(components),
        slope_(slope),
        intercept_(intercept) {}
  static ScalarType typeFor(ScalarType type) {
    return bytesOf(type) <= 2 || type == ScalarType::Float32 ? ScalarType::Float32 : ScalarType::Float64;
  }

  void read(std::span<const Extent> wanted, const TakeSamples& take) const override {
    std::vector<std::byte> in, out;
    source_->read(wanted, [&](const SamplesRead& some) {
      const size_t values = size_t(some.points.count()) * size_t(components_);
      in.resize(values * bytesOf(type_));
      out.resize(values * bytesOf(typeFor(type_)));
      copyBox(some.points, some.samples, some.layout, in, some.points, bytesOf(type_) * size_t(components_));
      const auto scale = [&](auto from, auto to) {
        for (size_t i = 0; i < values; ++i) {
          std::memcpy(&from, &in[i * sizeof from], sizeof from);
          to = static_cast<decltype(to)>(intercept_ + slope_ * static_cast<double>(from));
          std::memcpy(&out[i * sizeof to], &to, sizeof to);
        }
      };
      const bool wide = typeFor(type_) == ScalarType::Float64;
      withType(type_, [&](auto from) { wide ? scale(from, double{}) : scale(from, float{}); });
      take({some.wanted, some.points, some.points, out});
    });
  }

 private:
  std::shared_ptr<const SampleSource> source_;
  ScalarType type_;
  int components_;
  double slope_, intercept_;
};

std::string headerBytes(const std::string& path, bool compressed) {
  const auto file = std::make_shared<const File>(File::open(path));
  ByteStreamPtr stream = fileBytes(file, 0, file->size());
  if (compressed) stream = decompressed(std::move(stream), Compression::Zlib, path);
  std::string bytes(size_t(compressed ? 4096 : std::min(file->size(), kHeaderBytes)), '\0');
  bytes.resize(stream->read(std::as_writable_bytes(std::span(bytes))));
  return bytes;
}

std::shared_ptr<const SampleSource> samplesOfHeader(const ImageHeader& h, const ArrayInfo& array,
                                                    const std::shared_ptr<Decoded>& decoded) {
  const std::string path = h.dataFile.empty() ? h.image.path : beside(h.image.path, h.dataFile);
  const auto file = std::make_shared<const File>(File::open(path));
  const Extent extent = h.image.extentOf(array);
  const int64_t bytes = extent.count() * int64_t(bytesOf(h.type)) * h.components;
  if (h.text)
    return std::make_shared<StreamedSamples>(
        textBlocks(file, std::max<int64_t>(h.offset, 0), h.type, bytes, path), extent, h.type, h.components,
        false, path, decoded);
  if (h.compression == Compression::None)
    return std::make_shared<RawSamples>(
        file, h.offset == ImageHeader::kAtEnd ? std::max<int64_t>(0, file->size() - bytes) : h.offset, extent,
        h.type, h.components, h.swapBytes, h.exact);
  // A .nii.gz is compressed as a whole, header included.
  const bool whole = extensionOf(path) == ".gz" && h.dataFile.empty();
  const int64_t begin = whole ? 0 : std::max<int64_t>(h.offset, 0), passed = whole ? h.offset : 0;
  return std::make_shared<StreamedSamples>(
      oneBlock(file, begin, file->size() - begin, h.compression, passed, bytes), extent, h.type, h.components,
      h.swapBytes, path, decoded);
}

bool isNiftiGz(const std::string& path) {
  constexpr size_t kGz = 3;
  return extensionOf(path) == ".gz" && extensionOf(path.substr(0, path.size() - kGz)) == ".nii";
}

}  // namespace

std::optional<ImageHeader> imageHeaderOf(const std::string& path) {
  const std::string extension = extensionOf(path);
  if (extension == ".mha" || extension == ".mhd") return parseMetaImage(headerBytes(path, false), path);
  if (extension == ".nrrd" || extension == ".nhdr") return parseNrrd(headerBytes(path, false), path);
  if (extension == ".npy") return parseNpy(headerBytes(path, false), path);
  if (extension == ".nii") return parseNifti(headerBytes(path, false), path);
  if (!isNiftiGz(path)) return {};
  ImageHeader header = parseNifti(headerBytes(path, true), path);
  header.compression = Compression::Zlib;
  return header;
}

bool isImageFile(const std::string& path) {
  const std::string extension = extensionOf(path);
  return extension == ".mha" || extension == ".mhd" || extension == ".nrrd" || extension == ".nhdr" ||
         extension == ".npy" || extension == ".nii" || isNiftiGz(path);
}

VolumeFile openImageFile(const std::string& path, const RawOptions& options) {
  ImageHeader header = *imageHeaderOf(path);
  ImageData& image = header.image;
  if (options.spacing) image.spacing = *options.spacing;
  if (options.origin) image.origin = *options.origin;
  image.arrays = {{{}, header.type, header.components, {}}};
  VolumeFile file = volumeOf(
      image, {}, [&](const ArrayInfo& array) { return samplesOfHeader(header, array, image.decoded); });
  if (header.slope == 1 && header.intercept == 0) return file;
  file.source = std::make_shared<ScaledSamples>(file.source, file.array.type, file.array.components,
                                                header.slope, header.intercept);
  file.array.type = ScaledSamples::typeFor(file.array.type);
  file.arrays = {file.array};
  return file;
}

VolumeFile openRaw(const std::string& path, const RawOptions& options) {
  ImageHeader header;
  ImageData& image = header.image;
  image.path = path;
  image.points = options.dimensions.value_or(Index3{1, 1, 1});
  if (options.spacing) image.spacing = *options.spacing;
  if (options.origin) image.origin = *options.origin;
  image.arrays = {{{}, options.type.value_or(ScalarType::UInt8), options.components, {}}};
  header.type = image.arrays[0].type;
  header.components = options.components;
  header.swapBytes = options.bigEndian != (std::endian::native == std::endian::big);
  header.offset = options.skip;
  header.exact = true;
  return volumeOf(image, {},
                  [&](const ArrayInfo& array) { return samplesOfHeader(header, array, image.decoded); });
}

}  // namespace gxy

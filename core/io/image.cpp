// SPDX-License-Identifier: Apache-2.0
#include "gxy/io/image.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>

#include "gxy/comm/error.h"
#include "replace_file.h"

namespace gxy {
namespace {

std::string extension(const std::string& path) { return std::filesystem::path(path).extension().string(); }

/// Files hold rows top to bottom, pictures in memory bottom to top.
template <class Pixels>
Pixels flipped(const Pixels& pixels, int height) {
  Pixels rows;
  rows.reserve(pixels.size());
  const ptrdiff_t row = ptrdiff_t(pixels.size()) / height;
  for (int y = height - 1; y >= 0; --y)
    rows.insert(rows.end(), pixels.begin() + y * row, pixels.begin() + (y + 1) * row);
  return rows;
}

/// 8 bits: NaN becomes 0.
uint8_t level(float value) {
  return value > 0 ? uint8_t(std::lround(std::min(value, 1.f) * 255.f)) : uint8_t(0);
}

/// Encoded in memory: OpenImageIO's own files do not notice a full disk.
std::vector<std::byte> encoded(const char* format, const Image& image, OIIO::TypeDesc type,
                               const void* rows) {
  OIIO::ImageSpec spec(image.width, image.height, 4, type);
  spec.attribute("oiio:UnassociatedAlpha", type == OIIO::TypeDesc::UINT8 ? 1 : 0);
  std::vector<unsigned char> bytes;
  OIIO::Filesystem::IOVecOutput memory(bytes);
  const auto out = OIIO::ImageOutput::create(format);
  if (!out) throw Error(OIIO::geterror());
  if (!out->set_ioproxy(&memory) || !out->open("memory", spec) || !out->write_image(type, rows) ||
      !out->close())
    throw Error(out->geterror());
  const auto whole = std::as_bytes(std::span(bytes));
  return {whole.begin(), whole.end()};
}

Image readRaw(const std::string& path, int width, int height) {
  if (width < 1 || height < 1)
    throw Error(path + ": a raw picture does not state its size; expected width and height");
  Image image{width, height, LargeVector<float>(size_t(width) * size_t(height) * 4)};
  const auto bytes = std::streamsize(image.rgba.size() * sizeof(float));
  std::ifstream in(path, std::ios::binary | std::ios::ate);
  if (!in) throw Error(path + ": cannot open the picture");
  if (in.tellg() != bytes)
    throw Error(path + ": " + std::to_string(in.tellg()) + " bytes, expected " + std::to_string(bytes) +
                " for " + std::to_string(width) + " x " + std::to_string(height) + " float RGBA pixels");
  in.seekg(0);
  if (!in.read(reinterpret_cast<char*>(image.rgba.data()), bytes))
    throw Error(path + ": cannot read the picture");
  return image;
}

void checkSize(const Image& image) {
  if (image.width < 1 || image.height < 1 ||
      image.rgba.size() != size_t(image.width) * size_t(image.height) * 4)
    throw Error("a picture of " + std::to_string(image.width) + " x " + std::to_string(image.height) +
                " pixels cannot have " + std::to_string(image.rgba.size()) + " values");
}

}  // namespace

std::vector<uint8_t> eightBits(std::span<const float> rgba) {
  std::vector<uint8_t> levels(rgba.size());
  for (size_t i = 0; i + 4 <= rgba.size(); i += 4) {
    const float alpha = rgba[i + 3];
    for (size_t c = 0; c < 3; ++c) levels[i + c] = level(alpha > 0 ? rgba[i + c] / alpha : rgba[i + c]);
    levels[i + 3] = level(alpha);
  }
  return levels;
}

std::vector<std::byte> encodeImage(const std::string& format, const Image& image) {
  checkSize(image);
  if (format == "raw") {
    const auto bytes = std::as_bytes(std::span(image.rgba));
    return {bytes.begin(), bytes.end()};
  }
  if (format == "exr")
    return encoded("openexr", image, OIIO::TypeDesc::FLOAT, flipped(image.rgba, image.height).data());
  if (format != "png") throw Error("cannot write this kind of picture: expected .png, .exr or .raw");
  return encoded("png", image, OIIO::TypeDesc::UINT8, flipped(eightBits(image.rgba), image.height).data());
}

void writeImage(const std::string& path, const Image& image) {
  const std::string kind = extension(path);
  std::vector<std::byte> bytes;
  try {
    checkSize(image);
    if (kind != ".raw") bytes = encodeImage(kind.empty() ? kind : kind.substr(1), image);
  } catch (const Error& error) {
    throw Error(path + ": " + error.what());
  }
  replaceFile(path, kind == ".raw" ? std::as_bytes(std::span(image.rgba)) : bytes);
}

Image readImage(const std::string& path, int width, int height) {
  const std::string kind = extension(path);
  if (kind == ".raw") return readRaw(path, width, height);
  if (kind != ".png" && kind != ".exr")
    throw Error(path + ": cannot read this kind of picture: expected .png, .exr or .raw");
  OIIO::ImageSpec request;
  request.attribute("oiio:UnassociatedAlpha", 1);  // as in the file; a PNG is premultiplied here, in float
  const auto in = OIIO::ImageInput::open(path, &request);
  if (!in) throw Error(path + ": cannot read the picture: " + OIIO::geterror());
  const OIIO::ImageSpec& spec = in->spec();
  const int channels = spec.nchannels;
  const size_t pixels = size_t(spec.width) * size_t(spec.height);
  std::vector<float> values(pixels * size_t(channels));
  if (spec.depth > 1 || channels < 1 ||
      !in->read_image(0, 0, 0, channels, OIIO::TypeDesc::FLOAT, values.data()))
    throw Error(path + ": cannot read the picture: " + in->geterror());

  LargeVector<float> rgba(pixels * 4);
  const bool colour = channels >= 3, hasAlpha = channels == 2 || channels >= 4;
  for (size_t i = 0; i < pixels; ++i) {
    const float* from = &values[i * size_t(channels)];
    const float alpha = hasAlpha ? from[colour ? 3 : 1] : 1.f;
    const float scale = kind == ".png" ? alpha : 1.f;
    for (size_t c = 0; c < 3; ++c) rgba[4 * i + c] = from[colour ? c : 0] * scale;
    rgba[4 * i + 3] = alpha;
  }
  return {spec.width, spec.height, flipped(rgba, spec.height)};
}

}  // namespace gxy

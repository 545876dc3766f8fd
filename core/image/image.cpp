// SPDX-License-Identifier: Apache-2.0
#include "core/image/image.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>

#include "core/comm/error.h"
#include "core/comm/plugin.h"
#include "core/image/image_plugin.h"
#include "core/image/png_writer.h"
#include "core/image/replace_file.h"
#include "core/image/text_mask.h"

namespace gxy {
namespace {

std::string extension(const std::string& path) { return std::filesystem::path(path).extension().string(); }

/// Converts to 8 bits. NaN becomes 0.
uint8_t level(float value) {
  return value > 0 ? uint8_t(std::lround(std::min(value, 1.f) * 255.f)) : uint8_t(0);
}

const ImagePlugin& images(const std::string& purpose) { return plugin<ImagePlugin>("image", purpose); }

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
  if (format == "exr") return images("writing an .exr").encode(format, image);
  if (format != "png") throw Error("cannot write this kind of picture: expected .png, .exr or .raw");
  return encodePng(image);
}

std::vector<std::byte> encodeDepth(int width, int height, std::span<const double> depth) {
  if (width < 1 || height < 1 || depth.size() != size_t(width) * size_t(height))
    throw Error("a picture of " + std::to_string(width) + " x " + std::to_string(height) +
                " pixels cannot have " + std::to_string(depth.size()) + " depths");
  return images("writing an .exr").encodeDepth(width, height, depth);
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

TextMask textMask(const std::string& text, int pixels) {
  if (text.empty()) return {};
  return images("drawing text").text(text, pixels);
}

Image readImage(const std::string& path, int width, int height) {
  const std::string kind = extension(path);
  if (kind == ".raw") return readRaw(path, width, height);
  if (kind != ".png" && kind != ".exr")
    throw Error(path + ": cannot read this kind of picture: expected .png, .exr or .raw");
  return images(path + ": reading it").read(path);
}

}  // namespace gxy

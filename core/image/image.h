// SPDX-License-Identifier: Apache-2.0
// Pictures to files and back. A target of its own, galaxy_image. A .png is written by libpng; for the rest the plugin with
// OpenImageIO is opened (image_plugin.h), whose loading takes a quarter of a second.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/space/large_vector.h"

namespace gxy {

/// A picture: RGBA in float, premultiplied, rows bottom to top.
struct Image {
  int width = 0, height = 0;
  LargeVector<float> rgba;  ///< 4 * width * height
};

/// Writes by extension. .png: 8 bits, alpha un-premultiplied, clamped to [0, 1] and rounded. .exr: float,
/// premultiplied. .raw: the floats of `rgba` as they are, in this machine's byte order. Throws Error when the
/// file cannot be written; a file of this name is always whole (replace_file.h).
void writeImage(const std::string& path, const Image& image);

/// The bytes that writeImage would write; `format` is "png", "exr" or "raw".
std::vector<std::byte> encodeImage(const std::string& format, const Image& image);

/// A picture in 8 bits, as a .png has it: RGBA, not premultiplied; rows as in `rgba`.
std::vector<uint8_t> eightBits(std::span<const float> rgba);

/// Reads a .png (8 or 16 bits; grey or RGB become opaque RGBA) or .exr into the form above. A .raw file does
/// not state its size: width and height must be given, and are ignored for the others.
Image readImage(const std::string& path, int width = 0, int height = 0);

}  // namespace gxy

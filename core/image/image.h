// SPDX-License-Identifier: Apache-2.0
// Writes and reads pictures. libpng writes .png files. Everything else needs OpenImageIO, which is in a
// plugin (image_plugin.h) that is opened at first use; loading it takes a quarter of a second.
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

/// Writes a picture in the format of the path's extension. .png: 8 bits, not premultiplied, clamped to [0, 1]
/// and rounded. .exr: float, premultiplied. .raw: the floats of `rgba` as they are, in this machine's byte
/// order. A file with this name is always complete (replace_file.h). Throws Error if the file cannot be
/// written, the extension is another one, or `rgba` does not fit the size.
void writeImage(const std::string& path, const Image& image);

/// Returns the bytes that writeImage() would write. `format` is "png", "exr" or "raw". Throws Error as
/// writeImage() does.
std::vector<std::byte> encodeImage(const std::string& format, const Image& image);

/// Returns the bytes of an .exr file with one channel, Z, in float: depths, rows bottom to top. Throws Error as writeImage() does.
std::vector<std::byte> encodeDepth(int width, int height, std::span<const double> depth);

/// Converts premultiplied float RGBA to 8 bits, not premultiplied, as in a .png file. Rows stay in their order.
std::vector<uint8_t> eightBits(std::span<const float> rgba);

/// Reads a .png (8 or 16 bits; grey and RGB become opaque RGBA), .exr or .raw file. A .raw file does not
/// contain its size, so width and height must be given; they are ignored for the others. Throws Error if the
/// file cannot be read.
Image readImage(const std::string& path, int width = 0, int height = 0);

}  // namespace gxy

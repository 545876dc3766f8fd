// SPDX-License-Identifier: Apache-2.0
// The table of plugin "image" (core/comm/plugin.h). The plugin contains all code that calls OpenImageIO,
// because that library loads some 240 others.
#pragma once
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "core/image/image.h"
#include "core/image/text_mask.h"

namespace gxy {

struct ImagePlugin {
  /// Returns the bytes of a file: "png" in 8 bits, not premultiplied, or "exr" in float, premultiplied.
  std::vector<std::byte> (*encode)(const std::string& format, const Image& image);
  /// Implements encodeDepth() for depths that fit the size.
  std::vector<std::byte> (*encodeDepth)(int width, int height, std::span<const double> depth);
  /// Reads a .png or .exr file.
  Image (*read)(const std::string& path);
  /// Implements textMask() for a text that is not empty.
  TextMask (*text)(const std::string& text, int pixels);
};

}  // namespace gxy

// SPDX-License-Identifier: Apache-2.0
// The table of plugin "image" (core/comm/plugin.h), which holds what OpenImageIO does: that library brings some 240 others.
#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "core/image/image.h"
#include "core/image/text_mask.h"

namespace gxy {

struct ImagePlugin {
  /// The bytes of a whole file: "png" in 8 bits, not premultiplied, or "exr".
  std::vector<std::byte> (*encode)(const std::string& format, const Image& image);
  /// Reads a .png or .exr.
  Image (*read)(const std::string& path);
  /// textMask() of a text that is not empty.
  TextMask (*text)(const std::string& text, int pixels);
};

}  // namespace gxy

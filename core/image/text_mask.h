// SPDX-License-Identifier: Apache-2.0
// Text as a picture. Part of galaxy_image; the plugin with OpenImageIO draws it.
#pragma once
#include <string>
#include <vector>

namespace gxy {

/// How much of each pixel a text covers, in [0, 1]; rows bottom to top. It is as high as the font's ascenders and descenders
/// together, whatever the text, and starts where the text does.
struct TextMask {
  int width = 0, height = 0;
  std::vector<float> coverage;

  /// 0 outside.
  float at(int x, int y) const {
    return x < 0 || y < 0 || x >= width || y >= height ? 0.f
                                                       : coverage[size_t(y) * size_t(width) + size_t(x)];
  }
};

/// One line of UTF-8 in DejaVu Sans, `pixels` high; an empty text has no width. Throws Error where the font is not there.
TextMask textMask(const std::string& text, int pixels);

}  // namespace gxy

// SPDX-License-Identifier: Apache-2.0
// Draws text into a mask, with OpenImageIO's plugin.
#pragma once
#include <string>
#include <vector>

namespace gxy {

/// The coverage of each pixel by a text, in [0, 1], in rows bottom to top. Its height is that of the font's
/// ascenders and descenders together, for any text. Its left edge is where the text starts.
struct TextMask {
  int width = 0, height = 0;
  std::vector<float> coverage;

  /// The coverage of pixel (x, y); 0 outside the mask.
  float at(int x, int y) const {
    return x < 0 || y < 0 || x >= width || y >= height ? 0.f
                                                       : coverage[size_t(y) * size_t(width) + size_t(x)];
  }
};

/// Draws one line of UTF-8 in DejaVu Sans, `pixels` high. An empty text gives an empty mask. Throws Error if
/// the font is missing. Any thread may call it.
TextMask textMask(const std::string& text, int pixels);

}  // namespace gxy

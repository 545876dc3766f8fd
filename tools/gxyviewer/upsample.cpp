// SPDX-License-Identifier: Apache-2.0
#include "tools/gxyviewer/upsample.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace gxy {

namespace {

constexpr uint32_t kOne = 256;  // a weight of 1

/// The position of a column or row between two of the level.
struct Between {
  size_t first, second;
  uint32_t weight;  ///< weight of the second
};

std::vector<Between> betweens(int whole, int level, double levelPerPixel) {
  std::vector<Between> places(static_cast<size_t>(whole));
  for (int i = 0; i < whole; i++) {
    const double at =
        std::clamp(0.5 * level + (i + 0.5 - 0.5 * whole) * levelPerPixel - 0.5, 0.0, level - 1.0);
    const auto first = size_t(at);
    places[size_t(i)] = {first, std::min(first + 1, size_t(level) - 1),
                         uint32_t(std::lround((at - double(first)) * kOne))};
  }
  return places;
}

/// Interpolates a row of the level across the window, premultiplied, in units of 1 / kOne.
void spread(std::span<const uint8_t> row, const std::vector<Between>& columns, std::vector<uint32_t>& wide) {
  const auto premultiplied = [&](size_t pixel, size_t channel) {
    const uint32_t alpha = row[pixel * 4 + 3];
    return channel == 3 ? alpha : (row[pixel * 4 + channel] * alpha + 127) / 255;
  };
  size_t i = 0;
  for (const Between& at : columns)
    for (size_t c = 0; c < 4; c++)
      wide[i++] = premultiplied(at.first, c) * (kOne - at.weight) + premultiplied(at.second, c) * at.weight;
}

void divideByAlpha(std::span<uint8_t> row) {
  for (size_t i = 0; i < row.size(); i += 4)
    if (const uint32_t alpha = row[i + 3]; alpha != 255)
      for (size_t c = i; c < i + 3; c++)
        row[c] = alpha ? uint8_t(std::min(255u, (row[c] * 255u + alpha / 2) / alpha)) : uint8_t(0);
}

}  // namespace

void upsample(std::span<const uint8_t> coarse, glm::ivec2 level, std::span<uint8_t> rgba, glm::ivec2 size) {
  const double perPixel = double(std::min(level.x, level.y)) / std::min(size.x, size.y);
  const std::vector<Between> columns = betweens(size.x, level.x, perPixel),
                             rows = betweens(size.y, level.y, perPixel);
  const size_t width = size_t(size.x) * 4, levelWidth = size_t(level.x) * 4;
  std::vector<uint32_t> lower(width), upper(width);
  size_t of = size_t(level.y);  // the level's row in `lower`; none yet
  for (size_t y = 0; y < rows.size(); y++) {
    const Between& at = rows[y];
    if (at.first != of) {
      spread(coarse.subspan(at.first * levelWidth, levelWidth), columns, lower);
      spread(coarse.subspan(at.second * levelWidth, levelWidth), columns, upper);
      of = at.first;
    }
    const std::span<uint8_t> row = rgba.subspan(y * width, width);
    const uint32_t above = at.weight, below = kOne - at.weight;
    for (size_t i = 0; i < width; i++)
      row[i] = uint8_t((lower[i] * below + upper[i] * above + kOne * kOne / 2) / (kOne * kOne));
    divideByAlpha(row);
  }
}

}  // namespace gxy

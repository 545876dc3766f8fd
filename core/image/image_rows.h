// SPDX-License-Identifier: Apache-2.0
// The order of a picture's rows. Used inside core/image only.
#pragma once
#include <cstddef>

namespace gxy {

/// Reverses the order of rows: files have them top to bottom, pictures in memory bottom to top.
template <class Pixels>
Pixels flipped(const Pixels& pixels, int height) {
  Pixels rows;
  rows.reserve(pixels.size());
  const ptrdiff_t row = ptrdiff_t(pixels.size()) / height;
  for (int y = height - 1; y >= 0; --y)
    rows.insert(rows.end(), pixels.begin() + y * row, pixels.begin() + (y + 1) * row);
  return rows;
}

}  // namespace gxy

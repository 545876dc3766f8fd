// SPDX-License-Identifier: Apache-2.0
// Morton's curve through a box.
#pragma once
#include <algorithm>
#include <cstdint>
#include <glm/vec3.hpp>

#include "core/data/box.h"

namespace gxy {

/// Orders places along Morton's curve through the 2^21 x 2^21 x 2^21 cells of a box. Places outside count as those at its nearest face.
class MortonCurve {
 public:
  explicit MortonCurve(const Box& box) : origin_(box.lo) {
    for (int a = 0; a < 3; a++) cells_[a] = kCells / (box.hi[a] - box.lo[a]);
  }

  /// How far along the curve the cell of a place is.
  uint64_t operator()(const glm::dvec3& place) const {
    uint64_t along = 0;
    for (int a = 0; a < 3; a++) {
      const double cell = (place[a] - origin_[a]) * cells_[a];
      along |= spread(cell > 0 ? uint64_t(std::min(cell, kCells - 1)) : 0) << a;
    }
    return along;
  }

 private:
  static constexpr double kCells = 1 << 21;

  // Spreads 21 bits, with two 0 bits between neighbours.
  static uint64_t spread(uint64_t x) {
    x = (x | x << 32) & 0x001f00000000ffff;
    x = (x | x << 16) & 0x001f0000ff0000ff;
    x = (x | x << 8) & 0x100f00f00f00f00f;
    x = (x | x << 4) & 0x10c30c30c30c30c3;
    return (x | x << 2) & 0x1249249249249249;
  }

  glm::dvec3 origin_, cells_{};
};

}  // namespace gxy

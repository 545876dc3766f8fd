// SPDX-License-Identifier: Apache-2.0
// Measures how close a device's picture is to the Embree backend's, and decides whether that is close enough
// for a device that rounds otherwise. gpu_report and tests on a GPU (difference.h) use it.
#pragma once
#include <cstddef>

#include "core/render/framebuffer.h"

namespace gxy::test {

struct Closeness {
  /// All pixels; those whose colours are equal in all bits; those with a channel that differs by more than 1/255.
  size_t pixels = 0, equal = 0, far = 0;
  double largest = 0;  ///< largest difference of a channel; 1e30 if one is NaN
  /// Pixels with a hit in either picture; those of them with a hit in one only, or depths that differ by more
  /// than 4 ulp of float.
  size_t hits = 0, hitsFar = 0;
  /// Whether each of the three criteria holds for 99.9 % of pixels. The rest may be rays that rounding
  /// moves past an edge.
  bool agrees() const {
    return 1000 * far <= pixels && 1000 * (pixels - equal) <= pixels && 1000 * hitsFar <= hits;
  }
};

/// Compares pictures of one size, both with depths or both without.
Closeness closenessOf(const Picture& expected, const Picture& found);

}  // namespace gxy::test

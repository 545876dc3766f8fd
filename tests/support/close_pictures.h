// SPDX-License-Identifier: Apache-2.0
// How far a device's picture is from the Embree backend's, and what is near enough where the device rounds otherwise: for
// gpu_report and for tests on a GPU (difference.h).
#pragma once
#include <cstddef>

#include "core/render/framebuffer.h"

namespace gxy::test {

struct Closeness {
  size_t pixels = 0, equal = 0, far = 0;  ///< equal: colour to the bit; far: some channel by more than 1/255
  double largest = 0;                     ///< of any channel; 1e30 where one is not a number
  size_t hits = 0, hitsFar = 0;  ///< of either picture; only of one, or by more than 4 ulp of a float
  /// Each of the three for 99.9 %: the rest may be rays that rounding takes past an edge.
  bool agrees() const {
    return 1000 * far <= pixels && 1000 * (pixels - equal) <= pixels && 1000 * hitsFar <= hits;
  }
};

/// Of pictures of one size, both with depths or both without.
Closeness closenessOf(const Picture& expected, const Picture& found);

}  // namespace gxy::test

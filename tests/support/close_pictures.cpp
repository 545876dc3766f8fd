// SPDX-License-Identifier: Apache-2.0
#include "tests/support/close_pictures.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace gxy::test {

namespace {

// NaN is not near any number.
bool isNear(double expected, double found) {
  const double ulp = std::ldexp(1.0, std::max(std::ilogb(float(expected)), -126) - 23);  // also for 0
  return std::abs(expected - found) <= 4 * ulp;
}

}  // namespace

Closeness closenessOf(const Picture& expected, const Picture& found) {
  Closeness d;
  d.pixels = expected.rgba.size() / 4;
  for (size_t p = 0; p < d.pixels; p++) {
    double most = 0;
    for (size_t k = 4 * p; k < 4 * p + 4; k++) {
      const double here = std::abs(double(expected.rgba[k]) - double(found.rgba[k]));
      most = std::isfinite(here) ? std::max(most, here) : 1e30;
    }
    d.equal += std::memcmp(&expected.rgba[4 * p], &found.rgba[4 * p], 4 * sizeof(float)) == 0;
    d.far += most > 1.0 / 255;
    d.largest = std::max(d.largest, most);
    if (expected.depth.empty()) continue;
    const double a = expected.depth[p], b = found.depth[p];
    if (a >= 1e30 && b >= 1e30) continue;
    d.hits++;
    d.hitsFar += !isNear(a, b);
  }
  return d;
}

}  // namespace gxy::test

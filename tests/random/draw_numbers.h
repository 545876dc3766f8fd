// SPDX-License-Identifier: Apache-2.0
// Seeded choices.
#pragma once
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "core/comm/random.h"

namespace gxy::test {

class Choices {
 public:
  explicit Choices(uint64_t seed) : random_(seed) {}

  int below(int n) { return int(random_.below(uint64_t(n))); }
  /// In [lo, hi].
  int from(int lo, int hi) { return lo + below(hi - lo + 1); }
  bool oneIn(int n) { return below(n) == 0; }
  double unit() { return double(random_.next() >> 11) * 0x1p-53; }
  double in(double lo, double hi) { return lo + (hi - lo) * unit(); }
  /// Log-uniform.
  double scale(double lo, double hi) { return std::exp(in(std::log(lo), std::log(hi))); }
  glm::dvec3 point(double lo, double hi) {
    const double x = in(lo, hi), y = in(lo, hi);
    return {x, y, in(lo, hi)};
  }
  glm::dvec3 direction() {
    for (;;) {
      const glm::dvec3 p = point(-1, 1);
      const double length = glm::length(p);
      if (length > 0.1 && length < 1) return p / length;
    }
  }
  uint64_t seed() { return random_.next(); }

 private:
  Random random_;
};

}  // namespace gxy::test

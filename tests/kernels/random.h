// SPDX-License-Identifier: Apache-2.0
// Seeded numbers for tests: the same on every machine (SplitMix64, Steele et al. 2014).
#pragma once
#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "core/kernels/single.h"
#include "core/kernels/twin.h"

namespace gxy::test {

class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}

  std::uint64_t bits() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }
  // In [0, n).
  int below(int n) { return int(bits() % std::uint64_t(n)); }
  // In [0, 1).
  double unit() { return double(bits() >> 11) * 0x1p-53; }
  double in(double lo, double hi) { return lo + (hi - lo) * unit(); }
  // Log-uniform in [lo, hi).
  double scale(double lo, double hi) { return lo * std::exp(std::log(hi / lo) * unit()); }
  // Uniform on the unit sphere.
  glm::dvec3 direction() {
    double z = in(-1, 1);
    double phi = 2 * std::numbers::pi * unit();
    double r = std::sqrt(1 - z * z);
    return {r * std::cos(phi), r * std::sin(phi), z};
  }
  glm::dvec3 point(double lo, double hi) {
    double x = in(lo, hi);
    double y = in(lo, hi);
    return {x, y, in(lo, hi)};
  }

 private:
  std::uint64_t state_;
};

// |value - truth| in units of the spacing of floats around truth.
inline double ulps(float value, long double truth) {
  float magnitude = std::max(std::fabs(float(truth)), 1.17549435e-38f);
  double spacing = double(std::nextafter(magnitude, INFINITY)) - magnitude;
  return double(std::fabs(value - truth)) / spacing;
}

}  // namespace gxy::test

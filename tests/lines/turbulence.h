// SPDX-License-Identifier: Apache-2.0
// A field like turbulence: waves without divergence, in random directions, of many sizes.
#pragma once
#include <glm/geometric.hpp>
#include <numbers>
#include <vector>

#include "tests/kernels/random.h"

namespace gxy::test {

class Turbulence {
 public:
  /// `waves` waves of 1 to `finest` periods a unit; amplitudes fall with the third root, as energies do with the
  /// power of 5/3.
  Turbulence(int waves, double finest, uint64_t seed) {
    Random random(seed);
    for (int i = 0; i < waves; i++) {
      const double size = random.scale(1, finest);
      const glm::dvec3 direction = random.direction();
      const glm::dvec3 amplitude = glm::cross(random.direction(), direction) * std::pow(size, -1.0 / 3);
      waves_.push_back(
          {2 * std::numbers::pi * size * direction, amplitude, random.in(0, 2 * std::numbers::pi)});
    }
  }
  glm::dvec3 operator()(glm::dvec3 p) const {
    glm::dvec3 v(0);
    for (const Wave& w : waves_) v += w.amplitude * std::sin(glm::dot(w.number, p) + w.phase);
    return v;
  }

 private:
  struct Wave {
    glm::dvec3 number, amplitude;
    double phase;
  };
  std::vector<Wave> waves_;
};

}  // namespace gxy::test

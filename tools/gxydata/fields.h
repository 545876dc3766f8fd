// SPDX-License-Identifier: Apache-2.0
// Scalar fields on [-1, 1]^3 that gxydata samples. All are deterministic: the same seed gives the same bits
// anywhere.
#pragma once
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

namespace gxy::data_tool {

/// A field and its value at a point; `phase` in [0, 1) is the fraction of the time series that has passed.
struct Field {
  std::string name;
  std::function<float(glm::dvec3 p, double phase)> value;
};

/// x, y, z: ramps. oneBall: |p|, the distance from the centre. eightBalls: the distance from the nearest of
/// the eight points (+-0.5, +-0.5, +-0.5). The phase is added to all, so that isosurfaces travel inwards.
std::vector<Field> radialFields();

/// The test signal of Marschner and Lobb (1994), f_M = 6, alpha = 0.25; values in [0, 1].
Field marschnerLobb();

/// Six octaves of value noise in [0, 1]; the phase moves along z.
Field turbulence(uint64_t seed);

/// Exactly zero but for a shell, a coil and a few clouds, in [0, 1]; the phase lets the shell grow.
Field sparse(uint64_t seed);

/// Uniform in [0, 1): a hash of the seed and a counter.
double uniform(uint64_t seed, uint64_t counter);

}  // namespace gxy::data_tool

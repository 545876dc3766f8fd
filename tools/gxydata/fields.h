// SPDX-License-Identifier: Apache-2.0
// The scalar fields on [-1, 1]^3 that gxydata samples. All are deterministic: a seed gives the same bits
// everywhere.
#pragma once
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

namespace gxy::data_tool {

/// A field. `phase`, in [0, 1), is the fraction of the time series that has passed.
struct Field {
  std::string name;
  std::function<float(glm::dvec3 p, double phase)> value;
};

/// Fields x, y, z: ramps. oneBall: |p|, the distance from the centre. eightBalls: the distance from the nearest
/// of the eight points (+-0.5, +-0.5, +-0.5). The phase is added to all values, so isosurfaces move inwards.
std::vector<Field> radialFields();

/// The test signal of Marschner and Lobb (1994) with f_M = 6 and alpha = 0.25. Values are in [0, 1].
Field marschnerLobb();

/// Six octaves of value noise, in [0, 1]. The phase moves it along z.
Field turbulence(uint64_t seed);

/// Exactly zero except for a shell, a coil and a few clouds, in [0, 1]. The shell grows with the phase.
Field sparse(uint64_t seed);

/// Returns a number that is uniform in [0, 1), by a hash of the seed and a counter.
double uniform(uint64_t seed, uint64_t counter);

}  // namespace gxy::data_tool

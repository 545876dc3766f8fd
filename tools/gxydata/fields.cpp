// SPDX-License-Identifier: Apache-2.0
#include "tools/gxydata/fields.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec4.hpp>
#include <numbers>

namespace gxy::data_tool {
namespace {

using std::numbers::pi;

/// The finaliser of SplitMix64 (Steele et al. 2014).
uint64_t mix(uint64_t x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
  return x ^ (x >> 31);
}

/// Value noise: random numbers on an integer lattice, interpolated by smoothstep.
double valueNoise(glm::dvec3 p, uint64_t seed) {
  const glm::dvec3 base(std::floor(p.x), std::floor(p.y), std::floor(p.z));
  const glm::dvec3 f = p - base, w = f * f * (3.0 - 2.0 * f);
  const auto corner = [&](int i, int j, int k) {
    const uint64_t x = uint64_t(int64_t(base.x) + i), y = uint64_t(int64_t(base.y) + j);
    const uint64_t z = uint64_t(int64_t(base.z) + k);
    return uniform(seed, x * 0x9e3779b97f4a7c15ull ^ y * 0xc2b2ae3d27d4eb4full ^ z * 0x165667b19e3779f9ull);
  };
  const auto mixed = [](double a, double b, double t) { return a + t * (b - a); };
  std::array<double, 2> slice;
  for (int k = 0; k < 2; ++k)
    slice[size_t(k)] = mixed(mixed(corner(0, 0, k), corner(1, 0, k), w.x),
                             mixed(corner(0, 1, k), corner(1, 1, k), w.x), w.y);
  return mixed(slice[0], slice[1], w.z);
}

/// A sum of octaves. The first has four cells across the box; each has 0.6 of the amplitude of the one
/// before. The sum is stretched to fill [0, 1].
double octaves(glm::dvec3 p, int count, uint64_t seed) {
  double sum = 0, weight = 0, amplitude = 1;
  for (int octave = 0; octave < count; ++octave, amplitude *= 0.6) {
    sum += amplitude * valueNoise((p + 1.0) * double(2 << octave), mix(seed + uint64_t(octave)));
    weight += amplitude;
  }
  return std::clamp(0.5 + 1.6 * (sum / weight - 0.5), 0.0, 1.0);
}

double bump(double distance, double width) { return std::exp(-(distance / width) * (distance / width)); }

/// Distance to a coil of radius 0.25 around the y axis, within the half plane through the axis and p.
double coilDistance(glm::dvec3 p) {
  const double pitch = 0.35, turn = std::atan2(p.z, p.x) / (2 * pi) * pitch;
  const double rise = p.y - turn - pitch * std::round((p.y - turn) / pitch);
  return std::hypot(std::hypot(p.x, p.z) - 0.25, rise);
}

}  // namespace

double uniform(uint64_t seed, uint64_t counter) {
  return double(mix(mix(seed + 0x9e3779b97f4a7c15ull) + counter * 0x9e3779b97f4a7c15ull) >> 11) * 0x1p-53;
}

std::vector<Field> radialFields() {
  return {{"oneBall", [](glm::dvec3 p, double phase) { return float(glm::length(p) + phase); }},
          {"eightBalls",
           [](glm::dvec3 p, double phase) { return float(glm::length(glm::abs(p) - 0.5) + phase); }},
          {"x", [](glm::dvec3 p, double phase) { return float(p.x + phase); }},
          {"y", [](glm::dvec3 p, double phase) { return float(p.y + phase); }},
          {"z", [](glm::dvec3 p, double phase) { return float(p.z + phase); }}};
}

Field marschnerLobb() {
  return {"marschner-lobb", [](glm::dvec3 p, double phase) {
            constexpr double frequency = 6, alpha = 0.25;
            const double r = std::hypot(p.x, p.y);
            const double wave = std::cos(2 * pi * (frequency * std::cos(pi * r / 2) + phase));
            return float((1 - std::sin(pi * p.z / 2) + alpha * (1 + wave)) / (2 * (1 + alpha)));
          }};
}

Field turbulence(uint64_t seed) {
  return {"turbulence", [seed](glm::dvec3 p, double phase) {
            return float(octaves(p + glm::dvec3(0, 0, 2 * phase), 6, seed));
          }};
}

Field sparse(uint64_t seed) {
  std::array<glm::dvec4, 6> clouds;  // centre, radius
  for (size_t i = 0; i < clouds.size(); ++i)
    for (int c = 0; c < 4; ++c) {
      const double u = uniform(seed, 4 * i + size_t(c));
      clouds[i][c] = c < 3 ? 1.6 * u - 0.8 : 0.06 + 0.1 * u;
    }
  return {"sparse", [seed, clouds](glm::dvec3 p, double phase) {
            double density = bump(glm::length(p) - 0.55 - 0.3 * phase, 0.03);
            density = std::max(density, bump(coilDistance(p), 0.04));
            for (const glm::dvec4& c : clouds)
              density = std::max(density, bump(glm::length(p - glm::dvec3(c.x, c.y, c.z)), c.w));
            constexpr double threshold = 0.4;
            if (density < threshold / 1.4) return 0.f;
            density *= 0.5 + 0.9 * octaves(p, 4, seed ^ 0xc10d);
            return float(std::clamp((density - threshold) / (1.3 - threshold), 0.0, 1.0));
          }};
}

}  // namespace gxy::data_tool

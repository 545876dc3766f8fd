// SPDX-License-Identifier: Apache-2.0
// Rays and intervals of their parameter.
#pragma once
#include <algorithm>
#include <glm/vec3.hpp>
#include <limits>

namespace gxy::reference {

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A half line in world coordinates; `direction` has unit length, so t is a distance in world units.
struct Ray {
  glm::dvec3 origin{0};
  glm::dvec3 direction{0, 0, 1};
  glm::dvec3 at(double t) const { return origin + t * direction; }
};

/// A closed interval of t; empty when lo > hi.
struct Interval {
  double lo = 0, hi = kInfinity;
  bool contains(double t) const { return lo <= t && t <= hi; }
  Interval intersected(Interval other) const { return {std::max(lo, other.lo), std::min(hi, other.hi)}; }
};

}  // namespace gxy::reference

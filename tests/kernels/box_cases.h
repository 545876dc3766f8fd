// SPDX-License-Identifier: Apache-2.0
// Rays and boxes of kinds that hurt, and whether they meet.
#pragma once
#include <algorithm>

#include "tests/kernels/random.h"

namespace gxy::test {

struct Case {
  glm::vec3 lo, hi, origin, direction;
  float tMin, tMax;
};

// Does the ray meet the closed box within [tMin, tMax]? Without division: t = p / q is compared by cross products, which
// 128 bits hold nearly exactly (113 bits: 24 + 24 + 25, rounded differences included).
inline bool meetsExactly(const Case& c) {
  using wide = __float128;
  wide enter = c.tMin, exit = c.tMax;
  for (int axis = 0; axis < 3; ++axis) {
    wide o = c.origin[axis], d = c.direction[axis], lo = c.lo[axis], hi = c.hi[axis];
    if (d == 0) {
      if (o < lo || o > hi) return false;
      continue;
    }
    wide a = (lo - o) / d, b = (hi - o) / d;
    enter = std::max(enter, std::min(a, b));
    exit = std::min(exit, std::max(a, b));
  }
  return enter <= exit;
}

// One coordinate of a kind that hurts: zeros, shared values, neighbours, large and small ones; none denormal.
inline float coordinate(Random& random) {
  switch (random.below(8)) {
    case 0:
      return 0.0f;
    case 1:
      return float(random.below(5) - 2);
    case 2:
      return std::nextafter(float(random.below(4) - 4), random.below(2) == 0 ? 10.0f : -10.0f);
    case 3:
      return float(std::ldexp(random.in(-1, 1), random.below(41) - 20));
    default:
      return float(random.in(-2, 2));
  }
}

inline void drawBox(Random& random, Case& c) {
  for (int axis = 0; axis < 3; ++axis) {
    float a = coordinate(random), b = random.below(16) == 0 ? a : coordinate(random);
    c.lo[axis] = std::min(a, b);
    c.hi[axis] = std::max(a, b);
  }
}

inline void drawRay(Random& random, Case& c) {
  for (int axis = 0; axis < 3; ++axis) {
    switch (random.below(6)) {
      case 0:
        c.origin[axis] = c.lo[axis];
        break;
      case 1:
        c.origin[axis] = c.hi[axis];
        break;
      default:
        c.origin[axis] = coordinate(random);
    }
    switch (random.below(6)) {
      case 0:
        c.direction[axis] = 0.0f;
        break;
      case 1:
        c.direction[axis] = -0.0f;
        break;
      case 2:
        c.direction[axis] = float(std::ldexp(random.in(-1, 1), -random.below(40)));
        break;
      default:
        c.direction[axis] = float(random.in(-1, 1));
    }
  }
  if (random.below(2) == 0) {
    // Aimed at a corner, or at an edge's or face's point: the hit hangs on rounding.
    glm::vec3 to;
    for (int axis = 0; axis < 3; ++axis) {
      int kind = random.below(3);
      to[axis] = kind == 0 ? c.lo[axis] : kind == 1 ? c.hi[axis] : 0.5f * (c.lo[axis] + c.hi[axis]);
    }
    c.direction = (to - c.origin) * (random.below(2) == 0 ? 1.0f : 0.0078125f);
  }
  c.tMin = 0;
  c.tMax = random.below(4) == 0 ? float(random.in(0, 4)) : INFINITY;
}

}  // namespace gxy::test

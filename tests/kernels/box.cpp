// SPDX-License-Identifier: Apache-2.0
// The slab test against 128-bit arithmetic, and the crossing function.
#include <gtest/gtest.h>

#include "random.h"

namespace gxy {
namespace {

using test::Random;
using wide = __float128;

struct Case {
  glm::vec3 lo, hi, origin, direction;
  float tMin, tMax;
};

// Does the ray meet the closed box within [tMin, tMax]? Without division: t = p / q is compared by cross products, which
// 128 bits hold nearly exactly (113 bits: 24 + 24 + 25, rounded differences included).
bool meetsExactly(const Case& c) {
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

// The same in double with a margin: true if the ray certainly misses.
bool missesClearly(const Case& c) {
  double enter = c.tMin, exit = c.tMax;
  for (int axis = 0; axis < 3; ++axis) {
    double o = c.origin[axis], d = c.direction[axis], lo = c.lo[axis], hi = c.hi[axis];
    if (d == 0) continue;
    double a = (lo - o) / d, b = (hi - o) / d;
    enter = std::max(enter, std::min(a, b));
    exit = std::min(exit, std::max(a, b));
  }
  return enter - exit > 1e-12 * (std::fabs(enter) + std::fabs(exit));
}

// One coordinate of a kind that hurts: zeros, shared values, neighbours, large and small ones; none denormal.
float coordinate(Random& random) {
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

void drawBox(Random& random, Case& c) {
  for (int axis = 0; axis < 3; ++axis) {
    float a = coordinate(random), b = random.below(16) == 0 ? a : coordinate(random);
    c.lo[axis] = std::min(a, b);
    c.hi[axis] = std::max(a, b);
  }
}

void drawRay(Random& random, Case& c) {
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

TEST(BoxSpan, NoHitOfExactArithmeticIsMissed) {
  Random random(5);
  int hits = 0, missed = 0;
  Case c{};
  for (int i = 0; i < 10'000'000; ++i) {
    if (i % 8 == 0) drawBox(random, c);
    drawRay(random, c);
    float tEnter, tExit;
    bool hit = single::boxSpan(c.lo, c.hi, c.origin, c.direction, c.tMin, c.tMax, tEnter, tExit);
    // The costly exact test is needed only where floats say no and doubles cannot decide, and on a share of the rest.
    if (hit ? i % 64 != 0 : missesClearly(c)) continue;
    bool truth = meetsExactly(c);
    hits += truth;
    missed += truth && !hit;
  }
  EXPECT_EQ(missed, 0);
  EXPECT_GT(hits, 10'000);
}

TEST(BoxSpan, SpanContainsTheExactOne) {
  Random random(6);
  Case c{};
  for (int i = 0; i < 200'000; ++i) {
    if (i % 8 == 0) drawBox(random, c);
    drawRay(random, c);
    float tEnter, tExit;
    double enter, exit;
    if (!twin::boxSpan(c.lo, c.hi, c.origin, c.direction, c.tMin, c.tMax, enter, exit)) continue;
    if (!meetsExactly(c)) continue;
    ASSERT_TRUE(single::boxSpan(c.lo, c.hi, c.origin, c.direction, c.tMin, c.tMax, tEnter, tExit));
    ASSERT_LE(tEnter, enter * (1 + 1.3e-7));
    if (std::isfinite(tExit)) {
      ASSERT_GE(tExit, exit * (1 - 4e-7));
      ASSERT_LE(tExit, exit * (1 + 8e-7));
    }
  }
}

TEST(BoxSpan, WideningAddsFewHits) {
  Random random(8);
  int hits = 0, extra = 0;
  for (int i = 0; i < 300'000; ++i) {
    Case c{glm::vec3(-1), glm::vec3(1), glm::vec3(random.point(-4, 4)), glm::vec3(random.direction()), 0,
           INFINITY};
    float tEnter, tExit;
    if (!single::boxSpan(c.lo, c.hi, c.origin, c.direction, 0, INFINITY, tEnter, tExit)) continue;
    ++hits;
    extra += !meetsExactly(c);
  }
  EXPECT_GT(hits, 10'000);
  EXPECT_LE(extra, hits / 10'000);
}

TEST(BoxSpan, ZeroComponentsOfEitherSignStayInsideOrOutside) {
  glm::vec3 lo(-1), hi(1);
  float a, b;
  for (float zero : {0.0f, -0.0f, 1e-40f, -1e-40f}) {
    glm::vec3 along(zero, zero, 1.0f);
    EXPECT_TRUE(single::boxSpan(lo, hi, {1, -1, -3}, along, 0, INFINITY, a, b));
    EXPECT_EQ(a, 2.0f);
    EXPECT_NEAR(b, 4.0f, 4e-6f);
    EXPECT_FALSE(single::boxSpan(lo, hi, {1.0000001f, 0, -3}, along, 0, INFINITY, a, b));
    EXPECT_FALSE(single::boxSpan(lo, hi, {0, 0, 3}, along, 0, INFINITY, a, b));
  }
}

TEST(BoxSpan, UnboundedBoxesAreMet) {
  float a, b;
  EXPECT_TRUE(
      single::boxSpan({-INFINITY, 0, 0}, {INFINITY, 1, 1}, {5, 0.5f, -1}, {1, 0, 1}, 0, INFINITY, a, b));
  EXPECT_EQ(a, 1.0f);
  EXPECT_NEAR(b, 2.0f, 2e-6f);
  EXPECT_TRUE(single::boxSpan(glm::vec3(-INFINITY), glm::vec3(INFINITY), {}, {0, -1, 0}, 0, INFINITY, a, b));
  EXPECT_EQ(a, 0.0f);
  EXPECT_EQ(b, INFINITY);
}

TEST(FaceCrossing, IsMonotoneInTheFace) {
  Random random(7);
  for (int i = 0; i < 20'000; ++i) {
    auto origin = float(random.in(-2, 2));
    auto direction = float(random.in(-1, 1) * random.scale(1e-9, 1));
    auto face = float(random.in(-2, 2));
    float before = single::faceCrossing(origin, direction, face);
    for (int k = 0; k < 20; ++k) {
      face = std::nextafter(face, 10.0f);
      float now = single::faceCrossing(origin, direction, face);
      ASSERT_GE(direction > 0 ? now : -now, direction > 0 ? before : -before);
      before = now;
    }
  }
}

TEST(FaceCrossing, ParallelRaysNeverCross) {
  for (float zero : {0.0f, -0.0f, 1e-40f}) {
    EXPECT_EQ(single::faceAfter(0.5f, zero, 0.5f), INFINITY);
    EXPECT_EQ(single::faceBefore(0.5f, zero, 0.5f), -INFINITY);
  }
  EXPECT_EQ(single::faceAfter(0.5f, 0.25f, 1.0f), 2.0f);
  EXPECT_EQ(single::faceBefore(0.5f, -0.25f, 0.25f), 1.0f);
}

}  // namespace
}  // namespace gxy

// SPDX-License-Identifier: Apache-2.0
// The slab test against 128-bit arithmetic, and the crossing function.
#include <gtest/gtest.h>

#include "tests/kernels/box_cases.h"
#include "tests/support/seeds.h"

namespace gxy {
namespace {

using namespace test;
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

TEST(BoxSpan, NoHitOfExactArithmeticIsMissed) {
  Random random(5);
  int hits = 0, missed = 0;
  Case c{};
  for (int i = 0; i < sweep(10'000'000); ++i) {
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
  EXPECT_GT(hits, sweep(10'000));
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

// SPDX-License-Identifier: Apache-2.0
// The round cone against its definition: the union of the spheres along the segment, whose signed distance
// min over s of |p - c(s)| - r(s) is convex in (t, s), so that nested ternary searches find the truth.
#include <gtest/gtest.h>

#include "tests/kernels/random.h"

namespace gxy {
namespace {

using test::Random;

struct Cone {
  glm::vec3 a, b;
  float ra, rb;
};

double distance(const Cone& c, glm::dvec3 p) {
  auto at = [&](double s) {
    return glm::distance(p, glm::mix(glm::dvec3(c.a), glm::dvec3(c.b), s)) -
           (c.ra + s * (double(c.rb) - c.ra));
  };
  double lo = 0, hi = 1;
  for (int i = 0; i < 50; ++i) {
    double m0 = lo + (hi - lo) * 0.4, m1 = lo + (hi - lo) * 0.6;
    if (at(m0) < at(m1)) {
      hi = m1;
    } else {
      lo = m0;
    }
  }
  return std::min({at(0.5 * (lo + hi)), at(0), at(1)});
}

// The least distance along the ray's positive part.
double leastDistance(const Cone& c, glm::dvec3 o, glm::dvec3 d, double tMax) {
  double lo = 0, hi = tMax;
  for (int i = 0; i < 45; ++i) {
    double m0 = lo + (hi - lo) * 0.4, m1 = lo + (hi - lo) * 0.6;
    if (distance(c, o + m0 * d) < distance(c, o + m1 * d)) {
      hi = m1;
    } else {
      lo = m0;
    }
  }
  return distance(c, o + 0.5 * (lo + hi) * d);
}

Cone makeCone(Random& random) {
  Cone c{glm::vec3(random.point(-1, 1)), glm::vec3(random.point(-1, 1)), float(random.in(0.02, 0.5)),
         float(random.in(0.02, 0.5))};
  switch (random.below(8)) {
    case 0:
      c.rb = c.ra;
      break;
    case 1:
      c.rb = 0;
      break;
    case 2:
      c.b = c.a;
      break;
    case 3:
      c.b = c.a + 0.05f * glm::vec3(random.direction());
      break;  // often nested
    default:
      break;
  }
  return c;
}

glm::vec3 target(Random& random, const Cone& c) {
  double s = random.unit();
  glm::dvec3 p = glm::mix(glm::dvec3(c.a), glm::dvec3(c.b), s);
  return glm::vec3(p + (c.ra + s * (double(c.rb) - c.ra)) * random.in(0, 1.6) * random.direction());
}

TEST(RoundCone, HitsWhatTheDefinitionHitsAndOnItsSurface) {
  Random random(21);
  int hits = 0, misses = 0;
  for (int i = 0; i < 1'000; ++i) {
    Cone c = makeCone(random);
    glm::vec3 o(3.0 * random.direction());
    glm::vec3 d = glm::normalize(target(random, c) - o);
    float t, axial;
    glm::vec3 n;
    bool hit = single::hitRoundCone(o, d, c.a, c.b, c.ra, c.rb, 0, t, n, axial);
    double least = leastDistance(c, o, d, 8);
    if (std::fabs(least) < 2e-6) continue;
    ASSERT_EQ(hit, least < 0) << least;
    hits += hit;
    misses += !hit;
    if (!hit) continue;
    // The sphere that axial names touches the surface here, and the normal is its.
    glm::dvec3 p = glm::dvec3(o) + double(t) * glm::dvec3(d);
    ASSERT_NEAR(distance(c, p), 0, 5e-6);
    ASSERT_GE(axial, 0.0f);
    ASSERT_LE(axial, 1.0f);
    glm::dvec3 centre = glm::mix(glm::dvec3(c.a), glm::dvec3(c.b), double(axial));
    double radius = c.ra + axial * (double(c.rb) - c.ra);
    ASSERT_LE(glm::distance(centre + radius * glm::dvec3(n), p), 2e-5);
    // First: nothing of the body lies before it.
    ASSERT_GE(leastDistance(c, o, d, t * (1 - 1e-5)), -5e-6);
  }
  EXPECT_GT(hits, 500);
  EXPECT_GT(misses, 50);
}

TEST(RoundCone, FarRaysHitLikeNearOnes) {
  Random random(22);
  int hits = 0, grazing = 0;
  for (int i = 0; i < 50'000; ++i) {
    Cone c = makeCone(random);
    double size = std::max(c.ra, c.rb);
    glm::vec3 o(1e4 * size * random.direction());
    glm::dvec3 d = glm::normalize(glm::dvec3(target(random, c)) - glm::dvec3(o));
    glm::vec3 df(d);
    float t, axial;
    double tTwin, axialTwin;
    glm::vec3 n;
    glm::dvec3 nTwin;
    bool hit = single::hitRoundCone(o, df, c.a, c.b, c.ra, c.rb, 0, t, n, axial);
    bool truth = twin::hitRoundCone(o, df, c.a, c.b, c.ra, c.rb, 0, tTwin, nTwin, axialTwin);
    grazing += hit != truth;
    if (!hit || !truth) continue;
    ++hits;
    double slant = std::fabs(glm::dot(nTwin, glm::dvec3(df)));
    ASSERT_NEAR(t, tTwin, 1e-3 * size + 1e-6 / std::max(slant, 1e-3));
    // The hit is off by ulps of the segment, which turn the normal by their share of the radius there, the more
    // the steeper the cone (m: its squared cosine); at a joint cone and cap tie to second order (5e-4).
    double length = glm::distance(glm::dvec3(c.a), glm::dvec3(c.b));
    double slope = length > 0 ? (double(c.ra) - c.rb) / length : 1;
    double m = std::fabs(slope) < 1 ? 1 - slope * slope : 1;
    double radius = c.ra + axialTwin * (double(c.rb) - c.ra);
    double turn = 3e-7 * (length + size) / (radius * m);
    ASSERT_LE(glm::distance(glm::dvec3(n), nTwin), 5e-4 + turn / std::max(slant, 1e-3));
  }
  EXPECT_GT(hits, 20'000);
  EXPECT_LE(grazing, 5);
}

TEST(RoundCone, SplitConeIsTheWholeCone) {
  Random random(23);
  for (int i = 0; i < 50'000; ++i) {
    Cone c{{-1, 0, 0}, {1, 0.5f, 0}, 0.25f, 0.5f};
    glm::vec3 middle = 0.5f * (c.a + c.b);
    float rm = 0.375f;
    glm::vec3 o(4.0 * random.direction());
    // Aimed around the joint.
    glm::vec3 d = glm::normalize(middle + 0.36f * glm::vec3(random.direction()) - o);
    float tWhole, t0, t1, s, s0, s1;
    glm::vec3 n, n0, n1;
    bool whole = single::hitRoundCone(o, d, c.a, c.b, c.ra, c.rb, 0, tWhole, n, s);
    bool first = single::hitRoundCone(o, d, c.a, middle, c.ra, rm, 0, t0, n0, s0);
    bool second = single::hitRoundCone(o, d, middle, c.b, rm, c.rb, 0, t1, n1, s1);
    ASSERT_EQ(whole, first || second);
    if (!whole) continue;
    // At the joint the two touch to second order, so which of them is hit shifts s by the root of the rounding.
    bool useFirst = first && (!second || t0 <= t1);
    float slant = std::max(std::fabs(glm::dot(n, d)), 0.01f);
    ASSERT_NEAR(useFirst ? t0 : t1, tWhole, 2e-6 / slant);
    ASSERT_NEAR(useFirst ? 0.5f * s0 : 0.5f + 0.5f * s1, s, 5e-4);
    ASSERT_LE(glm::distance(useFirst ? n0 : n1, n), 1e-3f);
  }
}

TEST(RoundCone, DegenerateCasesAreTheBiggerSphere) {
  Random random(24);
  const Cone cases[] = {{{0, 0, 0}, {0, 0, 0}, 0.5f, 0.25f},     {{0, 0, 0}, {0, 0, 0}, 0.25f, 0.5f},
                        {{0, 0, 0}, {0.2f, 0, 0}, 0.5f, 0.25f},  {{0.2f, 0, 0}, {0, 0, 0}, 0.25f, 0.5f},
                        {{0, 0, 0}, {0.25f, 0, 0}, 0.5f, 0.25f}, {{0, 0, 0}, {0, 0, 0}, 0.5f, 0.5f}};
  for (const Cone& c : cases) {
    for (int i = 0; i < 5'000; ++i) {
      glm::vec3 o(2.0 * random.direction());
      glm::vec3 d = glm::normalize(glm::vec3(random.point(-0.6, 0.6)) - o);
      float t, tSphere, axial;
      glm::vec3 n, nSphere;
      bool sphere = single::hitSphere(o, d, {0, 0, 0}, 0.5f, 0, tSphere, nSphere);
      ASSERT_EQ(single::hitRoundCone(o, d, c.a, c.b, c.ra, c.rb, 0, t, n, axial), sphere);
      if (!sphere) continue;
      ASSERT_NEAR(t, tSphere, 1e-6);
      ASSERT_EQ(axial, c.rb > c.ra ? 1.0f : 0.0f);
    }
  }
  float t, axial;
  glm::vec3 n;
  EXPECT_FALSE(single::hitRoundCone({-2, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}, 0, 0, 0, t, n, axial));
}

TEST(RoundCone, AxialIsExactlyOneOnTheBallAtB) {
  Random random(45);
  int caps = 0;
  for (int i = 0; i < 20'000; ++i) {
    const glm::vec3 a(random.point(-1, 1)), b(random.point(-1, 1));
    if (glm::distance(a, b) < 0.2f) continue;
    const glm::vec3 u = glm::normalize(b - a), o = b + 3.f * u + 0.02f * glm::vec3(random.point(-1, 1));
    float t, axial;
    glm::vec3 n;
    ASSERT_TRUE(single::hitRoundCone(o, -u, a, b, 0.1f, 0.1f, 0, t, n, axial));
    EXPECT_EQ(axial, 1.f);
    caps++;
  }
  EXPECT_GT(caps, 15'000);
}

TEST(RoundCone, AxisParallelRayMeetsCapsAndLeavesThroughTheOther) {
  float t, axial;
  glm::vec3 n;
  ASSERT_TRUE(single::hitRoundCone({-5, 0, 0}, {1, 0, 0}, {0, 0, 0}, {2, 0, 0}, 0.5f, 0.25f, 0, t, n, axial));
  EXPECT_NEAR(t, 4.5f, 1e-6);
  EXPECT_EQ(axial, 0.0f);
  EXPECT_NEAR(n.x, -1, 1e-6);
  ASSERT_TRUE(single::hitRoundCone({1, 0, 0}, {1, 0, 0}, {0, 0, 0}, {2, 0, 0}, 0.5f, 0.25f, 0, t, n, axial));
  EXPECT_NEAR(t, 1.25f, 1e-6);
  EXPECT_EQ(axial, 1.0f);
  EXPECT_NEAR(n.x, 1, 1e-6);
}

}  // namespace
}  // namespace gxy

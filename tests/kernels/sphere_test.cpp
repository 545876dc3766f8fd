// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "tests/kernels/random.h"

namespace gxy {
namespace {

using test::Random;
using lvec3 = glm::vec<3, long double>;

// The entry in long double, of the very floats that the kernel sees; < 0 for a miss. impact: distance of line and centre.
long double exactEntry(lvec3 origin, lvec3 direction, lvec3 centre, long double radius, long double& impact) {
  lvec3 f = origin - centre;
  long double dd = glm::dot(direction, direction);
  long double middle = -glm::dot(f, direction) / dd;
  lvec3 nearest = f + middle * direction;
  impact = std::sqrt(glm::dot(nearest, nearest));
  if (impact > radius) return -1;
  return middle - std::sqrt((radius * radius - impact * impact) / dd);
}

TEST(Sphere, FromTenThousandRadiiNoneIsMissedAndErrorIsBelowAThousandthRadius) {
  Random random(11);
  int hits = 0;
  double worstT = 0, worstPoint = 0;
  for (int i = 0; i < 200'000; ++i) {
    double scale = random.scale(1e-3, 1e3);
    auto radius = float(scale * random.in(0.1, 1));
    glm::vec3 centre(random.point(-scale, scale));
    glm::dvec3 away = random.direction();
    glm::vec3 origin(glm::dvec3(centre) + 1e4 * double(radius) * away);
    glm::dvec3 aside = glm::normalize(glm::cross(away, random.direction()));
    double offset = radius * (random.below(4) == 0 ? 1 - random.scale(1e-6, 1) : random.unit());
    glm::vec3 direction(glm::normalize(glm::dvec3(centre) + offset * aside - glm::dvec3(origin)));
    long double impact;
    long double truth = exactEntry(origin, direction, centre, radius, impact);
    float t;
    glm::vec3 normal;
    bool hit = single::hitSphere(origin, direction, centre, radius, 0, t, normal);
    if (std::fabs(impact - radius) < 2e-7L * radius) continue;  // tangent: either answer is right
    ASSERT_EQ(hit, truth > 0) << "impact " << double(impact / radius);
    if (!hit) continue;
    ++hits;
    worstT = std::max(worstT, double(std::fabs(t - truth) / radius));
    lvec3 point = lvec3(origin) + truth * lvec3(direction);
    lvec3 error = lvec3(centre) + lvec3(normal) * (long double)(radius)-point;
    worstPoint = std::max(worstPoint, double(glm::length(error) / radius));
  }
  EXPECT_GT(hits, 150'000);
  EXPECT_LE(worstT, 1e-3);
  EXPECT_LE(worstPoint, 1e-3);
}

TEST(Sphere, FloatMatchesTheTwin) {
  Random random(12);
  int hits = 0;
  for (int i = 0; i < 200'000; ++i) {
    glm::vec3 centre(random.point(-1, 1)), origin(random.point(-3, 3)), direction(random.direction());
    auto radius = float(random.in(0.01, 1));
    float t;
    double tTwin;
    glm::vec3 n;
    glm::dvec3 nTwin;
    long double impact;
    exactEntry(origin, direction, centre, radius, impact);
    if (std::fabs(impact - radius) < 1e-4L * radius) continue;
    if (std::fabs(glm::distance(origin, centre) - radius) < 1e-4f) continue;
    bool hit = single::hitSphere(origin, direction, centre, radius, 0, t, n);
    ASSERT_EQ(hit, twin::hitSphere(origin, direction, centre, radius, 0, tTwin, nTwin));
    if (!hit) continue;
    ++hits;
    ASSERT_NEAR(t, tTwin, 1e-5 * radius + 1e-6);
    ASSERT_LE(glm::distance(glm::dvec3(n), nTwin), 2e-5);
  }
  EXPECT_GT(hits, 3'000);
}

TEST(Sphere, OriginInsideHitsTheFarSide) {
  float t;
  glm::vec3 n;
  ASSERT_TRUE(single::hitSphere({0.5f, 0, 0}, {1, 0, 0}, {0, 0, 0}, 2, 0, t, n));
  EXPECT_EQ(t, 1.5f);
  EXPECT_EQ(n, glm::vec3(1, 0, 0));
  ASSERT_TRUE(single::hitSphere({-5, 0, 0}, {1, 0, 0}, {0, 0, 0}, 2, 3.5f, t, n));
  EXPECT_EQ(t, 7.0f);
  EXPECT_FALSE(single::hitSphere({-5, 0, 0}, {1, 0, 0}, {0, 0, 0}, 2, 7.0f, t, n));
  EXPECT_FALSE(single::hitSphere({-5, 0, 0}, {-1, 0, 0}, {0, 0, 0}, 2, 0, t, n));
}

TEST(Sphere, ZeroRadiusIsNeverHit) {
  float t;
  glm::vec3 n;
  EXPECT_FALSE(single::hitSphere({-1, 0, 0}, {1, 0, 0}, {0, 0, 0}, 0, 0, t, n));
  EXPECT_FALSE(single::hitSphere({-1, 0, 0}, {1, 0, 0}, {0, 0, 0}, -1, 0, t, n));
}

TEST(Sphere, DirectionNeedNotBeUnit) {
  float t;
  glm::vec3 n;
  ASSERT_TRUE(single::hitSphere({-5, 0, 0}, {4, 0, 0}, {0, 0, 0}, 1, 0, t, n));
  EXPECT_EQ(t, 1.0f);
}

}  // namespace
}  // namespace gxy

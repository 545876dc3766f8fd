// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <vector>

#include "tests/kernels/random.h"

namespace gxy {
namespace {

using test::Random;

TEST(OcclusionDirection, IsUnitAndInTheHemisphere) {
  Random random(51);
  for (int i = 0; i < 200'000; ++i) {
    glm::vec3 n(random.direction());
    if (i < 6) n = glm::vec3(i % 3 == 0, i % 3 == 1, i % 3 == 2) * (i < 3 ? 1.0f : -1.0f);
    glm::vec3 d = single::occlusionDirection(n, uint32_t(random.bits()), 0, 0, uint32_t(i), 16);
    ASSERT_NEAR(glm::length(d), 1.0f, 1e-6f);
    ASSERT_GT(glm::dot(n, d), 0.0f);
  }
}

TEST(OcclusionDirection, FollowsTheCosine) {
  // Density cos / pi: the mean of cos is 2/3, of cos^2 1/2, of each tangential component 0.
  glm::vec3 n = glm::normalize(glm::vec3(1, -2, 3));
  glm::dvec3 sum(0);
  double cosine = 0, square = 0;
  const int count = 1 << 18;
  for (int k = 0; k < count; ++k) {
    glm::vec3 d = single::occlusionDirection(n, 7, 1, 0, uint32_t(k), count);
    double c = glm::dot(n, d);
    cosine += c / count;
    square += c * c / count;
    sum += glm::dvec3(d) / double(count);
  }
  EXPECT_NEAR(cosine, 2.0 / 3, 1e-4);
  EXPECT_NEAR(square, 0.5, 1e-4);
  EXPECT_LE(glm::length(sum - 2.0 / 3 * glm::dvec3(n)), 2e-4);
}

// The largest difference between the share of points in [0, x) x [0, y) and its area, over corners at the points.
double starDiscrepancy(const std::vector<glm::dvec2>& points) {
  double worst = 0;
  for (glm::dvec2 a : points) {
    for (glm::dvec2 b : points) {
      int open = 0, closed = 0;
      for (glm::dvec2 p : points) {
        open += p.x < a.x && p.y < b.y;
        closed += p.x <= a.x && p.y <= b.y;
      }
      double area = a.x * b.y, n = double(points.size());
      worst = std::max({worst, area - open / n, closed / n - area});
    }
  }
  return worst;
}

TEST(LowDiscrepancyPoint, SpreadsBetterThanRandomPoints) {
  Random random(52);
  for (int n : {16, 64, 128}) {
    double ours = 0, theirs = 0;
    for (int trial = 0; trial < 8; ++trial) {
      std::vector<glm::dvec2> low, uniform;
      for (int k = 0; k < n; ++k) {
        float x, y;
        single::lowDiscrepancyPoint(uint32_t(1000 * trial + k), uint32_t(trial), x, y);
        ASSERT_TRUE(x >= 0 && x < 1 && y >= 0 && y < 1);
        low.emplace_back(x, y);
        double u = random.unit();
        uniform.emplace_back(u, random.unit());
      }
      ours += starDiscrepancy(low);
      theirs += starDiscrepancy(uniform);
    }
    EXPECT_LT(ours, (n < 64 ? 0.85 : 0.7) * theirs) << n;
  }
}

TEST(OcclusionDirection, FramesConvergeFasterThanRandomOnes) {
  // Occluder: a half space that hides directions with d.x > 0.3 around n = z. 64 frames of 4 rays.
  const glm::vec3 n(0, 0, 1);
  const double truth = 0.5 - (0.3 * std::sqrt(1 - 0.09) + std::asin(0.3)) / std::numbers::pi;
  double squares = 0;
  for (uint32_t pixel = 0; pixel < 256; ++pixel) {
    int hidden = 0;
    for (uint32_t frame = 0; frame < 64; ++frame)
      for (uint32_t k = 0; k < 4; ++k)
        hidden += single::occlusionDirection(n, pixel, 0, frame, k, 4).x > 0.3f;
    double error = hidden / 256.0 - truth;
    squares += error * error / 256;
  }
  double random = std::sqrt(truth * (1 - truth) / 256);
  EXPECT_LT(std::sqrt(squares), 0.5 * random);
}

TEST(Hash, FlipsHalfOfTheBits) {
  for (int bit = 0; bit < 32; ++bit) {
    double flips = 0;
    for (uint32_t x = 0; x < 4096; ++x)
      flips += std::popcount(single::hash1(x) ^ single::hash1(x ^ (1u << bit))) / 4096.0;
    EXPECT_NEAR(flips, 16, 1) << bit;
  }
}

TEST(Tangents, AreOrthonormal) {
  Random random(53);
  for (int i = 0; i < 100'000; ++i) {
    glm::vec3 n(random.direction());
    if (i == 0) n = {0, 0, -1};
    glm::vec3 s, t;
    single::tangents(n, s, t);
    ASSERT_NEAR(glm::length(s), 1, 1e-6);
    ASSERT_NEAR(glm::length(t), 1, 1e-6);
    ASSERT_LE(std::max({std::fabs(glm::dot(s, t)), std::fabs(glm::dot(n, s)), std::fabs(glm::dot(n, t))}),
              1e-6);
    ASSERT_GT(glm::dot(glm::cross(s, t), n), 0.99f);
  }
}

TEST(Light, LambertAndPhongAreTheirFormulas) {
  Random random(54);
  for (int i = 0; i < 50'000; ++i) {
    glm::vec3 n(random.direction()), l(random.direction()), e(random.direction());
    auto exponent = float(random.in(1, 200));
    double facing = glm::dot(glm::dvec3(n), glm::dvec3(l));
    ASSERT_NEAR(single::lambert(n, l), std::max(facing, 0.0), 2e-7);
    double mirrored = glm::dot(glm::reflect(-glm::dvec3(l), glm::dvec3(n)), glm::dvec3(e));
    double truth = facing > 0 && mirrored > 0 ? std::pow(std::min(mirrored, 1.0), exponent) : 0;
    if (std::fabs(facing) < 1e-6) continue;
    ASSERT_NEAR(single::phong(n, l, e, exponent), truth, 1e-6 + 1e-6 * exponent);
  }
  EXPECT_EQ(single::phong({0, 0, 1}, {0, 0, 1}, {0, 0, 1}, 50), 1.0f);
  EXPECT_EQ(single::phong({0, 0, 1}, {0, 0, -1}, {0, 0, -1}, 50), 0.0f);
  EXPECT_EQ(single::lambert({0, 0, 1}, {0, 0, -1}), 0.0f);
}

}  // namespace
}  // namespace gxy

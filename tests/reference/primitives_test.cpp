// SPDX-License-Identifier: Apache-2.0
#include "core/reference/primitives.h"

#include <gtest/gtest.h>

#include "core/reference/bvh.h"
#include "tests/reference/samples.h"

namespace gxy::reference {
namespace {

TEST(Ball, SeenFrom10000RadiiIsNeverMissedAndExact) {
  Uniform random(1);
  for (int i = 0; i < 10000; i++) {
    const glm::dvec3 eye = 1e4 * glm::normalize(random.inCube(1));
    const glm::dvec3 side = glm::normalize(glm::cross(eye, random.inCube(1)));
    const double off = 0.999 * random();
    const Ray ray{eye, glm::normalize(off * side - eye)};
    const Crossing c = cross(Ball{glm::dvec3(0), 1}, ray);
    ASSERT_TRUE(c.hit);
    EXPECT_NEAR(glm::length(ray.at(c.in)), 1, 1e-10);
    EXPECT_NEAR(glm::length(ray.at(c.out)), 1, 1e-10);
  }
}

TEST(Ball, RadiusZeroIsNeverHit) { EXPECT_FALSE(cross(Ball{glm::dvec3(0), 0}, {{0, 0, -1}, {0, 0, 1}}).hit); }

TEST(RoundCone, CylinderAndCapsMatchClosedForms) {
  const RoundCone tube{{{-1, 0, 0}, 0.25}, {{1, 0, 0}, 0.25}};
  const Crossing across = cross(tube, {{0.3, 0.15, -5}, {0, 0, 1}});
  ASSERT_TRUE(across.hit);
  EXPECT_NEAR(across.in, 5 - 0.2, 1e-14);
  EXPECT_NEAR(across.out, 5 + 0.2, 1e-14);
  const Crossing lengthwise = cross(tube, {{-5, 0, 0}, {1, 0, 0}});
  EXPECT_NEAR(lengthwise.in, 3.75, 1e-14);
  EXPECT_NEAR(lengthwise.out, 6.25, 1e-14);
  EXPECT_FALSE(cross(tube, {{0.3, 0.2501, -5}, {0, 0, 1}}).hit);
}

TEST(RoundCone, HitsLieOnTheSurfaceAndNothingBeforeThem) {
  Uniform random(8);
  int hits = 0;
  for (int i = 0; i < 3000; i++) {
    const RoundCone cone{{random.inCube(1), random.in(0.01, 0.5)}, {random.inCube(1), random.in(0.01, 0.5)}};
    const glm::dvec3 eye = 5.0 * glm::normalize(random.inCube(1));
    const Ray ray{eye, glm::normalize(random.inCube(1) - eye)};
    const Crossing c = cross(cone, ray);
    // The hull's depth along the ray, densely: the surface must be where it turns positive.
    double deepest = -1;
    for (double t = 3; t < 7; t += 0.01) deepest = std::max(deepest, cone.depth(ray.at(t)));
    if (!c.hit) {
      EXPECT_LE(deepest, 1e-12);
      continue;
    }
    hits++;
    EXPECT_NEAR(cone.depth(ray.at(c.in)), 0, 1e-11);
    EXPECT_NEAR(cone.depth(ray.at(c.out)), 0, 1e-11);
    EXPECT_LT(cone.depth(ray.at(c.in - 1e-3)), 0);
    EXPECT_LT(cone.depth(ray.at(c.out + 1e-3)), 0);
    EXPECT_LE(glm::dot(cone.normal(ray.at(c.in)), ray.direction), 1e-5);
  }
  EXPECT_GT(hits, 300);
}

TEST(RoundCone, AxialPlaceIsThatOfTheTouchingBall) {
  const RoundCone cone{{{0, 0, 0}, 0.5}, {{2, 0, 0}, 0.1}};
  const double sine = 0.2, cosine = std::sqrt(1 - sine * sine);
  for (double u : {0.0, 0.3, 1.0}) {
    const glm::dvec3 out(sine, cosine, 0), p = glm::dvec3(2 * u, 0, 0) + (0.5 - 0.4 * u) * out;
    EXPECT_NEAR(cone.axial(p), u, 1e-14);
    EXPECT_NEAR(cone.depth(p), 0, 1e-14);
    EXPECT_NEAR(glm::dot(cone.normal(p), out), 1, 1e-14);
  }
}

TEST(RoundCone, ABallThatHoldsTheOtherIsAll) {
  const RoundCone cone{{{0, 0, 0}, 1}, {{0.3, 0, 0}, 0.2}};
  EXPECT_NEAR(cross(cone, {{0, 0, -3}, {0, 0, 1}}).in, 2, 1e-15);
  const RoundCone point{{{0, 0, 0}, 0.5}, {{0, 0, 0}, 0.5}};
  EXPECT_NEAR(cross(point, {{0, 0, -3}, {0, 0, 1}}).in, 2.5, 1e-15);
}

TEST(Triangle, DepthAndWeightsMatchThePlane) {
  const std::array<glm::dvec3, 3> triangle{glm::dvec3(0, 0, 2), {1, 0, 2}, {0, 1, 3}};
  const TriangleHit hit = cross(triangle, {{0.2, 0.3, 0}, {0, 0, 1}});
  ASSERT_TRUE(hit.hit);
  EXPECT_NEAR(hit.t, 2.3, 1e-15);
  EXPECT_NEAR(hit.weights.y, 0.2, 1e-15);
  EXPECT_NEAR(hit.weights.z, 0.3, 1e-15);
  EXPECT_FALSE(cross({glm::dvec3(0), {1, 1, 1}, {2, 2, 2}}, {{0, 0, -1}, {0, 0, 1}}).hit);
}

TEST(Triangle, ClosedMeshLetsNoRayOutThroughEdgesAndVertices) {
  // An octahedron, also far from the origin.
  for (double shift : {0.0, 1e5}) {
    std::array<glm::dvec3, 6> p;
    for (int i = 0; i < 6; i++) {
      p[i] = glm::dvec3(shift);
      p[i][i / 2] += i % 2 ? 1 : -1;
    }
    Uniform random(6);
    for (int i = 0; i < 20000; i++) {
      const Ray inside{glm::dvec3(shift) + random.inCube(0.1), {}};
      glm::dvec3 target = random.inCube(1) + shift;
      if (i % 3 == 0) target = p[i % 6];                                         // a vertex
      if (i % 3 == 1) target = p[i % 2] + random() * (p[2 + i % 4] - p[i % 2]);  // an edge
      const Ray ray{inside.origin, glm::normalize(target - inside.origin)};
      bool hit = false;
      for (int face = 0; face < 8 && !hit; face++) {
        const TriangleHit h = cross({p[face & 1], p[2 + (face >> 1 & 1)], p[4 + (face >> 2)]}, ray);
        hit = h.hit && h.t > 0;
      }
      ASSERT_TRUE(hit) << "ray " << i << " shifted by " << shift;
    }
  }
}

TEST(Bvh, FindsWhatTestingEveryBoxFinds) {
  Uniform random(21);
  std::vector<Ball> balls(500);
  std::vector<Box> boxes;
  for (Ball& b : balls) {
    b = {random.inCube(1), random.in(0, 0.1)};
    boxes.push_back({b.centre - b.radius, b.centre + b.radius});
  }
  const Bvh tree(boxes);
  for (int i = 0; i < 500; i++) {
    Ray ray{random.inCube(2), random.inCube(1)};
    if (i % 4 == 0) ray.direction = {0, 0, i % 8 ? 1 : -1};
    ray.direction = glm::normalize(ray.direction);
    double expected = kInfinity, found = kInfinity;
    auto consider = [&](const Ball& ball, double& best) {
      const Crossing c = cross(ball, ray);
      if (c.hit && c.in > 0) best = std::min(best, c.in);
    };
    for (const Ball& ball : balls) consider(ball, expected);
    tree.traverse(
        ray, 0, [&] { return found; }, [&](uint32_t item) { consider(balls[item], found); });
    EXPECT_EQ(found, expected);
  }
}

}  // namespace
}  // namespace gxy::reference

// SPDX-License-Identifier: Apache-2.0
#include "core/reference/isosurface.h"

#include <gtest/gtest.h>

#include "core/comm/error.h"
#include "core/reference/cells.h"
#include "tests/reference/samples.h"

namespace gxy::reference {
namespace {

TEST(Cubic, RootsAreThoseItWasMadeFrom) {
  Uniform random(11);
  for (int i = 0; i < 2000; i++) {
    std::array<double, 3> r{random(), random(), random()};
    std::sort(r.begin(), r.end());
    if (r[1] - r[0] < 1e-3 || r[2] - r[1] < 1e-3) continue;
    // Blossom of (s - r0)(s - r1)(s - r2).
    auto blossom = [&](double x, double y, double z) {
      return x * y * z - (r[0] + r[1] + r[2]) * (x * y + y * z + z * x) / 3 +
             (r[0] * r[1] + r[1] * r[2] + r[2] * r[0]) * (x + y + z) / 3 - r[0] * r[1] * r[2];
    };
    const Cubic cubic{{blossom(0, 0, 0), blossom(0, 0, 1), blossom(0, 1, 1), blossom(1, 1, 1)}};
    const Roots found = roots(cubic, 0);
    ASSERT_EQ(found.count, 3);
    for (int k = 0; k < 3; k++) EXPECT_NEAR(found.s[k], r[k], 1e-9);
  }
}

TEST(Cubic, AlongARayIsTheTrilinearField) {
  Uniform random(5);
  for (int i = 0; i < 200; i++) {
    CellCorners corners;
    for (double& c : corners) c = random();
    const glm::dvec3 p = random.inCube(0.5) + 0.5, q = random.inCube(0.5) + 0.5;
    const Cubic cubic = alongRay(corners, p, q);
    const double s = random();
    EXPECT_NEAR(cubic.value(s), trilinear(corners, p + s * (q - p)), 1e-14);
    EXPECT_LE(cubic.min(), cubic.value(s));
    EXPECT_GE(cubic.max(), cubic.value(s));
  }
}

TEST(CellWalk, CoversTheGridWithoutGapOrOverlap) {
  const Grid grid{{-1, -2, 0}, {0.5, 0.25, 1}, {7, 9, 4}};
  Uniform random(2);
  for (int i = 0; i < 500; i++) {
    Ray ray{random.inCube(4), random.inCube(1)};
    if (i % 5 == 0) ray.direction[i % 3] = 0;  // parallel to an axis plane
    if (i % 7 == 0) ray.origin = {-1 + 0.5 * (i % 6), -2 + 0.25 * (i % 8), i % 3};  // from a grid point
    ray.direction = glm::normalize(ray.direction);
    double reached = -1;
    for (CellWalk walk(grid, ray); walk.inside(); walk.advance()) {
      if (reached >= 0) {
        ASSERT_EQ(walk.entry(), reached);
      }
      ASSERT_GT(walk.exit(), walk.entry());
      reached = walk.exit();
      const glm::dvec3 middle = (ray.at(0.5 * (walk.entry() + walk.exit())) - grid.origin) / grid.spacing;
      for (int a = 0; a < 3; a++) {
        ASSERT_GE(middle[a], double(walk.cell()[a]) - 1e-12);
        ASSERT_LE(middle[a], double(walk.cell()[a] + 1) + 1e-12);
      }
    }
  }
}

TEST(FirstRoot, MarschnerLobbMatchesDenseBisection) {
  const Grid grid = cube(41);
  const Field field(makeVolume(grid, marschnerLobb), std::nullopt);
  Uniform random(19);
  int hits = 0, doubles = 0;
  for (int i = 0; i < 200; i++) {
    const glm::dvec3 origin = 3.0 * glm::normalize(random.inCube(1));
    const Ray ray{origin, glm::normalize(random.inCube(0.8) - origin)};
    auto f = [&](double t) { return field.value(ray.at(t)).value_or(-1) - 0.5; };
    // Signs at steps of 1/200 of a cell, from inside the box on.
    double lo = 0, expected = -1;
    const double step = grid.spacing.x / 200;
    while (lo < 6 && !field.value(ray.at(lo))) lo += step;
    for (; lo < 6 && field.value(ray.at(lo + step)); lo += step) {
      if ((f(lo) < 0) == (f(lo + step) < 0)) continue;
      double hi = lo + step, at = lo;
      for (int k = 0; k < 60; k++) (((f(0.5 * (at + hi)) < 0) == (f(at) < 0)) ? at : hi) = 0.5 * (at + hi);
      expected = at;
      break;
    }
    const auto found = firstRoot(field, ray, 0.5);
    if (expected < 0) {
      // What the steps cannot see: a pair of roots closer than one step, or a root in the first or last step.
      EXPECT_NEAR(found ? f(*found) : 0, 0, 1e-9);
      continue;
    }
    hits++;
    ASSERT_TRUE(found);
    EXPECT_LE(*found, expected + 1e-10);
    // A pair of roots closer than one step may come first; what is found must be a root in any case.
    EXPECT_NEAR(f(*found), 0, 1e-9);
    doubles += *found < expected - 1e-10;
  }
  EXPECT_GT(hits, 100);
  EXPECT_LE(doubles, 1);
}

TEST(FirstRoot, LinearFieldIsHitExactlyAtEveryIsovalue) {
  const Field field(makeVolume(cube(9), [](glm::dvec3 p) { return p.x; }), std::nullopt);
  const Ray ray{{-3, 0.1, 0.2}, {1, 0, 0}};
  for (double isovalue :
       {-1.0, -0.75, -0.6, 0.0, 0.25, 0.9, 1.0}) {  // sample values, minimum and maximum among them
    const auto t = firstRoot(field, ray, isovalue);
    ASSERT_TRUE(t) << isovalue;
    EXPECT_NEAR(*t, isovalue + 3, 1e-15 * 8) << isovalue;
    EXPECT_FALSE(firstRoot(field, ray, isovalue, {}, *t)) << "no root is found twice, not even on a face";
  }
  EXPECT_FALSE(firstRoot(field, ray, 1.0000001));
}

TEST(FirstRoot, PlateauIsHitOnceWhereTheRayEntersIt) {
  const Field field(makeVolume(cube(9), [](glm::dvec3 p) { return std::abs(p.x) <= 0.5 ? 0.3f : p.x; }),
                    std::nullopt);
  const double isovalue = 0.3f;
  const Ray ray{{-3, 0.1, 0.2}, {1, 0, 0}};
  const auto first = firstRoot(field, ray, isovalue);
  ASSERT_TRUE(first);
  EXPECT_DOUBLE_EQ(*first, 2.5);
  EXPECT_FALSE(firstRoot(field, ray, isovalue, {}, *first));
  const auto inside = firstRoot(field, {{0.05, 0.1, 0.2}, {1, 0, 0}}, isovalue);
  ASSERT_TRUE(inside) << "a ray that starts in the plateau hits it at once";
  EXPECT_EQ(*inside, 0);
}

TEST(FirstRoot, AllRootsAreFoundInOrderByAskingAgain) {
  const Field field(makeVolume(cube(65), [](glm::dvec3 p) { return std::sin(20 * p.x); }), std::nullopt);
  const Ray ray{{-3, 0.11, 0.22}, glm::normalize(glm::dvec3(1, 0.01, 0.02))};
  // Linear interpolation moves a zero of sin(kx) by at most k^2 h^3 / (9 sqrt 3) = 8e-4 at h = 1/32.
  int count = 0;
  double after = -kInfinity;
  for (auto t = firstRoot(field, ray, 0); t; t = firstRoot(field, ray, 0, {}, after)) {
    EXPECT_NEAR(ray.at(*t).x, (count - 6) * std::numbers::pi / 20, 8e-4);
    after = *t;
    count++;
  }
  EXPECT_EQ(count, 13);
}

TEST(FirstRoot, CellsWithoutDataHaveNoSurface) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Field field(makeVolume(cube(9), [&](glm::dvec3 p) { return p.x == 0.25 ? nan : p.x; }), std::nullopt);
  const Ray ray{{-3, 0.1, 0.2}, {1, 0, 0}};
  EXPECT_FALSE(firstRoot(field, ray, 0.1));
  EXPECT_FALSE(firstRoot(field, ray, 0.4));
  EXPECT_TRUE(firstRoot(field, ray, 0.6));
}

TEST(FirstRoot, SphereIsClosedForRaysThroughGridEdgesAndCorners) {
  const Grid grid = cube(17);
  const Field field(makeVolume(grid, [](glm::dvec3 p) { return glm::length(p); }), std::nullopt);
  for (int i = -4; i <= 4; i++) {
    for (int j = -4; j <= 4; j++) {
      const Ray axis{{i / 8.0, j / 8.0, -3}, {0, 0, 1}};  // inside cell edges all the way
      ASSERT_TRUE(firstRoot(field, axis, 0.8));
      const glm::dvec3 corner(i / 8.0, j / 8.0, 0);
      const Ray diagonal{corner - 3.0 * glm::normalize(glm::dvec3(1)), glm::normalize(glm::dvec3(1))};
      ASSERT_TRUE(firstRoot(field, diagonal, 0.8));
    }
  }
}

TEST(Field, GradientOfALinearFieldIsExactUpToTheBorder) {
  const Field field(
      makeVolume({{0, 0, 0}, {0.5, 1, 2}, {5, 4, 3}}, [](glm::dvec3 p) { return p.x + 2 * p.y - p.z; }),
      std::nullopt);
  const std::pair<glm::dvec3, Index3> places[] = {
      {{0, 0, 0}, {0, 0, 0}}, {{2, 3, 4}, {3, 2, 1}}, {{0.9, 1.4, 2.5}, {1, 1, 1}}};
  for (const auto& [p, cell] : places) {
    EXPECT_LT(glm::length(field.smoothGradient(p) - glm::dvec3(1, 2, -1)), 1e-12);
    EXPECT_LT(glm::length(field.cellGradient(cell, p) - glm::dvec3(1, 2, -1)), 1e-12);
  }
}

TEST(Field, GradientNextToNoDataIsOneSidedAndZeroWhereBothSidesLackIt) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Grid grid = cube(9, 0, 8);
  const Field one(makeVolume(grid, [&](glm::dvec3 p) { return p.x == 3 ? nan : p.x * p.x; }), std::nullopt);
  EXPECT_NEAR(one.smoothGradient({4, 4, 4}).x, 25 - 16, 1e-12);
  const Field both(makeVolume(grid, [&](glm::dvec3 p) { return p.x == 3 || p.x == 5 ? nan : p.x; }),
                   std::nullopt);
  EXPECT_EQ(both.smoothGradient({4, 4, 4}).x, 0);
}

TEST(Field, GradientOfASphereIsWithinADegree) {
  const Field field(makeVolume(cube(64), [](glm::dvec3 p) { return glm::length(p); }), std::nullopt);
  Uniform random(4);
  for (int i = 0; i < 1000; i++) {
    const glm::dvec3 out = glm::normalize(random.inCube(1));
    EXPECT_GT(glm::dot(glm::normalize(field.smoothGradient(0.6 * out)), out),
              std::cos(std::numbers::pi / 180));
  }
}

TEST(Field, ScaleShiftAndMagnitudeGiveTrueValues) {
  auto volume = std::make_shared<Volume>();
  volume->grid = {glm::dvec3(0), glm::dvec3(1), {2, 2, 2}};
  volume->stored = ScalarType::Int16;
  volume->components = 2;
  volume->shift = 1;
  volume->scale = 2;
  VolumeBlock& block = volume->blocks[0];
  block.extent.points = volume->grid.points;
  const std::vector<int16_t> stored(16, 1);  // true value 3 in both components
  block.samples.resize(32);
  std::memcpy(block.samples.data(), stored.data(), 32);
  putIntoBricks(block.samples, block.extent.points, 4);
  EXPECT_DOUBLE_EQ(Field(volume, 1).sample(0, 0, 0), 3);
  EXPECT_DOUBLE_EQ(Field(volume, std::nullopt).sample(0, 0, 0), std::sqrt(18.0));
  EXPECT_THROW(Field(volume, 2), Error);
  block.extent.first = {1, 0, 0};
  EXPECT_THROW(Field(volume, 0), Error);
}

}  // namespace
}  // namespace gxy::reference

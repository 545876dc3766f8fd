// SPDX-License-Identifier: Apache-2.0
// Lines through fields whose lines are known.
#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "tests/kernels/random.h"
#include "tests/lines/flow_fields.h"
#include "tests/support/seeds.h"

namespace gxy::test {
namespace {

// The grid cuts the way into few cells or many, at places that do not matter; a linear field is exact on all.
TEST(LinearFields, AreExactOnAnyGrid) {
  for (const Index3 n : {Index3{2, 2, 2}, Index3{14, 25, 3}, Index3{40, 7, 5}, Index3{101, 101, 2}}) {
    const Flow flow(gridOver({-1, -12, -1}, {12, 12, 1}, n),
                    [](glm::dvec3 p) { return glm::dvec3(p.x, -p.y, 0); });
    const std::vector<glm::dvec3> seeds{{1, 1, 0}, {1, -3, 0.3}, {0.5, 10, -1}};
    const Lines lines = flow.trace(seeds, {.time = std::log(10.0)});
    for (const LineEnd& e : lines.ends) {
      EXPECT_EQ(e.reason, EndReason::Time);
      EXPECT_EQ(e.time, std::log(10.0));
      const glm::dvec3 seed = seeds[e.line];
      EXPECT_NEAR(e.position.x, 10 * seed.x, 2e-6 * 10 * seed.x);
      EXPECT_NEAR(e.position.y, seed.y / 10, 2e-6 * std::abs(seed.y));
      EXPECT_NEAR(e.position.z, seed.z, 1e-7);
    }
  }
}

TEST(LinearFields, ArrivalTimesAreExact) {
  const Flow flow(gridOver({-1, -1, -1}, {10, 2, 1}, {12, 4, 3}),
                  [](glm::dvec3 p) { return glm::dvec3(p.x, 0, 0); });
  const Lines lines = flow.trace({{1, 0.3, 0.2}});
  ASSERT_EQ(lines.ends[0].reason, EndReason::Left);
  EXPECT_EQ(lines.ends[0].position.x, 10);
  EXPECT_NEAR(lines.ends[0].time, 2.302585093, 2e-6 * 2.302585093);
  EXPECT_NEAR(lines.ends[0].length, 9, 2e-6 * 9);
}

TEST(TrilinearFields, TheirOwnExponentialIsMet) {
  for (const int64_t n : {9, 17, 65}) {
    const Flow flow(gridOver({-1, -1, -1}, {3, 3, 1}, {n, n, 3}),
                    [](glm::dvec3 p) { return glm::dvec3(1, p.x * p.y, 0); });
    const Lines lines = flow.trace({{0, 0.1, 0.1}}, {.time = 2});
    EXPECT_NEAR(lines.ends[0].position.x, 2, 1e-6);
    EXPECT_NEAR(lines.ends[0].position.y, 0.7389056, 1e-6);
  }
}

TEST(Rotation, KeepsItsRadiusAndPeriodOverTenTurns) {
  const double pi = std::numbers::pi;
  const Grid grid = gridOver({-1, -1, -1}, {1, 1, 3}, {33, 33, 65});
  const Flow flow(grid, [](glm::dvec3 p) { return glm::dvec3(-p.y, p.x, 0.01); });
  for (const double radius : {0.7, 0.31, 0.02}) {
    const Lines lines = flow.trace({{radius, 0, 0.1}}, {.time = 20 * pi, .length = 1e3});
    const LineEnd& e = lines.ends[0];
    ASSERT_EQ(e.reason, EndReason::Time);
    const double cell = grid.spacing.x;
    EXPECT_NEAR(glm::length(glm::dvec2(e.position)), radius, 1e-4 * cell);
    // The angle is that of ten periods.
    EXPECT_NEAR(std::atan2(e.position.y, e.position.x), 0, 1e-6 * 20 * pi);
    EXPECT_NEAR(e.position.z, 0.1 + 0.2 * pi, 1e-6 * 0.2 * pi + 1e-7 * grid.spacing.z);
    // A drift of 1e-4 cells is this much of the length.
    EXPECT_NEAR(e.length, 20 * pi * std::sqrt(radius * radius + 1e-4), 20 * pi * 1e-4 * cell);
  }
}

TEST(Rotation, ArrivesAfterTenTurnsAtTheTimeOfTenPeriods) {
  const double pi = std::numbers::pi;
  const Flow flow(gridOver({-1, -1, 0}, {1, 1, 0.2 * pi}, {33, 33, 9}),
                  [](glm::dvec3 p) { return glm::dvec3(-p.y, p.x, 0.01); });
  const Lines lines = flow.trace({{0.5, 0, 0}}, {.length = 1e3});
  ASSERT_EQ(lines.ends[0].reason, EndReason::Left);
  EXPECT_NEAR(lines.ends[0].time, 20 * pi, 1e-6 * 20 * pi);
}

TEST(Orbits, OfTenThousandTurnsNeitherGetStuckNorAreLost) {
  const Flow flow(gridOver({-1, -1, -1}, {1, 1, 1}, {5, 5, 3}),
                  [](glm::dvec3 p) { return glm::dvec3(-p.y, p.x, 0); });
  const int turns = sweep(10000);
  const double time = 2 * std::numbers::pi * turns;
  const Lines lines = flow.trace({{0.6, 0, 0}}, {.time = time, .length = 1e9, .points = PointsMode::Ends});
  ASSERT_EQ(lines.ends[0].reason, EndReason::Time);
  EXPECT_NEAR(glm::length(glm::dvec2(lines.ends[0].position)), 0.6, 1e-3 * turns / 10000 * 20);
}

// The flow is curved, so each face is met at another angle.
TEST(ForwardThenBackward, ComesBack) {
  const double pi = std::numbers::pi;
  const Grid grid = gridOver(glm::dvec3(0), glm::dvec3(2 * pi), {65, 65, 65});
  const Flow flow(grid, abcFlow);
  Random random(6);
  std::vector<glm::dvec3> seeds;
  for (int i = 0; i < 100; i++) seeds.push_back(random.point(2, 4.3));
  const TraceOptions options{.time = 0.8};
  const Lines there = flow.trace(seeds, options);
  std::vector<glm::dvec3> ends;
  for (const LineEnd& e : there.ends) ends.push_back(e.position);
  const Lines back = flow.trace(ends, options, TraceDirection::Backward);
  ASSERT_EQ(there.count(EndReason::Time), seeds.size());
  for (const LineEnd& e : back.ends) {
    EXPECT_LE(glm::length(e.position - seeds[e.line]) / grid.spacing.x, 4 * options.tolerance);
    EXPECT_EQ(e.time, -0.8);
    EXPECT_NEAR(e.length, -there.ends[e.line].length, 1e-4);
  }
}

// v = (1, -(x - a), 0): lines are parabolas, whose tops are here on a face, or some ulps of a cell off it.
TEST(Tangents, ParabolasThatTouchAFaceAreNeverStuckAndStayOnTheirSide) {
  const double a = 2.25, ulp = std::ldexp(1.0, -24);
  const Grid grid = gridOver({-2, -2, -2}, {6, 6, 2}, {9, 9, 5});
  const Flow flow(grid, [&](glm::dvec3 p) { return glm::dvec3(1, -(p.x - a), 0); });
  Random random(7);
  std::vector<glm::dvec3> seeds;
  std::vector<double> tops;
  const int offsets[] = {0, 1, -1, 2, -2, 4, -4};
  for (int i = 0; i < sweep(100000); i++) {
    // From far, from near, and from the top itself, within one step.
    const double x = i % 3 == 0 ? random.in(-0.5, 2) : i % 3 == 1 ? a - random.scale(1e-6, 0.3) : a;
    tops.push_back(2 + offsets[i % 7] * ulp);
    seeds.push_back({x, tops.back() - (a - x) * (a - x) / 2, random.in(-1, 1)});
  }
  const Lines lines = flow.trace(seeds, {.time = 2});
  EXPECT_EQ(lines.count(EndReason::Stuck), 0u);
  EXPECT_EQ(lines.count(EndReason::Closed), 0u);
  ASSERT_EQ(lines.count(EndReason::Time), seeds.size());
  double worst = 0;
  for (const LineEnd& e : lines.ends) {
    const double x = seeds[e.line].x + 2;
    worst = std::max(worst, std::abs(e.position.y - (tops[e.line] - (x - a) * (x - a) / 2)));
  }
  EXPECT_LE(worst, 5e-6);
  // The stored points are crossings of faces: each has a coordinate that is a whole number, exactly.
  size_t faces = 0;
  for (size_t i = 0; i < lines.points.size(); i++) {
    const glm::dvec3 p = lines.points.position[i];
    EXPECT_LE(p.y, 2 + 2e-6);
    faces += p.x == std::round(p.x) || p.y == std::round(p.y) || p.z == std::round(p.z);
  }
  EXPECT_GE(faces + 2 * seeds.size(), lines.points.size());
}

}  // namespace
}  // namespace gxy::test

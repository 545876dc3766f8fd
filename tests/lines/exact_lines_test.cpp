// SPDX-License-Identifier: Apache-2.0
// What lines keep exactly: the side of a face that they touch, an edge, a face or a diagonal that they follow, a manifold; and that
// neither scales nor tolerances change a line.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "tests/lines/same_lines.h"

namespace gxy::test {
namespace {

using V = glm::dvec3;

const LineEnd& onlyEnd(const Lines& lines) {
  EXPECT_EQ(lines.ends.size(), 1u);
  return lines.ends[0];
}

// The velocity is 1 along axis `along`, and -s (x - a) along axis `normal`: lines are parabolas that turn to -s, from the top on a face
// or `ulps` ulps of a cell above it. `before` the top they rise by less than a quarter of an ulp.
struct Tangent {
  int normal, along, ulps;
  double s, before;
  static constexpr double kFace = 2, kTop = 2.25;

  double at() const { return kFace + ulps * std::ldexp(1.0, -24); }
  Lines traced(const Flow& flow) const {
    V seed(0.375);
    seed[along] = kTop - before;
    seed[normal] = at();
    return flow.trace({seed}, {.time = 1.5});
  }
};

TEST(Tangents, FromTheTopLinesStayOnTheirSideOfTheFaceExactly) {
  const Grid grid = gridOver(V(-2), V(6), {9, 9, 9});
  for (int normal = 0; normal < 3; normal++)
    for (int turn = 1; turn < 3; turn++)
      for (const double s : {1.0, -1.0}) {
        const int along = (normal + turn) % 3;
        const Flow flow(grid, [&](V p) {
          V v(0);
          v[along] = 1;
          v[normal] = -s * (p[along] - Tangent::kTop);
          return v;
        });
        for (const int ulps : {-4, -2, -1, 0, 1, 2, 4})
          for (const double before : {0.0, 1e-4, 1e-6, 1e-9}) {
            const Tangent tangent{normal, along, ulps, s, before};
            const Lines lines = tangent.traced(flow);
            SCOPED_TRACE("axis " + std::to_string(normal) + ", along " + std::to_string(along) +
                         (s > 0 ? ", from below, " : ", from above, ") + std::to_string(ulps) +
                         " ulps, before " + std::to_string(before));
            const LineEnd& end = onlyEnd(lines);
            ASSERT_EQ(end.reason, EndReason::Time);
            EXPECT_NEAR(end.position[normal],
                        tangent.at() - s * (std::pow(1.5 - before, 2) - before * before) / 2, 5e-6);
            // On which side it begins, towards -s: it goes through the face once if it begins beyond.
            const bool beyond = ulps * s > 0;
            int onFace = 0;
            for (size_t i = 0; i < lines.points.size(); i++) {
              const double p = lines.points.position[i][normal];
              onFace += p == Tangent::kFace;
              EXPECT_LE(s * (p - (beyond ? tangent.at() : Tangent::kFace)), 0) << i;
              EXPECT_TRUE(beyond || ulps == 0 || s * (p - Tangent::kFace) < 0) << i;
            }
            if (ulps == 0)  // the seed, and where it goes over
              EXPECT_LE(onFace, 2);
            else
              EXPECT_EQ(onFace, beyond ? 1 : 0);
          }
      }
}

TEST(Scales, OfPlaceAndVelocityDoNotMatter) {
  for (const double scale : {1e-30, 1.0, 1e30}) {
    const Flow flow(gridOver(scale * V(-1, -12, -1), scale * V(12, 12, 1), {14, 25, 3}),
                    [](V p) { return V(p.x, -p.y, 0); });
    const std::vector<V> seeds{scale * V(1, 1, 0), scale * V(1, -3, 0.3), scale * V(0.5, 10, -1)};
    const Lines lines = flow.trace(seeds, {.time = std::log(10.0)});
    ASSERT_EQ(lines.count(EndReason::Time), seeds.size()) << scale;
    for (const LineEnd& e : lines.ends) {
      const V seed = seeds[e.line] / scale, end = e.position / scale;
      EXPECT_NEAR(end.x, 10 * seed.x, 2e-6 * 10 * seed.x) << scale;
      EXPECT_NEAR(end.y, seed.y / 10, 2e-6 * std::abs(seed.y)) << scale;
      EXPECT_NEAR(end.z, seed.z, 1e-7) << scale;
    }
    const LineEnd left = onlyEnd(flow.trace({scale * V(1.2, 0, 0)}, {}));
    EXPECT_EQ(left.reason, EndReason::Left) << scale;
    EXPECT_EQ(left.position.x, scale * 12) << scale;
    EXPECT_NEAR(left.length / scale, 10.8, 2e-6 * 10.8) << scale;
    EXPECT_NEAR(left.time, std::log(10.0), 2e-6 * std::log(10.0)) << scale;
  }
}

TEST(Scales, AFasterFlowHasTheSameLinesInLessTime) {
  const Grid grid = gridOver(V(0), V(2 * std::numbers::pi), {17, 17, 17});
  std::vector<V> seeds;
  for (int i = 0; i < 40; i++) seeds.push_back({1 + i % 5, 1.3 + i / 5 % 4, 2.1 + i / 20});
  const TraceOptions options{.length = 8};
  const Lines one = Flow(grid, abcFlow).trace(seeds, options);
  for (const double faster : {std::ldexp(1.0, 99), std::ldexp(1.0, -99)}) {
    const Flow flow(grid, [&](V p) { return faster * abcFlow(p); });
    Lines lines = flow.trace(seeds, options);
    for (double& t : lines.points.time) t *= faster;
    for (float& speed : lines.points.speed) speed = float(double(speed) / faster);
    for (LineEnd& e : lines.ends) e.time *= faster;
    expectSameLines(lines, one, std::to_string(std::log2(faster)));
  }
  for (const double faster : {1e30, 1e-30}) {  // no powers of 2: each sample is rounded otherwise
    const Flow flow(grid, [&](V p) { return faster * abcFlow(p); });
    const Lines lines = flow.trace(seeds, options);
    ASSERT_EQ(lines.ends.size(), one.ends.size());
    for (size_t i = 0; i < one.ends.size(); i++) {
      const LineEnd &a = lines.ends[i], &b = one.ends[i];
      EXPECT_EQ(a.reason, b.reason);
      EXPECT_LE(glm::length(a.position - b.position), 1e-5 * grid.spacing.x) << i;
      EXPECT_NEAR(a.time * faster, b.time, 1e-6 * b.time) << i;
      EXPECT_NEAR(a.length, b.length, 1e-6 * b.length) << i;
    }
  }
}

// Expects that each point is the one of the straight line from the seed, exactly, and that the line leaves the domain [0, n]^3.
void expectStraight(V seed, V direction, int n, double step) {
  SCOPED_TRACE("from " + std::to_string(seed.x) + " " + std::to_string(seed.y) + " " +
               std::to_string(seed.z) + " along " + std::to_string(direction.x) + " " +
               std::to_string(direction.y) + " " + std::to_string(direction.z));
  const Flow flow(gridOver(V(0), V(n), {n + 1, n + 1, n + 1}), [&](V) { return direction; });
  const Lines lines = flow.trace({seed});
  EXPECT_EQ(onlyEnd(lines).reason, EndReason::Left);
  const int axis = direction.x != 0 ? 0 : direction.y != 0 ? 1 : 2;
  const double last = direction[axis] > 0 ? n : 0;
  EXPECT_EQ(onlyEnd(lines).position, seed + direction * ((last - seed[axis]) / direction[axis]));
  std::vector<double> places;
  for (const V& p : lines.points.position) {
    const double t = (p[axis] - seed[axis]) / direction[axis];
    EXPECT_EQ(p, seed + t * direction);
    if (places.empty() || places.back() != t) places.push_back(t);
  }
  ASSERT_EQ(places.size(), size_t((last - seed[axis]) / direction[axis] / step) + 1);
  for (size_t i = 0; i < places.size(); i++) EXPECT_EQ(places[i], double(i) * step);
}

TEST(StraightLines, StayOnEdgesFacesAndDiagonalsAndMeetTheCornersExactly) {
  for (int a = 0; a < 3; a++)
    for (const double way : {1.0, -1.0}) {
      const int b = (a + 1) % 3, c = (a + 2) % 3;
      V along(0), seed(0);
      along[a] = way;
      seed[a] = way > 0 ? 0 : 8;
      for (const double v : {0.0, 3.0, 8.0})  // inner edges, and those of the domain
        for (const double w : {0.0, 5.0, 8.0}) {
          seed[b] = v, seed[c] = w;
          expectStraight(seed, along, 8, 1);
        }
      seed[b] = 3, seed[c] = 2.625;  // in a face
      expectStraight(seed, along, 8, 1);
      for (const double other : {1.0, -1.0}) {  // across faces of the plane c
        V diagonal = along;
        diagonal[b] = other;
        seed[b] = other > 0 ? 0 : 8, seed[c] = 5;
        expectStraight(seed, diagonal, 8, 1);
        seed[c] = 5.375;  // from edge to edge
        expectStraight(seed, diagonal, 8, 1);
        diagonal[c] = way;  // through corners
        seed[c] = way > 0 ? 0 : 8;
        expectStraight(seed, diagonal, 8, 1);
      }
    }
  expectStraight({0, 0, 3}, {2, 1, 0}, 8, 0.5);  // and through the middles of edges
}

TEST(Saddles, OnTheirStableManifoldLinesEndAtThem) {
  for (const int64_t n : {8, 9}) {  // the critical point is within a cell, and on a node
    for (int a = 0; a < 3; a++) {
      const int b = (a + 1) % 3;
      const Flow flow(gridOver(V(-1), V(1), {n, n, n}), [&](V p) {
        V v(0);
        v[a] = p[a];
        v[b] = -p[b];
        return v;
      });
      for (const double from : {0.9, -0.55}) {
        V seed(0.25);
        seed[a] = 0;
        seed[b] = from;
        const Lines lines = flow.trace({seed}, {.length = 100});
        EXPECT_EQ(onlyEnd(lines).reason, EndReason::Slow) << n << ", axis " << a;
        EXPECT_LE(std::abs(onlyEnd(lines).position[b]), 1e-6) << n << ", axis " << a;
        EXPECT_NEAR(onlyEnd(lines).length, std::abs(from), 2e-6) << n << ", axis " << a;
        for (const V& p : lines.points.position) ASSERT_EQ(p[a], 0) << n << ", axis " << a;
      }
    }
  }
}

// Less than 1e-4 is taken for that: rounding leaves no more.
TEST(Tolerances, SmallerOnesMakeNoLineWorse) {
  const double pi = std::numbers::pi;
  const Grid grid = gridOver(V(-1), V(1), {33, 33, 5});
  const Flow rotation(grid, [](V p) { return V(-p.y, p.x, 0); });
  const Flow growth(gridOver(V(-1), V(3, 3, 1), {17, 17, 3}), [](V p) { return V(1, p.x * p.y, 0); });
  const std::vector<V> seeds{{0.7, 0, 0.1}, {0.31, 0, 0.1}, {0.02, 0, 0.1}};
  const auto turned = [&](double tolerance) {
    return rotation.trace(seeds, {.tolerance = tolerance, .time = 20 * pi, .length = 1e3});
  };
  const Grid cube = gridOver(V(0), V(2 * pi), {9, 9, 9});
  const Flow abc(cube, abcFlow);
  const auto followed = [&](double tolerance) {
    return abc.trace({{1, 2, 3}, {4, 2.5, 1}}, {.tolerance = tolerance, .length = 10});
  };
  const Lines finest = turned(1e-4), finestOfAbc = followed(1e-4);
  EXPECT_FALSE(sameBits(followed(1e-3).points.position, finestOfAbc.points.position)) << "the test can fail";
  for (const double tolerance : {1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-300}) {
    SCOPED_TRACE(tolerance);
    const Lines lines = turned(tolerance);
    if (tolerance < 1e-4) {
      expectSameLines(lines, finest, "the line of 1e-4");
      expectSameLines(followed(tolerance), finestOfAbc, "the line of 1e-4");
    }
    ASSERT_EQ(lines.count(EndReason::Time), seeds.size());
    for (const LineEnd& e : lines.ends) {
      EXPECT_EQ(e.time, 20 * pi);
      EXPECT_NEAR(glm::length(glm::dvec2(e.position)), seeds[e.line].x, 1e-4 * grid.spacing.x);
      EXPECT_NEAR(std::atan2(e.position.y, e.position.x), 0, 1e-6 * 20 * pi);
    }
    const Lines grown = growth.trace({{0, 0.1, 0.1}}, {.tolerance = tolerance, .time = 2});
    EXPECT_EQ(onlyEnd(grown).time, 2);
    EXPECT_NEAR(onlyEnd(grown).position.x, 2, 1e-6);
    EXPECT_NEAR(onlyEnd(grown).position.y, 0.7389056, 1e-6);
  }
}

}  // namespace
}  // namespace gxy::test

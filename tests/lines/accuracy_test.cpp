// SPDX-License-Identifier: Apache-2.0
// How far lines are from the truth: against lines in double by tiny steps, and against the field that was sampled.
#include <gtest/gtest.h>

#include <algorithm>
#include <glm/geometric.hpp>

#include "core/reference/streamline.h"
#include "tests/lines/flow_fields.h"
#include "tests/lines/turbulence.h"
#include "tests/lines/twin_walk.h"
#include "tests/support/seeds.h"

namespace gxy::test {
namespace {

const double kPi = std::numbers::pi;

// The least value that a share of the values does not exceed.
double quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[size_t(share * double(values.size() - 1))];
}

TEST(Reference, MeetsAnExponentialOfItsOwnToTenDigits) {
  const Grid grid = gridOver({-1, -1, -1}, {3, 3, 1}, {9, 9, 3});
  const Partitioning cut = Partitioning::single(grid.box());
  const reference::Streamlines lines(
      volumeOf(grid, cut, 3, vectorsOf([](glm::dvec3 p) { return glm::dvec3(1, p.x * p.y, 0); })));
  reference::StreamlinePlace place = lines.start({0, 0.1, 0.1});
  EXPECT_EQ(lines.follow(place, 2), reference::Streamlines::End::Time);
  EXPECT_NEAR(lines.world(place).x, 2, 1e-12);
  EXPECT_NEAR(lines.world(place).y, 0.1 * std::exp(2), 1e-9);
  place = lines.start({0, 0.1, 0.1});
  EXPECT_EQ(lines.follow(place, 4), reference::Streamlines::End::Left);
}

// Errors of the twin along a way, by theta; kappa goes with it.
std::vector<double> errorsOfTwin(const Grid& grid, const FlowFunction& f,
                                 const std::vector<glm::dvec3>& seeds, double time,
                                 const std::vector<glm::dvec3>& truth) {
  std::vector<double> errors;
  for (double theta = 0.5; theta > 0.05; theta /= 2) {
    std::vector<double> each;
    for (size_t i = 0; i < seeds.size(); i++)
      each.push_back(glm::length(TwinWalk(grid, f, theta, theta / 2).follow(seeds[i], time) - truth[i]));
    errors.push_back(quantile(each, 0.5));
  }
  return errors;
}

double orderOf(const std::vector<double>& errors) {
  return std::log2(errors.front() / errors.back()) / double(errors.size() - 1);
}

TEST(Order, OfTheStepIsFourAcrossSixtyFourFaces) {
  const Grid grid = gridOver({-1, -1, -1}, {3, 3, 1}, {129, 129, 3});
  const FlowFunction f = [](glm::dvec3 p) { return glm::dvec3(1, p.x * p.y, 0); };
  const std::vector<double> errors = errorsOfTwin(grid, f, {{0, 0.1, 0.1}}, 2, {{2, 0.1 * std::exp(2), 0.1}});
  EXPECT_GE(orderOf(errors), 3.8);
  EXPECT_LE(errors.front(), 1e-6);
}

TEST(Order, OfTheStepIsFourInTurbulence) {
  const Grid grid = gridOver(glm::dvec3(0), glm::dvec3(1), {25, 25, 25});
  const Turbulence turbulence(30, 5, 3);
  // Samples are floats, in the twin as well.
  const FlowFunction f = [&](glm::dvec3 p) { return glm::dvec3(glm::vec3(turbulence(p))); };
  const reference::Streamlines reference(volumeOf(grid, Partitioning::single(grid.box()), 3, vectorsOf(f)),
                                         256);
  Random random(8);
  std::vector<glm::dvec3> seeds, truth;
  for (int i = 0; i < 40; i++) {
    seeds.push_back(random.point(0.3, 0.7));
    reference::StreamlinePlace place = reference.start(seeds.back());
    reference.follow(place, 0.08);
    truth.push_back(reference.world(place));
  }
  const std::vector<double> errors = errorsOfTwin(grid, f, seeds, 0.08, truth);
  EXPECT_GE(orderOf(errors), 3.8);
}

TEST(Order, OfTheFieldIsTwoInItsSpacing) {
  // The truth: tiny steps through the field itself.
  const auto truth = [](glm::dvec3 p, double time) {
    const int n = 2000;
    const double h = time / n;
    for (int i = 0; i < n; i++) {
      const glm::dvec3 a = abcFlow(p), b = abcFlow(p + h / 2 * a), c = abcFlow(p + h / 2 * b),
                       d = abcFlow(p + h * c);
      p += h / 6 * (a + 2.0 * (b + c) + d);
    }
    return p;
  };
  Random random(9);
  std::vector<glm::dvec3> seeds, ends;
  for (int i = 0; i < 60; i++) {
    seeds.push_back(random.point(2, 4.3));
    ends.push_back(truth(seeds.back(), 0.8));
  }
  std::vector<double> errors;
  for (const int64_t n : {17, 33, 65}) {
    const Flow flow(gridOver(glm::dvec3(0), glm::dvec3(2 * kPi), {n, n, n}), abcFlow);
    const Lines lines = flow.trace(seeds, {.time = 0.8});
    double squares = 0;
    for (const LineEnd& e : lines.ends) {
      const glm::dvec3 d = e.position - ends[e.line];
      squares += glm::dot(d, d);
    }
    errors.push_back(std::sqrt(squares));
  }
  EXPECT_NEAR(orderOf(errors), 2, 0.15);
}

// Each cell's way against the reference from the same entry.
void expectTolerance(double tolerance) {
  const int64_t n = 49;
  const Grid grid = gridOver(glm::dvec3(0), glm::dvec3(1), {n, n, n});
  const Turbulence turbulence(40, 9, 5);
  static const Flow flow(grid, [&](glm::dvec3 p) { return turbulence(p); });
  const reference::Streamlines reference(flow.volume, 48);
  Random random(10);
  std::vector<glm::dvec3> seeds;
  for (int i = 0; i < 200; i++) seeds.push_back(random.point(0.1, 0.9));
  const Lines lines = flow.trace(seeds, {.tolerance = tolerance, .steps = 150});
  EXPECT_EQ(lines.count(EndReason::Stuck), 0u);
  ASSERT_EQ(lines.ends.size(), seeds.size());
  std::vector<double> errors;
  const PathPoints& p = lines.points;
  const size_t stride = size_t(sweep(8) == 8 ? 5 : 40);
  for (size_t i = 0; i + 1 < p.size(); i += stride) {
    if (p.line[i] != p.line[i + 1]) continue;
    reference::StreamlinePlace place = reference.start(p.position[i]);
    reference.follow(place, p.time[i + 1] - p.time[i]);
    errors.push_back(glm::length(reference.world(place) - p.position[i + 1]) * double(n - 1));
  }
  ASSERT_GT(errors.size(), 300u);
  EXPECT_LE(quantile(errors, 0.999), tolerance / 100) << tolerance;
  EXPECT_LE(quantile(errors, 1), tolerance) << tolerance;
}

TEST(Tolerance, IsKeptByEachCellOfTurbulence) {
  for (const double tolerance : {1e-1, 1e-2, 1e-3, 1e-4}) expectTolerance(tolerance);
}

TEST(Tolerance, OfTheDefaultLeavesEndsWithin1e5CellsInTheMedian) {
  const int64_t n = 65;
  const Grid grid = gridOver(glm::dvec3(0), glm::dvec3(1), {n, n, n});
  const Turbulence turbulence(40, 4, 6);
  const Flow flow(grid, [&](glm::dvec3 p) { return turbulence(p); });
  const reference::Streamlines reference(flow.volume, 48);
  Random random(11);
  std::vector<glm::dvec3> seeds;
  for (int i = 0; i < sweep(80); i++) seeds.push_back(random.point(0.2, 0.8));
  const Lines lines = flow.trace(seeds, {.steps = 150, .points = PointsMode::Ends});
  std::vector<double> errors;
  for (const LineEnd& e : lines.ends) {
    reference::StreamlinePlace place = reference.start(seeds[e.line]);
    reference.follow(place, e.time);
    errors.push_back(glm::length(reference.world(place) - e.position) * double(n - 1));
  }
  EXPECT_LE(quantile(errors, 0.5), 1e-5);
}

}  // namespace
}  // namespace gxy::test

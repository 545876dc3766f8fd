// SPDX-License-Identifier: Apache-2.0
// Points of filters on the smallest grids, in partitions of one cell, and on grids far from 1 and from 0: values, places and areas by
// their closed forms.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "core/analysis/density_filter.h"
#include "core/analysis/interpolate_filter.h"
#include "core/analysis/isosurface_filter.h"
#include "core/analysis/ray_filter.h"
#include "tests/analysis/sampled.h"
#include "tests/support/seeds.h"

namespace gxy::test {
namespace {

using nlohmann::json;

/// A grid, of whose box places are told as fractions from 0 to 1.
struct ExtremeGrid {
  std::string name;
  Grid grid;
  /// By how much a place may be wrong, as a fraction of the box: some ulps of floats.
  static constexpr double kTolerance = 2e-6;

  Box box() const { return grid.box(); }
  glm::dvec3 sides() const { return box().hi - box().lo; }
  glm::dvec3 fraction(glm::dvec3 world) const { return (world - box().lo) / sides(); }
  glm::dvec3 world(glm::dvec3 fraction) const { return box().lo + fraction * sides(); }
  WholeVolume field(const std::function<double(glm::dvec3 fraction)>& f) const {
    return sampled(grid, [&](glm::dvec3 p) { return f(fraction(p)); });
  }
  /// In one piece, and with a partition for each cell.
  std::vector<Cut> cuts() const {
    std::array<int, 3> cells{};
    for (size_t a = 0; a < 3; a++) cells[a] = int(grid.points[a]) - 1;
    return {whole(box()), lattice(box(), cells, 3)};
  }
};

std::vector<ExtremeGrid> extremeGrids() {
  const auto on = [](const char* name, glm::dvec3 lo, glm::dvec3 sides, Index3 points) {
    const glm::dvec3 cells(double(points[0] - 1), double(points[1] - 1), double(points[2] - 1));
    return ExtremeGrid{name, {lo, sides / cells, points}};
  };
  using V = glm::dvec3;
  return {
      on("2x2x2", V(-1), V(2), {2, 2, 2}),
      on("2x2x17", V(0, 1, 2), V(1, 1, 4), {2, 2, 17}),
      on("5x5x5", V(0), V(1), {5, 5, 5}),
      on("offset by 1e6", V(1e6), V(1), {5, 5, 5}),
      on("of 1e-30", V(-1e-30), V(2e-30), {5, 5, 5}),
      on("of 1e30", V(-1e30), V(2e30), {5, 5, 5}),
      on("1:1e4:1", V(0), V(1, 1e4, 1), {5, 5, 5}),
      on("1:1e4:1, 2x2x2", V(0), V(1, 1e4, 1), {2, 2, 2}),
  };
}

double slope(glm::dvec3 q) { return q.x + q.y + q.z; }
double saddle(glm::dvec3 q) { return 1 + 2 * q.x * q.y - q.z + q.x * q.y * q.z; }

/// What a filter makes, the same on all cuts.
template <class Filter>
SampledPoints onAllCuts(const ExtremeGrid& on, const Evaluation& evaluation, const json& properties) {
  SampledPoints one;
  for (const Cut& cut : on.cuts()) {
    const SampledPoints made = evaluateOn<Filter>(cut, evaluation, properties.dump());
    if (cut.ranks == 1)
      one = made;
    else
      EXPECT_EQ(made, one) << on.name << ", " << cut.name;
  }
  return one;
}

void expectFractions(glm::dvec3 found, glm::dvec3 expected, const std::string& what) {
  for (int a = 0; a < 3; a++) EXPECT_NEAR(found[a], expected[a], ExtremeGrid::kTolerance) << what;
}

json listOf(glm::dvec3 a, glm::dvec3 b) { return {a.x, a.y, a.z, b.x, b.y, b.z}; }

// The hexagon where the sum of the fractions is 1.5.
TEST(ExtremeGrids, AnIsosurfaceHasItsAreaPlacesValuesAndGradient) {
  for (const ExtremeGrid& on : extremeGrids()) {
    const WholeVolume field = on.field(slope), values = on.field(saddle);
    const int count = sweep(2000);
    const SampledPoints all =
        onAllCuts<IsosurfaceSampler>(on, {{}, {{"field", {&field}}, {"values", {&values}}}},
                                     {{"isovalue", 1.5}, {"count", count}, {"gradient", true}});
    ASSERT_EQ(all.points.size(), size_t(count)) << on.name;
    const glm::dvec3 s = on.sides();
    const double area = 0.75 * s.x * s.y * s.z * glm::length(1.0 / s);
    const double told = all.told.at("area"), error = all.told.at("area error");
    EXPECT_NEAR(told / area, 1, 3 * error / area) << on.name;
    EXPECT_LT(error / area, 3 / std::sqrt(count)) << on.name;
    glm::dvec3 mean(0);
    for (const auto& [id, point] : all.points) {
      const glm::dvec3 q = on.fraction(point.first);
      ASSERT_NEAR(slope(q), 1.5, 2 * ExtremeGrid::kTolerance) << on.name;
      ASSERT_NEAR(point.second, saddle(q), 5e-6) << on.name;
      for (int a = 0; a < 3; a++) {
        ASSERT_GE(q[a], -ExtremeGrid::kTolerance) << on.name;
        ASSERT_LE(q[a], 1 + ExtremeGrid::kTolerance) << on.name;
        ASSERT_NEAR(all.fields.at(id).at(size_t(a)) * s[a], 1, 1e-5) << on.name;
      }
      mean += q / double(count);
    }
    // A fraction's deviation is sqrt(5) / 6 / sqrt(3), and less than 0.25.
    for (int a = 0; a < 3; a++) EXPECT_NEAR(mean[a], 0.5, 4 * 0.25 / std::sqrt(count)) << on.name;
  }
}

TEST(ExtremeGrids, RaysMeetTheSurfaceWhereItIs) {
  for (const ExtremeGrid& on : extremeGrids()) {
    const WholeVolume field = on.field(slope), values = on.field(saddle);
    json rays = json::array();
    std::vector<glm::dvec3> expected;
    for (int axis = 0; axis < 3; axis++)
      for (int i = 0; i < 25; i++) {
        // Another place on each ray, on faces of cells, too; from below and from above.
        const double u = 0.05 + (i % 5) * 0.2, v = i / 5 * 0.23;
        if (u + v < 0.6 || u + v > 1.4) continue;
        glm::dvec3 q(0), direction(0);
        q[(axis + 1) % 3] = u, q[(axis + 2) % 3] = v;
        q[axis] = i % 2 ? -1 : 2;
        direction[axis] = i % 2 ? on.sides()[axis] : -on.sides()[axis];
        rays.push_back(listOf(on.world(q), direction));
        q[axis] = 1.5 - u - v;
        expected.push_back(q);
      }
    rays.push_back(listOf(on.world({-0.5, -0.5, -0.5}), on.sides()));
    expected.push_back(glm::dvec3(0.5));
    const SampledPoints all = onAllCuts<RaySampler>(
        on, {{}, {{"f", {&field}}, {"g", {&values}}}},
        {{"operators", {{{"dataset", "f"}, {"isovalues", {1.5}}}}}, {"rays", rays}, {"values", "g"}});
    ASSERT_EQ(all.points.size(), expected.size()) << on.name;
    for (const auto& [id, point] : all.points) {
      expectFractions(on.fraction(point.first), expected[id], on.name + ", ray " + std::to_string(id));
      EXPECT_NEAR(point.second, saddle(expected[id]), 5e-6) << on.name;
    }
  }
}

TEST(ExtremeGrids, RaysHavePointsAtEqualDistances) {
  for (const ExtremeGrid& on : extremeGrids()) {
    const WholeVolume field = on.field(saddle);
    for (int axis = 0; axis < 3; axis++) {
      glm::dvec3 q(0.3), direction(0);
      q[axis] = -1;
      direction[axis] = 1;
      // Steps may not be shorter than a 32768th of the longest side.
      const glm::dvec3 sides = on.sides();
      const double longest = std::max({sides.x, sides.y, sides.z});
      const double step = std::max(sides[axis] / 5.5, longest / 32000), part = step / sides[axis];
      const SampledPoints all = onAllCuts<RaySampler>(on, {{}, {{"f", {&field}}}},
                                                      {{"operators", {{{"dataset", "f"}, {"every", step}}}},
                                                       {"rays", {listOf(on.world(q), direction)}},
                                                       {"values", "f"}});
      ASSERT_EQ(all.points.size(), size_t(1 / part)) << on.name << ", axis " << axis;
      for (int k = 1; k <= int(all.points.size()); k++) {
        q[axis] = k * part;
        const auto& [place, value] = all.points.at(uint64_t(k - 1));
        expectFractions(on.fraction(place), q, on.name);
        EXPECT_NEAR(value, saddle(q), 5e-6) << on.name;
      }
    }
  }
}

// By Kolmogorov and Smirnov, with a probability of 1e-3 for as many independent points.
TEST(ExtremeGrids, RandomPointsFollowTheDensity) {
  for (const ExtremeGrid& on : extremeGrids()) {
    const WholeVolume field = on.field([](glm::dvec3 q) { return 8 * q.y; });
    const int count = sweep(4000);
    const SampledPoints all =
        onAllCuts<DensitySampler>(on, {{}, {{"field", {&field}}}}, {{"count", count}, {"seed", 2}});
    ASSERT_EQ(all.points.size(), size_t(count)) << on.name;
    std::array<std::vector<double>, 3> along;
    for (const auto& [id, point] : all.points) {
      const glm::dvec3 q = on.fraction(point.first);
      ASSERT_NEAR(point.second, 8 * q.y, 8e-6) << on.name;
      for (int a = 0; a < 3; a++) along[size_t(a)].push_back(q[a]);
    }
    for (size_t a = 0; a < 3; a++) {
      std::vector<double>& q = along[a];
      std::sort(q.begin(), q.end());
      double most = 0;
      for (size_t i = 0; i < q.size(); i++) {
        const double expected = a == 1 ? q[i] * q[i] : q[i];
        most = std::max(
            {most, std::abs(double(i) / count - expected), std::abs(double(i + 1) / count - expected)});
      }
      EXPECT_LE(most, 1.95 / std::sqrt(count)) << on.name << ", axis " << a;
      EXPECT_GE(q.front(), 0) << on.name;
      EXPECT_LE(q.back(), 1) << on.name;
    }
  }
}

TEST(ExtremeGrids, PointsGetTheValuesOfTheirPlaces) {
  for (const ExtremeGrid& on : extremeGrids()) {
    const WholeVolume field = on.field(saddle), linear = on.field(slope);
    WholeGeometry points;
    std::vector<glm::dvec3> fractions;
    for (int i = 0; i < 9 * 9 * 9; i++) fractions.push_back({i % 9 / 8.0, i / 9 % 9 / 8.0, i / 81 / 8.0});
    const size_t inside = fractions.size();
    for (int a = 0; a < 3; a++)
      for (const double beyond : {-1e-6, 1 + 1e-6, -1.0, 1e9}) {
        glm::dvec3 q(0.25);
        q[a] = beyond;
        fractions.push_back(q);
      }
    for (const glm::dvec3& q : fractions) {
      points.block.ids.push_back(points.block.ids.size());
      points.block.points.push_back(on.world(q));
    }
    std::vector<json> told;
    std::vector<SampledPoints> made;
    for (const Cut& cut : on.cuts()) {
      Evaluation evaluation{{}, {{"fields", {&field, &linear}}}};
      evaluation.geometry["points"] = points;
      made.push_back(evaluateOn<Interpolate>(cut, evaluation, "{}"));
      told.push_back(made.back().told);
    }
    ASSERT_EQ(made[0].points.size(), fractions.size()) << on.name;
    EXPECT_EQ(told[0], told[1]) << on.name;
    EXPECT_EQ(told[0].at("outside"), fractions.size() - inside) << on.name;
    EXPECT_EQ(told[0].at("no data"), 0) << on.name;
    for (size_t i = 0; i < fractions.size(); i++) {
      const float value = made[0].points.at(i).second, other = made[0].fields.at(i).at(0);
      const float again = made[1].points.at(i).second;
      EXPECT_TRUE(value == again || (std::isnan(value) && std::isnan(again))) << on.name << " " << i;
      if (i < inside) {
        EXPECT_NEAR(value, saddle(fractions[i]), 1e-6) << on.name;
        EXPECT_NEAR(other, slope(fractions[i]), 1e-6) << on.name;
      } else {
        EXPECT_TRUE(std::isnan(value) && std::isnan(other)) << on.name << ", " << i - inside;
      }
    }
  }
}

}  // namespace
}  // namespace gxy::test

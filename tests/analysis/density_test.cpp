// SPDX-License-Identifier: Apache-2.0
// DensitySampler: its points follow the density, whatever macrocells bound, and are the same on any ranks.
#include "core/analysis/density_filter.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <string>
#include <vector>

#include "tests/analysis/filter_setup.h"
#include "tests/support/seeds.h"

namespace gxy::test {
namespace {

/// The unit cube with n cells a side.
Grid unitCube(int64_t n) {
  Grid grid;
  grid.points = {n + 1, n + 1, n + 1};
  grid.spacing = glm::dvec3(1.0 / double(n));
  return grid;
}

MadePoints drawn(const WholeVolume& whole, const Cut& cut, const std::string& properties) {
  return made<DensitySampler>(
      cut,
      [&](Collectives& ranks) {
        return FilterRun::Inputs{{"field", {{"field", {}, 1, datasetOf(whole, cut, ranks.rank())}}}};
      },
      properties);
}

/// The same with further volumes, by name.
MadePoints drawnWith(const WholeVolume& field, const std::map<std::string, const WholeVolume*>& values,
                     const Cut& cut, const std::string& properties) {
  return made<DensitySampler>(
      cut,
      [&](Collectives& ranks) {
        FilterRun::Inputs inputs{{"field", {{"field", {}, 1, datasetOf(field, cut, ranks.rank())}}}};
        for (const auto& [name, volume] : values)
          inputs["values"].push_back({name, {}, 1, datasetOf(*volume, cut, ranks.rank())});
        return inputs;
      },
      properties);
}

/// The largest distance of the distribution of numbers in [0, 1] from that with cumulative distribution `expected`.
template <class F>
double kolmogorovSmirnov(std::vector<double> x, F expected) {
  std::sort(x.begin(), x.end());
  double most = 0;
  for (size_t i = 0; i < x.size(); i++) {
    const double e = expected(x[i]);
    most = std::max({most, e - double(i) / double(x.size()), double(i + 1) / double(x.size()) - e});
  }
  return most;
}

std::vector<double> along(const MadePoints& made, int axis) {
  std::vector<double> x;
  for (const auto& [id, p] : made.points) x.push_back(p.point[axis]);
  return x;
}

TEST(DensitySampler, FollowsAFieldByKolmogorovAndSmirnov) {
  const WholeVolume whole = test::sampled(unitCube(40), [](glm::dvec3 p) { return p.x; });
  const MadePoints made = drawn(whole, test::whole(whole.grid.box()), R"({"count": 100000, "seed": 5})");
  ASSERT_EQ(made.points.size(), 100000u) << made.error;
  constexpr double kBound = 0.00617;  // probability 1e-3 for as many independent points
  EXPECT_LE(kolmogorovSmirnov(along(made, 0), [](double x) { return x * x; }), kBound);
  EXPECT_LE(kolmogorovSmirnov(along(made, 1), [](double x) { return x; }), kBound);
  EXPECT_LE(kolmogorovSmirnov(along(made, 2), [](double x) { return x; }), kBound);
  EXPECT_GT(kolmogorovSmirnov(along(made, 0), [](double x) { return x; }), 20 * kBound)
      << "the test can fail";
  for (const auto& [id, p] : made.points) ASSERT_NEAR(p.value, p.point.x, 1e-6) << "the value of the field";
}

TEST(DensitySampler, RecordsFurtherFieldsAndTheGradientOnAnyRanks) {
  const auto product = [](glm::dvec3 p) { return 1 + p.x * p.y; };
  const WholeVolume field = sampled(unitCube(8), product);
  const WholeVolume other = sampled(unitCube(5), [](glm::dvec3 p) { return 7 - p.z; });
  const std::string properties = R"({"count": 2000, "gradient": true})";
  const auto on = [&](const Cut& cut) { return drawnWith(field, {{"other", &other}}, cut, properties); };
  const MadePoints all = on(whole(field.grid.box()));
  ASSERT_EQ(all.points.size(), 2000u) << all.error;
  for (const auto& [id, p] : all.points) {
    const std::vector<double> expected{7 - p.point.z, p.point.y, p.point.x, 0};
    ASSERT_NEAR(p.value, product(p.point), 1e-6);
    for (size_t c = 0; c < 4; c++) ASSERT_NEAR(all.fields.at(id).at(c), expected[c], 1e-5) << c;
  }
  EXPECT_EQ(all.told.at("fields").at(0).at("name"), "field");
  EXPECT_EQ(all.told.at("fields").at(2).at("name"), "gradient");
  for (const Cut& cut : manyCuts(field.grid.box(), 2)) {
    const MadePoints again = on(cut);
    EXPECT_EQ(again.points, all.points) << cut.name;
    EXPECT_EQ(again.fields, all.fields) << cut.name;
  }
}

TEST(DensitySampler, FollowsAMapWithASpikeNarrowerThanACell) {
  // The density is not 0 between 0.52 and 0.53 only, and a cell spans 1/20.
  const WholeVolume whole = test::sampled(unitCube(20), [](glm::dvec3 p) { return p.z; });
  const MadePoints made = drawn(whole, test::whole(whole.grid.box()),
                                R"({"count": 5000, "map": [[0.52, 0], [0.525, 8], [0.53, 0]]})");
  ASSERT_EQ(made.points.size(), 5000u) << made.error;
  EXPECT_LE(kolmogorovSmirnov(along(made, 2),
                              [](double z) {
                                const double t = std::clamp((z - 0.52) / 0.01, 0.0, 1.0);
                                return t < 0.5 ? 2 * t * t : 1 - 2 * (1 - t) * (1 - t);
                              }),
            0.0276);
}

TEST(DensitySampler, FollowsAStepOfTheMap) {
  const WholeVolume whole = test::sampled(unitCube(24), [](glm::dvec3 p) { return p.y; });
  const MadePoints made =
      drawn(whole, test::whole(whole.grid.box()), R"({"count": 20000, "map": [[0.3, 1], [0.3, 3]]})");
  ASSERT_EQ(made.points.size(), 20000u) << made.error;
  EXPECT_LE(
      kolmogorovSmirnov(along(made, 1), [](double y) { return (y < 0.3 ? y : 0.3 + 3 * (y - 0.3)) / 2.4; }),
      0.0138);
}

TEST(DensitySampler, MakesTheSamePointsOnAnyRanksAndCuts) {
  Grid grid = unitCube(33);
  grid.points = {34, 20, 18};
  grid.origin = {1e6, -3, 2};
  grid.spacing = {1, 1e-4, 1e3};
  const WholeVolume whole = test::sampled(
      grid, [&](glm::dvec3 p) { return std::abs(std::sin(p.x) * std::cos(3e4 * p.y)) + 1e-4 * p.z; });
  const std::string properties = R"({"count": 3000, "seed": 2})";
  const auto one = drawn(whole, test::whole(grid.box()), properties).points;
  ASSERT_EQ(one.size(), 3000u);
  EXPECT_EQ(one.rbegin()->first, 2999u) << "ids are dense";
  for (const Cut& cut : manyCuts(grid.box(), 7))
    EXPECT_EQ(drawn(whole, cut, properties).points, one) << cut.name;
  EXPECT_EQ(drawn(whole, lattice(grid.box(), {4, 4, 4}, 3), properties).points, one);
  EXPECT_NE(drawn(whole, test::whole(grid.box()), R"({"count": 3000, "seed": 3})").points, one);
}

TEST(DensitySampler, ItsFirstPointsAreThoseOfFewerPoints) {
  const WholeVolume whole = test::sampled(unitCube(16), [](glm::dvec3 p) { return p.x * p.y; });
  const Cut cut = lattice(whole.grid.box(), {2, 1, 2}, 2);
  const auto many = drawn(whole, cut, R"({"count": 20000})").points;
  const auto few = drawn(whole, cut, R"({"count": 700})").points;
  ASSERT_EQ(few.size(), 700u);
  for (const auto& [id, p] : few) ASSERT_EQ(many.at(id), p);
}

TEST(DensitySampler, OfADensityThatIsZeroButInOneCellFindsIt) {
  const WholeVolume whole = test::sampled(unitCube(64), [](glm::dvec3 p) {
    return glm::length(p - glm::dvec3(0.25, 0.5, 0.75)) < 1e-9 ? 1.0 : 0.0;
  });
  const MadePoints made = drawn(whole, lattice(whole.grid.box(), {2, 2, 2}, 3), R"({"count": 200})");
  ASSERT_EQ(made.points.size(), 200u) << made.error;
  for (const auto& [id, p] : made.points)
    for (int a = 0; a < 3; a++) ASSERT_NEAR(p.point[a], glm::dvec3(0.25, 0.5, 0.75)[a], 1.0 / 64);
}

TEST(DensitySampler, PutsNoPointWhereThereAreNoData) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const WholeVolume whole = test::sampled(unitCube(20), [&](glm::dvec3 p) { return p.x < 0.49 ? nan : 1.0; });
  const MadePoints made = drawn(whole, lattice(whole.grid.box(), {3, 1, 1}, 2), R"({"count": 5000})");
  ASSERT_EQ(made.points.size(), 5000u) << made.error;
  for (const auto& [id, p] : made.points) ASSERT_GE(p.point.x, 0.5 - 1e-12);
  EXPECT_LE(kolmogorovSmirnov(along(made, 0), [](double x) { return 2 * x - 1; }), 0.0276);
}

TEST(DensitySampler, SaysHowManyItFoundWhereThereAreTooFew) {
  // One macrocell's bound is 1, but its density is above 0 in a 10^-9th of it.
  const WholeVolume whole = test::sampled(unitCube(8), [](glm::dvec3 p) { return p.x + p.y + p.z; });
  const MadePoints made =
      drawn(whole, test::whole(whole.grid.box()), R"({"count": 1, "map": [[2.9999, 0], [3, 1]]})");
  EXPECT_EQ(made.error, "");
  EXPECT_EQ(made.points.size(), 0u);
  EXPECT_EQ(made.told.at("found"), 0);
  EXPECT_EQ(made.told.at("count"), 1);
  EXPECT_EQ(made.told.at("candidates"), 1010000);
}

TEST(DensitySampler, RefusesADensityThatIsZeroEverywhereAndAComponentThatIsNot) {
  const WholeVolume whole = test::sampled(unitCube(8), [](glm::dvec3) { return -1.0; });
  const Cut cut = lattice(whole.grid.box(), {2, 1, 1}, 2);
  EXPECT_NE(drawn(whole, cut, "{}").error.find("the density of \"field\" is 0 everywhere"),
            std::string::npos);
  EXPECT_NE(drawn(whole, cut, R"({"component": 1})")
                .error.find("\"field\": there is no component 1, expected 0 to 0"),
            std::string::npos);
}

}  // namespace
}  // namespace gxy::test

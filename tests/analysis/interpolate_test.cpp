// SPDX-License-Identifier: Apache-2.0
// Interpolate: the values of a field at points that any rank owns.
#include "core/analysis/interpolate_filter.h"

#include <cmath>

#include "core/analysis/seeds_filter.h"
#include "tests/analysis/filter_setup.h"

namespace gxy::test {
namespace {

std::shared_ptr<const Dataset> points(const WholeVolume& whole, const Cut& cut, Collectives& ranks,
                                      const std::string& properties) {
  FilterRun run(ranks, {{"domain", {{"v", {}, 1, datasetOf(whole, cut, ranks.rank())}}}}, freeServices());
  return evaluate(*makeFilter<Seeds>(), run, properties).dataset;
}

MadePoints interpolated(const WholeVolume& whole, const Cut& cut, const std::string& seeds,
                        const std::string& properties = "{}") {
  return made<Interpolate>(
      cut,
      [&](Collectives& ranks) {
        return FilterRun::Inputs{{"points", {{"p", {}, 1, points(whole, cut, ranks, seeds)}}},
                                 {"field", {{"f", {}, 1, datasetOf(whole, cut, ranks.rank())}}}};
      },
      properties);
}

TEST(Interpolate, OfATrilinearFieldIsTheField) {
  const WholeVolume whole = sampled(oddGrid({12, 9, 7}), trilinear);
  const MadePoints made = interpolated(whole, lattice(whole.grid.box(), {2, 2, 2}, 3),
                                       R"({"shape": "box", "count": 5000, "seed": 4})");
  ASSERT_EQ(made.points.size(), 5000u) << made.error;
  EXPECT_EQ(made.told.at("outside"), 0);
  for (const auto& [id, p] : made.points) ASSERT_NEAR(p.value, trilinear(p.point), 1e-5);
}

TEST(Interpolate, GivesTheSameValuesOnAnyRanksAndCuts) {
  const WholeVolume whole =
      sampled(oddGrid({12, 9, 7}), [](glm::dvec3 p) { return std::sin(7 * p.x + p.y * p.z); });
  const std::string seeds = R"({"shape": "grid", "dimensions": [23, 17, 13]})";
  const auto one = interpolated(whole, test::whole(whole.grid.box()), seeds).points;
  for (const Cut& cut : manyCuts(whole.grid.box(), 3))
    EXPECT_EQ(interpolated(whole, cut, seeds).points, one) << cut.name;
}

TEST(Interpolate, OfPointsOutsideAndWithoutDataIsNothingAndIsCounted) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const WholeVolume whole = sampled(oddGrid({12, 9, 7}), [&](glm::dvec3 p) { return p.x > 3 ? nan : 5.0; });
  const MadePoints made = interpolated(
      whole, lattice(whole.grid.box(), {2, 1, 1}, 2),
      R"({"shape": "points", "points": [[0, 3, 2], [-1, 2, 0.5], [4.5, 4, 6.5], [-1.001, 3, 2], [3.9, 3, 2], [0, 3, 1e9]]})");
  ASSERT_EQ(made.points.size(), 6u) << made.error;
  EXPECT_EQ(made.points.at(0).value, 5);
  EXPECT_EQ(made.points.at(1).value, 5) << "a corner of the domain is in it";
  for (const uint64_t i : {2, 3, 4, 5}) EXPECT_TRUE(std::isnan(made.points.at(i).value)) << i;
  EXPECT_EQ(made.told.at("outside"), 2);
  EXPECT_EQ(made.told.at("no data"), 2);
}

TEST(Interpolate, OfVectorsIsAComponentOrTheMagnitude) {
  WholeVolume whole = sampled(oddGrid({12, 9, 7}), [](glm::dvec3) { return 0.0; });
  const size_t n = whole.samples.size() / sizeof(float);
  std::vector<float> values;
  for (size_t i = 0; i < n; i++) values.insert(values.end(), {3, float(i % 2), 4});
  whole.components = 3;
  whole.samples.resize(values.size() * sizeof(float));
  std::memcpy(whole.samples.data(), values.data(), whole.samples.size());
  const Cut cut = test::whole(whole.grid.box());
  const std::string seeds = R"({"shape": "points", "points": [[-1, 2, 0.5]]})";
  EXPECT_EQ(interpolated(whole, cut, seeds, R"({"component": 2})").points.at(0).value, 4);
  EXPECT_EQ(interpolated(whole, cut, seeds).points.at(0).value, 5);
  EXPECT_NE(interpolated(whole, cut, seeds, R"({"component": 3})").error.find("expected 0 to 2"),
            std::string::npos);
}

}  // namespace
}  // namespace gxy::test

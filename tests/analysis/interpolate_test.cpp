// SPDX-License-Identifier: Apache-2.0
// Interpolate: the values of a field at points that any rank owns.
#include "core/analysis/interpolate_filter.h"

#include <cmath>
#include <cstring>

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
                                 {"fields", {{"f", {}, 1, datasetOf(whole, cut, ranks.rank())}}}};
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

/// The seeds of `seeds` with the fields of several volumes, one after the other: in each round the fields of one more.
MadePoints interpolatedInTurn(
    const std::vector<std::vector<std::pair<std::string, const WholeVolume*>>>& rounds, const Cut& cut,
    const std::string& seeds) {
  const WholeVolume& first = *rounds[0][0].second;
  const auto sources = [&](const auto& list, Collectives& ranks) {
    std::vector<FilterSource> all;
    for (const auto& [name, volume] : list)
      all.push_back({name, {}, 1, datasetOf(*volume, cut, ranks.rank())});
    return all;
  };
  return made<Interpolate>(
      cut,
      [&](Collectives& ranks) {
        auto at = points(first, cut, ranks, seeds);
        for (size_t i = 0; i + 1 < rounds.size(); i++) {
          FilterRun run(ranks, {{"points", {{"p", {}, 1, at}}}, {"fields", sources(rounds[i], ranks)}},
                        freeServices());
          at = evaluate(*makeFilter<Interpolate>(), run, "{}").dataset;
        }
        return FilterRun::Inputs{{"points", {{"p", {}, 1, at}}}, {"fields", sources(rounds.back(), ranks)}};
      },
      "{}");
}

TEST(Interpolate, RecordsSeveralFieldsWithAllComponentsOnAnyRanksAndCuts) {
  const WholeVolume scalar = sampled(oddGrid({12, 9, 7}), [](glm::dvec3 p) { return p.x + 2; });
  WholeVolume vectors = sampled(oddGrid({6, 5, 4}), [](glm::dvec3) { return 0.0; });
  vectors.components = 2;
  std::vector<float> values;
  for (size_t i = 0; i < vectors.samples.size() / sizeof(float); i++) values.insert(values.end(), {3, 4});
  vectors.samples.resize(values.size() * sizeof(float));
  std::memcpy(vectors.samples.data(), values.data(), vectors.samples.size());
  const std::string seeds = R"({"shape": "grid", "dimensions": [9, 8, 7]})";
  const auto on = [&](const Cut& cut) {
    return interpolatedInTurn({{{"v", &vectors}, {"s", &scalar}}}, cut, seeds);
  };
  const MadePoints all = on(test::whole(scalar.grid.box()));
  ASSERT_EQ(all.points.size(), 504u) << all.error;
  size_t inside = 0;
  for (const auto& [id, p] : all.points) {
    const std::vector<float>& fields = all.fields.at(id);
    ASSERT_EQ(fields.size(), 3u);
    EXPECT_NEAR(fields[2], p.point.x + 2, 1e-5);
    if (std::isnan(p.value)) continue;
    inside++;
    EXPECT_EQ(p.value, 5);
    EXPECT_EQ(fields[0], 3);
    EXPECT_EQ(fields[1], 4);
  }
  EXPECT_EQ(504 - inside, all.told.at("outside").get<size_t>());
  ASSERT_GT(inside, 10u);
  const nlohmann::json& told = all.told.at("fields");
  EXPECT_EQ(told.at(0).at("name"), "mag(v)");
  EXPECT_EQ(told.at(1), (nlohmann::json{{"name", "v"},
                                        {"components", 2},
                                        {"range", {5.0, 5.0}},
                                        {"outside", 504 - inside},
                                        {"no data", 0}}));
  EXPECT_EQ(told.at(2).at("outside"), 0);
  for (const Cut& cut : manyCuts(scalar.grid.box(), 2)) {
    const MadePoints again = on(cut);
    EXPECT_EQ(again.points, all.points) << cut.name;
    ASSERT_EQ(again.fields.size(), all.fields.size());
    for (const auto& [id, fields] : all.fields)
      ASSERT_EQ(0, std::memcmp(fields.data(), again.fields.at(id).data(), fields.size() * sizeof(float)));
  }
}

TEST(Interpolate, KeepsWhatPointsHadAndReplacesFieldsOfTheSameName) {
  const WholeVolume one = sampled(oddGrid({12, 9, 7}), [](glm::dvec3) { return 1.0; }),
                    two = sampled(oddGrid({12, 9, 7}), [](glm::dvec3) { return 2.0; }),
                    three = sampled(oddGrid({12, 9, 7}), [](glm::dvec3) { return 3.0; });
  const MadePoints made =
      interpolatedInTurn({{{"a", &one}, {"b", &two}}, {{"c", &three}, {"b", &one}}},
                         test::whole(one.grid.box()), R"({"shape": "points", "points": [[0, 3, 2]]})");
  ASSERT_EQ(made.error, "");
  EXPECT_EQ(made.points.at(0).value, 3);
  EXPECT_EQ(made.fields.at(0), (std::vector<float>{1, 1})) << "b, and a, which was shown";
  EXPECT_EQ(made.told.at("fields").at(0).at("name"), "c");
  EXPECT_EQ(made.told.at("fields").at(1).at("name"), "b");
  EXPECT_EQ(made.told.at("fields").at(2).at("name"), "a");
}

TEST(Interpolate, RefusesTwoFieldsOfOneName) {
  const WholeVolume one = sampled(oddGrid({12, 9, 7}), [](glm::dvec3) { return 1.0; });
  EXPECT_NE(interpolatedInTurn({{{"a", &one}, {"a", &one}}}, test::whole(one.grid.box()), "{}")
                .error.find("\"a\" is there twice"),
            std::string::npos);
}

}  // namespace
}  // namespace gxy::test

// SPDX-License-Identifier: Apache-2.0
// The filters Derive and Statistics: what they tell, and what they refuse.
#include "core/analysis/derive_filter.h"

#include "core/analysis/number_filter.h"
#include "core/analysis/seeds_filter.h"
#include "core/analysis/statistics_filter.h"
#include "core/comm/error.h"
#include "tests/analysis/filter_setup.h"

namespace gxy::test {
namespace {

Grid smallGrid() {
  Grid grid;
  grid.points = {9, 5, 4};
  grid.spacing = {0.5, 1, 2};
  return grid;
}

/// What a filter tells of inputs by name.
template <class T>
std::pair<nlohmann::json, std::string> told(const std::map<std::string, WholeVolume>& inputs,
                                            const std::string& properties, int n = 3) {
  const Cut cut = lattice(smallGrid().box(), {2, 2, 1}, n);
  nlohmann::json told;
  ThreadRanks world(n);
  const auto errors = world.run([&](Collectives& ranks) {
    FilterRun::Inputs all;
    for (const auto& [name, whole] : inputs)
      all[name].push_back({"dataset " + name, {}, 1, datasetOf(whole, cut, ranks.rank())});
    FilterRun run(ranks, std::move(all), freeServices());
    const FilterResult result = evaluate(*makeFilter<T>(), run, properties);
    if (ranks.rank() == 0) told = result.told;
  });
  for (const std::string& error : errors) EXPECT_EQ(error.empty(), errors[0].empty()) << error;
  return {told, errors[0]};
}

const WholeVolume kRamp = sampled(smallGrid(), [](glm::dvec3 p) { return p.x; });

TEST(DeriveFilter, ComputesAFieldAndTellsItsRange) {
  const auto [told, error] =
      test::told<Derive>({{"a", kRamp}, {"b", kRamp}}, R"json({"expression": "[a, 2 * b, 0].y + 1"})json");
  EXPECT_EQ(error, "");
  EXPECT_EQ(told.at("range"), (nlohmann::json{1, 9}));
  EXPECT_EQ(told.at("no data"), 0);
  EXPECT_EQ(test::told<Derive>({{"a", kRamp}}, R"json({"expression": "1 / a"})json").first.at("no data"), 20);
  EXPECT_EQ(test::told<Derive>({{"a", kRamp}}, R"json({"expression": "grad(a)"})json").first.at("components"),
            3);
}

TEST(DeriveFilter, WrongExpressionsAndInputsAreRefusedOnAllRanks) {
  EXPECT_NE(test::told<Derive>({{"a", kRamp}}, R"json({"expression": "curl(a)"})json").second.find("curl"),
            std::string::npos);
  EXPECT_NE(
      test::told<Derive>({{"a", kRamp}}, R"json({"expression": "c"})json").second.find("line 1, column 1"),
      std::string::npos);
  EXPECT_NE(test::told<Derive>({}, R"json({"expression": "x"})json").second.find("Derive: there is no input"),
            std::string::npos);
}

TEST(DeriveFilter, AWrongExpressionIsAnErrorOfTheEntryWithItsPosition) {
  try {
    readDatasetEntries("{\"name\": \"d\", \"filter\": \"Derive\",\n \"expression\": \"1 +\"}", "s",
                       &standardFilters());
    FAIL();
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("s:2:16: `expression`: "), std::string::npos) << e.what();
  }
}

TEST(NumberFilter, TellsANumberOrWhetherAConditionHolds) {
  const auto value = [](const std::string& expression) {
    const auto [told, error] =
        test::told<NumberFilter>({{"a", kRamp}, {"b", kRamp}}, R"({"expression": ")" + expression + "\"}");
    EXPECT_EQ(error, "") << expression;
    return told.value("value", nlohmann::json("none"));
  };
  EXPECT_EQ(value("max(a) - min(b) + 0.5"), 4.5);
  EXPECT_EQ(value("max(a) > 3 and mean(b) < 3"), true);
  EXPECT_EQ(value("max(a) > 4"), false);
  EXPECT_EQ(value("max(1 / (a - a)) > 4"), nullptr);
  EXPECT_EQ(value("max(1 / (a - a))"), nullptr);
  EXPECT_NE(test::told<NumberFilter>({{"a", kRamp}}, R"({"expression": "a > 3"})").second, "");
  EXPECT_NE(test::told<NumberFilter>({}, R"({"expression": "1"})").second.find("Number: there is no input"),
            std::string::npos);
}

TEST(StatisticsFilter, TellsNumbersOfAFieldEverywhereOrWhereAConditionHolds) {
  const auto [all, error] =
      told<StatisticsFilter>({{"field", kRamp}}, R"json({"histogram": 4, "quantiles": [0, 0.5, 1]})json");
  EXPECT_EQ(error, "");
  EXPECT_EQ(all.at("count"), 180);
  EXPECT_EQ(all.at("mean"), 2);
  EXPECT_EQ(all.at("integral"), 2 * 4 * 4 * 6);
  EXPECT_EQ(all.at("largest").at("value"), 4);
  EXPECT_EQ(all.at("largest").at("position"), (nlohmann::json{4, 0, 0}));
  EXPECT_EQ(all.at("histogram").at("counts"), (nlohmann::json{40, 40, 40, 60}));
  EXPECT_EQ(all.at("quantiles"), (nlohmann::json{0, 2, 4}));
  const auto some =
      told<StatisticsFilter>({{"field", kRamp}, {"t", kRamp}}, R"json({"where": "field > 3 and t < 4"})json")
          .first;
  EXPECT_EQ(some.at("count"), 20);
  EXPECT_EQ(some.at("mean"), 3.5);
}

TEST(StatisticsFilter, OfGeometryHasNoCondition) {
  SingleRank alone;
  const Cut cut = whole(smallGrid().box());
  FilterRun seeds(alone, {{"domain", {{"v", {}, 1, datasetOf(kRamp, cut, 0)}}}}, freeServices());
  const auto points = evaluate(*makeFilter<Seeds>(), seeds, "{}").dataset;
  const auto told = [&](const std::string& properties) {
    FilterRun run(alone, {{"field", {{"p", {}, 1, points}}}}, freeServices());
    return evaluate(*makeFilter<StatisticsFilter>(), run, properties).told;
  };
  EXPECT_EQ(told("{}").at("count"), 0) << "seeds have no values";
  EXPECT_THROW(told(R"json({"where": "field > 0"})json"), Error);
}

}  // namespace
}  // namespace gxy::test

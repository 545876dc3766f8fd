// SPDX-License-Identifier: Apache-2.0
#include "tools/gxyviewer/series.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/comm/error.h"

namespace gxy::test {
namespace {

Series seriesOf(size_t steps) {
  std::vector<Series::Step> all(steps);
  for (size_t i = 0; i < steps; i++) all[i].files["s"] = "s_" + std::to_string(i) + ".vti";
  DatasetSpec changing, same;
  changing.name = "s";
  same.name = same.filename = "same.vtp";
  return {{changing, same}, std::move(all)};
}

std::string begun(Series& series) {
  const auto step = series.begin();
  return step ? std::to_string(*step) : "none";
}

TEST(Series, DataOfOneStepHaveNoOther) {
  Series series;
  EXPECT_EQ(series.count(), 1u);
  for (const int by : {1, -1}) series.next(by);
  series.last();
  EXPECT_EQ(begun(series), "none");
}

TEST(Series, EachStepHasItsFilesAndThoseThatAreInAll) {
  const Series series = seriesOf(3);
  const std::vector<DatasetSpec> datasets = series.datasetsAt(2);
  ASSERT_EQ(datasets.size(), 2u);
  EXPECT_EQ(datasets[0].filename, "s_2.vti");
  EXPECT_EQ(datasets[1].filename, "same.vtp");
}

TEST(Series, EndsAtTheFirstAndTheLastStep) {
  Series series = seriesOf(3);
  series.next(-1);
  EXPECT_EQ(series.wanted(), 0u);
  series.last();
  series.next(1);
  EXPECT_EQ(series.wanted(), 2u);
  series.first();
  EXPECT_EQ(series.wanted(), 0u);
}

TEST(Series, OfStepsThatAreWantedWhileOneIsOnItsWayTheLastIsAskedFor) {
  Series series = seriesOf(9);
  series.next(1);
  EXPECT_EQ(begun(series), "1");
  for (int i = 0; i < 4; i++) {
    series.next(1);
    EXPECT_EQ(begun(series), "none") << "one at a time";
  }
  series.end(true);
  EXPECT_EQ(series.there(), 1u);
  EXPECT_EQ(begun(series), "5");
  series.end(true);
  EXPECT_EQ(begun(series), "none");
  EXPECT_EQ(series.there(), 5u);
}

TEST(Series, AStepThatIsLeftWhileItIsOnItsWayIsLeftOnceItIsThere) {
  Series series = seriesOf(3);
  series.next(1);
  series.begin();
  series.next(-1);
  series.end(true);
  EXPECT_EQ(begun(series), "0");
}

TEST(Series, AStepThatCannotBeHadLeavesTheOneBeforeAndIsPassedBy) {
  Series series = seriesOf(5);
  const auto go = [&](int by, bool comes) {
    series.next(by);
    const std::string step = begun(series);
    if (step != "none") series.end(comes);
    return step;
  };
  EXPECT_EQ(go(1, true), "1");
  EXPECT_EQ(go(1, false), "2");
  EXPECT_EQ(series.there(), 1u);
  EXPECT_EQ(series.wanted(), 1u) << "it is not asked for again by itself";
  EXPECT_EQ(go(1, true), "3");
  EXPECT_EQ(go(-1, false), "2") << "it may be there by now";
  EXPECT_EQ(go(-1, true), "1");
  EXPECT_EQ(go(1, true), "2");
  EXPECT_EQ(go(1, true), "3");
  EXPECT_EQ(go(1, false), "4");
  EXPECT_EQ(go(1, true), "4") << "behind the last there is none";
}

TEST(Series, WhatWasWantedMeanwhileIsAskedForAlsoAfterOneThatCannotBeHad) {
  Series series = seriesOf(5);
  series.next(1);
  series.begin();
  series.next(1);
  EXPECT_EQ(series.end(false), 1u);
  EXPECT_EQ(begun(series), "2");
}

TEST(Series, HasTheGenerationThatItsDataHave) {
  Series series = seriesOf(9);
  for (const uint64_t generation : {7, 1, 2}) {  // as of data that others dropped or changed
    series.next(1);
    ASSERT_TRUE(series.begin());
    series.end(true, generation);
    EXPECT_EQ(series.generation(), generation);
    EXPECT_EQ(series.stepOf(generation), series.there());
  }
  EXPECT_EQ(series.there(), 3u);
  EXPECT_EQ(series.stepOf(1), 2u) << "its picture may still be seen";
}

TEST(Series, KnowsTheStepOfAGenerationBeforeItIsSaidToBeThere) {
  Series series = seriesOf(9);
  EXPECT_EQ(series.generation(), 1u);
  EXPECT_EQ(series.stepOf(1), 0u);
  series.last();
  series.begin();
  EXPECT_EQ(series.stepOf(2), 8u);
  EXPECT_EQ(series.stepOf(1), 0u);
  series.end(false);
  series.next(3);
  series.begin();
  series.end(true);
  EXPECT_EQ(series.generation(), 2u);
  EXPECT_EQ(series.stepOf(2), 3u);
  EXPECT_EQ(series.stepOf(1), 0u) << "its picture may still be seen";
  EXPECT_EQ(series.stepOf(7), 3u) << "somebody else's";
}

TEST(Series, TellsTheStepAndItsTimeWhereThatIsKnown) {
  EXPECT_EQ(seriesOf(3).textOf(0), "step 1 of 3");
  const Series series(
      {}, stepsFrom(nlohmann::json::parse(R"([{"time": 0.1, "files": {}}, {"time": null, "files": {}}])")));
  EXPECT_EQ(series.textOf(0), "step 1 of 2, time 0.1");
  EXPECT_EQ(series.textOf(1), "step 2 of 2");
  EXPECT_EQ(series.timeOf(0), 0.1);
}

TEST(Series, AnAnswerThatIsNoneIsAnErrorThatSaysWhatWasExpected) {
  for (const char* text : {"null", "[]", "{}", "[1]", "[{}]", R"([{"files": []}])",
                           R"([{"files": {"a": 1}}])", R"([{"files": {"a": "b"}}, null])"}) {
    try {
      stepsFrom(nlohmann::json::parse(text));
      ADD_FAILURE() << text;
    } catch (const Error& e) {
      EXPECT_NE(std::string(e.what()).find("`steps`: expected a list"), std::string::npos) << e.what();
    }
  }
}

/// The names of datasets whose steps have files, when others are taken.
std::vector<std::string> namesOf(const std::vector<std::vector<std::string>>& filesByDataset,
                                 const std::set<std::string>& taken = {}) {
  State state;
  std::vector<Series::Step> steps(filesByDataset[0].size());
  Visualization& visualization = state.visualizations.emplace_back();
  for (size_t d = 0; d < filesByDataset.size(); d++) {
    state.datasets.emplace_back().name = "d" + std::to_string(d);
    state.datasets[d].filename = filesByDataset[d][0];
    visualization.operators.emplace_back().dataset = state.datasets[d].name;
    for (size_t n = 0; n < steps.size(); n++) steps[n].files[state.datasets[d].name] = filesByDataset[d][n];
  }
  const Series series = makeSeries(state, steps, taken);
  std::vector<std::string> names;
  for (size_t d = 0; d < filesByDataset.size(); d++) {
    names.push_back(state.datasets[d].name);
    EXPECT_EQ(visualization.operators[d].dataset, names[d]);
    for (size_t n = 0; n < steps.size(); n++)
      EXPECT_EQ(series.datasetsAt(n)[d].filename, filesByDataset[d][n]);
  }
  return names;
}

TEST(Series, DatasetsGetNamesOfTheirOwnThatFitAllSteps) {
  using Names = std::vector<std::string>;
  EXPECT_EQ(namesOf({{"/x/s_1.vti", "/x/s_2.vti", "/x/s_10.vti"}}), Names{"s_*"});
  EXPECT_EQ(namesOf({{"s_1.vti", "s_2.vti"}}, {"s_*", "s_*-2"}), Names{"s_*-3"});
  EXPECT_EQ(namesOf({{"a1b.vti", "a11b.vti"}}), Names{"a1*b"});
  EXPECT_EQ(namesOf({{"x.vti", "y.vti"}}), Names{"d0"}) << "they have nothing in common";
  EXPECT_EQ(namesOf({{"t1/p.vtp", "t2/p.vtp"}}), Names{"p"});
  EXPECT_EQ(namesOf({{"s_1.vti", "s_2.vti"}, {"s_3.vti", "s_4.vti"}}), (Names{"s_*", "s_*-2"}));
}

}  // namespace
}  // namespace gxy::test

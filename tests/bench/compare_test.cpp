// SPDX-License-Identifier: Apache-2.0
#include "tools/gxybench/compare.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/bench/rows.h"

namespace gxy::bench::test {
namespace {

/// A method whose error falls with the given power of its time, at the settings 1, 1/2, 1/4, ...
std::vector<Row> curve(double costs, double power, int settings, double first = 1, double spread = 0) {
  std::vector<Row> rows;
  for (int i = 0; i < settings; i++) {
    const double time = first * std::exp2(i);
    rows.push_back(row("fixed", std::to_string(first) + "/" + std::to_string(i), costs * time,
                       std::pow(time, -power), spread * costs * time));
  }
  return rows;
}

Change onlyChange(const std::vector<Row>& older, const std::vector<Row>& newer, const CurveAxes& axes = {}) {
  const std::vector<Change> all = changes(older, newer, axes);
  EXPECT_EQ(all.size(), 1u);
  return all.at(0);
}

TEST(Compare, RatioIsThatOfPowerLawsWhateverTheSettings) {
  for (double power : {1.0, 2.0, 4.0}) {
    const Change c = onlyChange(curve(1, power, 8), curve(1.75, power, 5, 1.3));
    EXPECT_FALSE(c.atSettings);
    EXPECT_NEAR(c.ratio, 1.75, 1e-12);
    EXPECT_NEAR(c.least, 1.75, 1e-12);
    EXPECT_NEAR(c.most, 1.75, 1e-12);
    EXPECT_TRUE(c.slower());
  }
}

TEST(Compare, ASettingThatAnotherBeatsInTimeAndErrorDoesNotCount) {
  std::vector<Row> newer = curve(1, 2, 6);
  newer.push_back(row("fixed", "bad", 100, 0.5));
  EXPECT_NEAR(onlyChange(curve(1, 2, 6), newer).ratio, 1, 1e-12);
}

TEST(Compare, WhatLiesWithinTheScatterOfRepeatsHasNotMoved) {
  const Change wide = onlyChange(curve(1, 2, 6, 1, 0.2), curve(1.1, 2, 6, 1, 0.2));
  EXPECT_NEAR(wide.noise, 0.1 * std::sqrt(2), 1e-12);  // half spreads of two runs
  EXPECT_FALSE(wide.slower());
  const Change narrow = onlyChange(curve(1, 2, 6), curve(1.1, 2, 6));
  EXPECT_NEAR(narrow.noise, 0.02, 1e-12);
  EXPECT_TRUE(narrow.slower());
  EXPECT_TRUE(onlyChange(curve(1.1, 2, 6), curve(1, 2, 6)).faster());
}

TEST(Compare, ASingleFrameIsTakenToScatterWidely) {
  std::vector<Row> once = curve(1.3, 2, 6);
  for (Row& r : once) r.repeats = 1;
  EXPECT_FALSE(onlyChange(once, once).slower());
  EXPECT_GT(onlyChange(curve(1, 2, 6), once).noise, 0.2);
}

TEST(Compare, SingleSettingsAreComparedAsTheyAre) {
  const Change c = onlyChange({row("adaptive", "1/512", 2, 1e-3)}, {row("adaptive", "1/512", 1, 2e-3)});
  EXPECT_TRUE(c.atSettings);
  EXPECT_NEAR(c.ratio, 0.5, 1e-12);
  EXPECT_NEAR(c.errorRatio, 2, 1e-12);
}

TEST(Compare, TimeAndErrorAreThoseAskedFor) {
  std::vector<Row> newer = curve(1, 2, 6);
  for (Row& r : newer) r.wall *= 3, r.maxError *= 4;  // the error of half the time, at order 2
  EXPECT_NEAR(onlyChange(curve(1, 2, 6), newer, {true, &Row::rmsError}).ratio, 3, 1e-12);
  EXPECT_NEAR(onlyChange(curve(1, 2, 6), newer, {false, &Row::maxError}).ratio, 2, 1e-12);
}

TEST(Compare, LostHitsBrokenTolerancesAndMissingCurvesAreRegressions) {
  Row older = row("adaptive", "1/512", 1, 1e-4), newer = older;
  older.hits = newer.hits = 100;
  EXPECT_FALSE(onlyChange({older}, {newer}).regressed());
  newer.missed = 2;
  EXPECT_EQ(onlyChange({older}, {newer}).remark, "2 more wrong hits");
  newer = older;
  newer.maxError = 1.5;
  EXPECT_EQ(onlyChange({older}, {newer}).remark, "tolerance 1/512 no longer held");
  newer = older = row("fixed", "1/2", 1, 1e-4);
  newer.maxError = INFINITY;  // what a NaN in a picture counts as
  EXPECT_EQ(onlyChange({older}, {newer}).remark, "pixels that are no number at 1/2");
  EXPECT_TRUE(onlyChange({older}, {newer}).regressed());
  EXPECT_TRUE(onlyChange({older}, {}).regressed());
  EXPECT_FALSE(onlyChange({}, {newer}).regressed());
}

TEST(Compare, ErrorsFlipsAndDistancesOfHitsThatGrowAreRegressions) {
  Row older = row("adaptive", "1/512", 1, 1e-4), newer = older;
  older.width = newer.width = older.height = newer.height = 100;
  newer.rmsError = 1.4e-4;
  EXPECT_FALSE(onlyChange({older}, {newer}).regressed());
  newer.rmsError = 2e-4;
  EXPECT_EQ(onlyChange({older}, {newer}).remark, "error 2.000 times as large");
  newer = older;
  newer.flips = 10;
  EXPECT_FALSE(onlyChange({older}, {newer}).regressed());
  newer.flips = 11;
  EXPECT_EQ(onlyChange({older}, {newer}).remark, "11 more flips at 1/512");
  newer = older;
  older.dtMax = 1e-5, newer.dtMax = 1e-4;
  EXPECT_FALSE(onlyChange({older}, {newer}).regressed());
  newer.dtMax = 0.4;
  EXPECT_EQ(onlyChange({older}, {newer}).remark, "hits further off at 1/512");
}

TEST(Compare, PicturesOfOtherSizesAreNotCompared) {
  std::vector<Row> newer = curve(1, 2, 6);
  for (Row& r : newer) r.width += 1;
  EXPECT_EQ(onlyChange(curve(1, 2, 6), newer).ratio, 0);
  EXPECT_EQ(onlyChange(curve(1, 2, 6), newer).remark, "measured at another size");
}

TEST(Compare, CurvesAreToldApartBySceneMethodBackendAndRanks) {
  std::vector<Row> rows(5, row("fixed", "1", 1, 1));
  rows[1].scene = "other", rows[2].method = "adaptive", rows[3].backend = "vulkan", rows[4].ranks = 2;
  const std::vector<Change> all = changes(rows, rows, {});
  EXPECT_EQ(all.size(), 5u);
  for (const Change& c : all) EXPECT_EQ(c.ratio, 1);
  EXPECT_NE(report(all).find("fixed, embree, 2 ranks"), std::string::npos);
}

}  // namespace
}  // namespace gxy::bench::test

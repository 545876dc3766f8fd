// SPDX-License-Identifier: Apache-2.0
#include "tools/gxybench/errors.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/comm/error.h"

namespace gxy::bench::test {
namespace {

constexpr double kMiss = 1e30;

/// A grey picture of hits at distance 1, in cells of 0.1, in which nothing changes under perturbation.
Truth greyTruth(int width, int height) {
  Truth t;
  t.width = width, t.height = height;
  const size_t n = size_t(width) * size_t(height);
  t.rgb.assign(3 * n, 0.5f);
  t.low = t.high = t.rgb;
  t.depth.assign(n, 1.0);
  t.nearest = t.farthest = t.depth;
  t.cell = 0.1;
  return t;
}

Picture pictureOf(const Truth& t) {
  Picture p{t.width, t.height, {}, t.depth};
  for (size_t i = 0; i < t.depth.size(); i++)
    p.rgba.insert(p.rgba.end(), {t.rgb[3 * i], t.rgb[3 * i + 1], t.rgb[3 * i + 2], 1.f});
  return p;
}

Row compared(const Truth& truth, const Picture& picture, bool isosurfaces = false) {
  Row row;
  row.tolerance = 1.0 / 512;
  compareWith(truth, picture, isosurfaces, row);
  return row;
}

TEST(Errors, AreThoseOfAKnownDifference) {
  const Truth truth = greyTruth(100, 50);
  Picture picture = pictureOf(truth);
  for (size_t i = 0; i < 4; i++) picture.rgba[4 * i] += 0.25f;  // under 0.1 % of 5000 pixels
  picture.rgba[4 * 7 + 3] = 0;                                  // alpha does not count
  const Row row = compared(truth, picture);
  EXPECT_DOUBLE_EQ(row.maxError, 0.25);
  EXPECT_NEAR(row.rmsError, 0.25 * std::sqrt(4.0 / 15000), 1e-12);
  EXPECT_EQ(row.p999Error, 0);
  EXPECT_EQ(row.flips, 0);
  EXPECT_EQ(row.hits, -1);
  for (size_t i = 4; i < 6; i++) picture.rgba[4 * i] += 0.125f;  // over 0.1 %
  EXPECT_DOUBLE_EQ(compared(truth, picture).p999Error, 0.125);
}

TEST(Errors, AFlipNeedsATruthThatChangesAndAPictureAmongItsValues) {
  Truth truth = greyTruth(10, 10);
  truth.high[0] = 0.9f;
  Picture picture = pictureOf(truth);
  picture.rgba[0] = 0.7f;
  EXPECT_EQ(compared(truth, picture).flips, 1);
  EXPECT_EQ(compared(truth, picture).maxError, 0);
  picture.rgba[0] = 0.95f;  // beyond what the truth ever shows
  EXPECT_EQ(compared(truth, picture).flips, 0);
  EXPECT_NEAR(compared(truth, picture).maxError, 0.45, 1e-6);
  picture.rgba[0] = 0.5f;
  picture.rgba[4] = 0.7f;  // a pixel that never changes
  EXPECT_EQ(compared(truth, picture).flips, 0);
}

TEST(Errors, ANumberThatIsNoneIsInfinitelyWrong) {
  const Truth truth = greyTruth(4, 4);
  Picture picture = pictureOf(truth);
  picture.rgba[5] = NAN;
  EXPECT_TRUE(std::isinf(compared(truth, picture).maxError));
}

TEST(Errors, HitsAreMissedExtraOrOnTheWrongSheet) {
  Truth truth = greyTruth(10, 10);
  truth.depth[3] = truth.nearest[3] = truth.farthest[3] = kMiss;
  Picture picture = pictureOf(truth);
  picture.depth[0] = kMiss;
  picture.depth[1] = 1.06;  // over half a cell
  picture.depth[2] = 1.04;  // 0.4 cells
  picture.depth[3] = 1;
  const Row row = compared(truth, picture, true);
  EXPECT_EQ(row.hits, 99);
  EXPECT_EQ(row.missed, 1);
  EXPECT_EQ(row.wrongSheet, 1);
  EXPECT_EQ(row.extra, 1);
  EXPECT_NEAR(row.dtMax, 0.4, 1e-9);
  EXPECT_NEAR(row.dtRms, 0.4 / std::sqrt(97.0), 1e-9);
}

TEST(Errors, AHitThatTheTruthGivesUpUnderPerturbationIsAFlip) {
  Truth truth = greyTruth(10, 10);
  truth.farthest[0] = kMiss;
  truth.farthest[1] = 3;
  Picture picture = pictureOf(truth);
  picture.depth[0] = kMiss;
  picture.depth[1] = 3;
  const Row row = compared(truth, picture, true);
  EXPECT_EQ(row.flips, 2);
  EXPECT_EQ(row.missed + row.extra + row.wrongSheet, 0);
}

TEST(Errors, PicturesOfOtherSizesAreRefused) {
  EXPECT_THROW(compared(greyTruth(10, 10), pictureOf(greyTruth(10, 9))), Error);
}

}  // namespace
}  // namespace gxy::bench::test

// SPDX-License-Identifier: Apache-2.0
// What gpu_report calls agreement.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "gpu-report/difference.h"

namespace gxy::gpu_report {
namespace {

constexpr size_t kPixels = 1000;  // of which one may differ

Picture plain() { return {40, 25, std::vector<float>(4 * kPixels, 0.5f), std::vector<double>(kPixels, 3.0)}; }

Difference ofChanged(size_t pixels, double by, double depthTo = 3.0) {
  Picture found = plain();
  for (size_t p = 0; p < pixels; p++) found.rgba[4 * p + 1] += float(by), found.depth[p] = depthTo;
  return differenceOf(plain(), found);
}

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kUlp = 0x1p-22;  // of 3

TEST(Difference, OfAPictureToItselfIsNone) {
  const Difference d = ofChanged(0, 0);
  EXPECT_TRUE(d.agrees());
  EXPECT_EQ(d.equal, kPixels);
  EXPECT_EQ(d.hits, kPixels);
  EXPECT_EQ(d.largest, 0);
}

TEST(Difference, OfOnePixelInAThousandAgrees) {
  EXPECT_TRUE(ofChanged(1, 0.4, 1e30).agrees());
  EXPECT_FALSE(ofChanged(2, 0.4).agrees());
}

TEST(Difference, HoweverSmallOfMorePixelsDoesNotAgree) {
  const Difference d = ofChanged(2, 1e-6);
  EXPECT_EQ(d.far, 0u);
  EXPECT_EQ(d.equal, kPixels - 2);
  EXPECT_FALSE(d.agrees());
}

TEST(Difference, OfDepthsIsFarBeyondFourUlp) {
  EXPECT_TRUE(ofChanged(2, 0, 3 + 4 * kUlp).agrees());
  EXPECT_FALSE(ofChanged(2, 0, 3 + 4.5 * kUlp).agrees());
  EXPECT_FALSE(ofChanged(2, 0, kNan).agrees());
}

TEST(Difference, CountsHitsOfOnePictureOnly) {
  const Difference lost = ofChanged(2, 0, 1e30);
  EXPECT_EQ(lost.hits, kPixels);
  EXPECT_EQ(lost.hitsFar, 2u);
  EXPECT_FALSE(lost.agrees());
  Picture missed = plain(), found = plain();
  missed.depth.assign(kPixels, 1e30), found.depth = missed.depth;
  EXPECT_TRUE(differenceOf(missed, found).agrees());
  found.depth[5] = 3;
  EXPECT_EQ(differenceOf(missed, found).hits, 1u);
  EXPECT_FALSE(differenceOf(missed, found).agrees());
}

TEST(Difference, OfWhatIsNoNumberIsFar) {
  EXPECT_EQ(ofChanged(2, kNan).far, 2u);
  EXPECT_FALSE(ofChanged(2, kNan).agrees());
}

}  // namespace
}  // namespace gxy::gpu_report

// SPDX-License-Identifier: Apache-2.0
// Tests the comparison of pictures: by bits, and by closeness, as gpu_report and tests on a GPU use it.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/support/close_pictures.h"
#include "tests/support/difference.h"

namespace gxy::test {
namespace {

constexpr size_t kPixels = 1000;  // One of these may differ.

Picture plain() { return {40, 25, LargeVector<float>(4 * kPixels, 0.5f), std::vector<double>(kPixels, 3.0)}; }

Picture changed(size_t pixels, double by, double depthTo = 3.0) {
  Picture found = plain();
  for (size_t p = 0; p < pixels; p++) found.rgba[4 * p + 1] += float(by), found.depth[p] = depthTo;
  return found;
}

Closeness ofChanged(size_t pixels, double by, double depthTo = 3.0) {
  return closenessOf(plain(), changed(pixels, by, depthTo));
}

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kUlp = 0x1p-22;  // an ulp of the float 3

TEST(Closeness, OfAPictureToItselfIsNone) {
  const Closeness d = ofChanged(0, 0);
  EXPECT_TRUE(d.agrees());
  EXPECT_EQ(d.equal, kPixels);
  EXPECT_EQ(d.hits, kPixels);
  EXPECT_EQ(d.largest, 0);
}

TEST(Closeness, OfOnePixelInAThousandAgrees) {
  EXPECT_TRUE(ofChanged(1, 0.4, 1e30).agrees());
  EXPECT_FALSE(ofChanged(2, 0.4).agrees());
}

TEST(Closeness, HoweverSmallOfMorePixelsDoesNotAgree) {
  const Closeness d = ofChanged(2, 1e-6);
  EXPECT_EQ(d.far, 0u);
  EXPECT_EQ(d.equal, kPixels - 2);
  EXPECT_FALSE(d.agrees());
}

TEST(Closeness, OfDepthsIsFarBeyondFourUlp) {
  EXPECT_TRUE(ofChanged(2, 0, 3 + 4 * kUlp).agrees());
  EXPECT_FALSE(ofChanged(2, 0, 3 + 4.5 * kUlp).agrees());
  EXPECT_FALSE(ofChanged(2, 0, kNan).agrees());
}

TEST(Closeness, CountsHitsOfOnePictureOnly) {
  const Closeness lost = ofChanged(2, 0, 1e30);
  EXPECT_EQ(lost.hits, kPixels);
  EXPECT_EQ(lost.hitsFar, 2u);
  EXPECT_FALSE(lost.agrees());
  Picture missed = plain(), found = plain();
  missed.depth.assign(kPixels, 1e30), found.depth = missed.depth;
  EXPECT_TRUE(closenessOf(missed, found).agrees());
  found.depth[5] = 3;
  EXPECT_EQ(closenessOf(missed, found).hits, 1u);
  EXPECT_FALSE(closenessOf(missed, found).agrees());
}

TEST(Closeness, OfWhatIsNoNumberIsFar) {
  EXPECT_EQ(ofChanged(2, kNan).far, 2u);
  EXPECT_FALSE(ofChanged(2, kNan).agrees());
}

TEST(Closeness, OfPicturesWithoutDepthsIsOfTheirColors) {
  Picture expected = plain(), one = changed(1, 0.4), two = changed(2, 0.4);
  for (Picture* picture : {&expected, &one, &two}) picture->depth.clear();
  EXPECT_EQ(closenessOf(expected, one).pixels, kPixels);
  EXPECT_TRUE(closenessOf(expected, one).agrees());
  EXPECT_FALSE(closenessOf(expected, two).agrees());
}

TEST(Difference, IsOfAnyBitUnlessClosePicturesAreTheSame) {
  EXPECT_EQ(testedSameness(), Sameness::Bits) << "no GPU has drawn anything here";
  EXPECT_EQ(difference(plain(), plain()), "");
  for (const Picture& found : {changed(1, 1e-7), changed(1, 0, 3 + kUlp)}) {
    EXPECT_EQ(difference(plain(), found).find("1 pixels differ; see "), 0u);
    EXPECT_EQ(difference(plain(), found, Sameness::Close), "");
  }
  EXPECT_EQ(
      difference(plain(), changed(2, 0.4, 1e30), Sameness::Close)
          .find("2 pixels differ of 1000, 2 by more than 1/255, and 2 of 1000 hits by more than 4 ulp; see "),
      0u);
}

TEST(Difference, IsOfSizesFirst) {
  Picture narrower = plain();
  narrower.width = 25, narrower.height = 40;
  EXPECT_EQ(difference(plain(), narrower, Sameness::Close), "the sizes differ");
}

}  // namespace
}  // namespace gxy::test

// SPDX-License-Identifier: Apache-2.0
#include "core/annotate/overlay.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <glm/vec4.hpp>
#include <limits>

#include "core/image/text_mask.h"

namespace gxy {
namespace {

constexpr int kWidth = 40, kHeight = 30;

Image grey() {
  Image image{kWidth, kHeight, LargeVector<float>(size_t(kWidth) * kHeight * 4)};
  std::fill(image.rgba.begin(), image.rgba.end(), 0.5f);
  return image;
}

glm::vec4 pixelAt(const Image& image, int x, int y) {
  const float* p = &image.rgba[4 * size_t(y * image.width + x)];
  return {p[0], p[1], p[2], p[3]};
}

Image drawnOver(const Overlay& overlay) {
  Image image = grey();
  draw(overlay, image);
  return image;
}

TEST(Overlay, ALineCoversItsWidth) {
  const Image image = drawnOver({.lines = {{{5, 10.5}, {20, 10.5}, 1, {1, 0, 0}}}});
  const glm::vec4 red(1, 0, 0, 1), before(0.5f);
  for (int x = 6; x < 19; x++) {
    EXPECT_EQ(pixelAt(image, x, 10), red) << x;
    EXPECT_EQ(pixelAt(image, x, 11), before) << x;
    EXPECT_EQ(pixelAt(image, x, 9), before) << x;
  }
  EXPECT_EQ(pixelAt(image, 3, 10), before);
  EXPECT_EQ(pixelAt(image, 22, 10), before);
}

TEST(Overlay, ALineBetweenRowsCoversHalfOfBoth) {
  const Image image = drawnOver({.lines = {{{5, 10}, {20, 10}, 1, {1, 0, 0}}}});
  for (int y : {9, 10}) EXPECT_EQ(pixelAt(image, 12, y), glm::vec4(0.75f, 0.25f, 0.25f, 0.75f));
}

TEST(Overlay, SteepAndFlatLinesAreAlike) {
  const Image flat = drawnOver({.lines = {{{3, 4}, {25, 11}, 2, glm::dvec3(1)}}});
  const Image steep = drawnOver({.lines = {{{4, 3}, {11, 25}, 2, glm::dvec3(1)}}});
  for (int y = 0; y < kHeight; y++)
    for (int x = 0; x < kHeight; x++) EXPECT_EQ(pixelAt(flat, x, y), pixelAt(steep, y, x)) << x << ' ' << y;
}

TEST(Overlay, WhatLiesOutsideIsLeftOut) {
  const Overlay far{
      .lines = {{{-1e12, -1e12}, {-5, -5}, 2, glm::dvec3(1)}, {{50, 0}, {50, 1e300}, 2, glm::dvec3(1)}},
      .bars = {{{100, 100}, {110, 120}, {glm::dvec3(1)}}},
      .texts = {{{-500, 10}, {0, 0}, 14, "far"}}};
  EXPECT_EQ(drawnOver(far).rgba, grey().rgba);
  constexpr double kInfinity = std::numeric_limits<double>::infinity(),
                   kNan = std::numeric_limits<double>::quiet_NaN();
  const Overlay nowhere{
      .lines = {{{kNan, 3}, {5, 5}, 2, glm::dvec3(1)}, {{3, 3}, {kInfinity, 5}, 2, glm::dvec3(1)}},
      .texts = {{{kNan, 10}, {0, 0}, 14, "a"}, {{1e300, 10}, {0, 0}, 14, "b"}}};
  EXPECT_EQ(drawnOver(nowhere).rgba, grey().rgba);
  // through all of it, from far outside
  const Image image = drawnOver({.lines = {{{-1e6, 15.5}, {1e6, 15.5}, 1, glm::dvec3(1)}}});
  for (int x = 0; x < kWidth; x++) EXPECT_EQ(pixelAt(image, x, 15), glm::vec4(1)) << x;
}

TEST(Overlay, ABarHasItsColoursInAFrame) {
  const Image image = drawnOver({.bars = {{{10, 5}, {14, 9}, {{1, 0, 0}, {0, 1, 0}}}}});
  for (int x = 10; x < 14; x++) {
    for (int y : {5, 6}) EXPECT_EQ(pixelAt(image, x, y), glm::vec4(1, 0, 0, 1));
    for (int y : {7, 8}) EXPECT_EQ(pixelAt(image, x, y), glm::vec4(0, 1, 0, 1));
    for (int y : {4, 9}) EXPECT_EQ(pixelAt(image, x, y), glm::vec4(0.5, 0.5, 0.5, 1));
  }
  EXPECT_EQ(pixelAt(image, 15, 7), glm::vec4(0.5f));
}

TEST(Overlay, TextStandsWhereItsAnchorIs) {
  const auto rowsAndColumns = [](glm::dvec2 anchor) {
    const Image image = drawnOver({.texts = {{{20, 15}, anchor, 12, "H"}}});
    glm::ivec4 used(kWidth, kHeight, 0, 0);
    for (int y = 0; y < kHeight; y++)
      for (int x = 0; x < kWidth; x++)
        if (pixelAt(image, x, y).r > 0.7f)
          used = {std::min(used.x, x), std::min(used.y, y), std::max(used.z, x), std::max(used.w, y)};
    return used;
  };
  const glm::ivec4 right = rowsAndColumns({0, 0}), left = rowsAndColumns({1, 1});
  EXPECT_GE(right.x, 20);
  EXPECT_GE(right.y, 15);
  EXPECT_LE(left.z, 20);
  EXPECT_LE(left.w, 15);
  EXPECT_EQ(right.w - right.y, left.w - left.y);
  EXPECT_GE(right.w - right.y, 6);
}

TEST(Overlay, TextAtTheBorderIsMovedIn) {
  const auto brightPixels = [](glm::dvec2 at) {
    const Image image = drawnOver({.texts = {{at, {0.5, 0.5}, 12, "88"}}});
    int n = 0;
    for (int y = 0; y < kHeight; y++)
      for (int x = 0; x < kWidth; x++) n += pixelAt(image, x, y).r > 0.7f;
    return n;
  };
  const int whole = brightPixels({20, 15});
  EXPECT_GT(whole, 10);
  for (const glm::dvec2 at : {glm::dvec2(1, 15), {39, 15}, {20, 2}, {20, 28}, {1, 29}})
    EXPECT_EQ(brightPixels(at), whole) << at.x << ' ' << at.y;
  EXPECT_EQ(brightPixels({-30, 15}), 0);
}

TEST(Overlay, TextIsBlackOnABrightBackground) {
  const Image image = drawnOver({.texts = {{{20, 15}, {0.5, 0.5}, 20, "H"}}, .onBright = true});
  const auto [least, most] = std::ranges::minmax(image.rgba);
  EXPECT_LT(least, 0.1f);
  EXPECT_GT(most, 0.7f);
}

TEST(Overlay, TextOfAnyLengthIsDrawn) {
  const Image image = drawnOver({.texts = {{{2, 10}, {0, 0}, 10, std::string(1 << 20, 'H')}}});
  EXPECT_NE(image.rgba, grey().rgba);
}

TEST(TextMask, HasTheTextsSize) {
  EXPECT_EQ(textMask("", 12).width, 0);
  const TextMask one = textMask("1", 12), two = textMask("11", 12), wide = textMask("\xC3\x84y", 12);
  EXPECT_EQ(one.height, two.height);
  EXPECT_EQ(one.height, wide.height);
  EXPECT_GT(two.width, one.width);
  EXPECT_GT(*std::ranges::max_element(one.coverage), 0.9f);
  for (int x = 0; x < wide.width; x++) EXPECT_EQ(wide.at(x, wide.height - 1), 0.f);  // nothing is cut off
  EXPECT_EQ(one.at(-1, 0), 0.f);
  EXPECT_EQ(one.at(0, one.height), 0.f);
}

}  // namespace
}  // namespace gxy

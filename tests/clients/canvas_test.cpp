// SPDX-License-Identifier: Apache-2.0
#include "tools/gxyviewer/canvas.h"

#include <gtest/gtest.h>

#include "core/comm/error.h"
#include "multiserver/protocol/tile_codec.h"
#include "tools/gxyviewer/upsample.h"

namespace gxy::test {
namespace {

using protocol::PixelHeader;
using protocol::PixelKind;

/// A tile of one grey, opaque.
bool tile(Canvas& canvas, uint64_t frame, uint32_t scale, glm::uvec2 at, glm::uvec2 size, uint8_t grey) {
  PixelHeader h;
  h.frame = frame;
  h.scale = scale;
  h.width = (uint32_t(canvas.size().x) + scale - 1) / scale;
  h.height = (uint32_t(canvas.size().y) + scale - 1) / scale;
  h.x = at.x, h.y = at.y, h.w = size.x, h.h = size.y;
  std::vector<uint8_t> rgba(size_t(size.x) * size.y * 4, grey);
  for (size_t i = 3; i < rgba.size(); i += 4) rgba[i] = 255;
  const Bytes data = protocol::encodeTile(rgba, size.x, size.y, h.encoding, 100);
  h.size = data.size();
  return canvas.take(h, data);
}

bool endPass(Canvas& canvas, uint64_t frame, uint32_t scale) {
  PixelHeader h;
  h.kind = PixelKind::EndOfPass;
  h.frame = frame;
  h.scale = scale;
  h.width = (uint32_t(canvas.size().x) + scale - 1) / scale;
  h.height = (uint32_t(canvas.size().y) + scale - 1) / scale;
  return canvas.take(h, {});
}

/// Greys, row 0 first.
std::vector<int> greys(const Canvas& canvas) {
  std::vector<int> out;
  for (size_t i = 0; i < canvas.rgba().size(); i += 4) out.push_back(canvas.rgba()[i]);
  return out;
}

TEST(Canvas, AFirstPassIsShownWhenItIsWholeAndLaterTilesAtOnce) {
  Canvas canvas({2, 2});
  EXPECT_FALSE(tile(canvas, 1, 2, {0, 0}, {1, 1}, 50));
  EXPECT_EQ(greys(canvas), (std::vector<int>{0, 0, 0, 0}));
  EXPECT_TRUE(endPass(canvas, 1, 2));
  EXPECT_EQ(greys(canvas), (std::vector<int>{50, 50, 50, 50}));
  EXPECT_TRUE(tile(canvas, 1, 1, {1, 0}, {1, 1}, 90));
  EXPECT_EQ(greys(canvas), (std::vector<int>{50, 90, 50, 50}));
  EXPECT_EQ(canvas.frame(), 1u);
}

// The level's pixels have their middles at 1 and 3 of the window's 0 to 4, whose own are at 0.5, 1.5, 2.5 and 3.5.
TEST(Canvas, ACoarseLevelIsInterpolatedBetweenTheMiddlesOfItsPixels) {
  Canvas canvas({4, 4});
  tile(canvas, 1, 2, {0, 0}, {1, 1}, 0);
  tile(canvas, 1, 2, {1, 0}, {1, 1}, 40);
  tile(canvas, 1, 2, {0, 1}, {1, 1}, 80);
  EXPECT_FALSE(tile(canvas, 1, 2, {1, 1}, {1, 1}, 200));
  EXPECT_EQ(greys(canvas), std::vector<int>(16, 0));
  EXPECT_TRUE(endPass(canvas, 1, 2));
  EXPECT_EQ(greys(canvas), (std::vector<int>{0, 10, 30, 40,     //
                                             20, 35, 65, 80,    // 0.75 of the lower, 0.25 of the upper
                                             60, 85, 135, 160,  //
                                             80, 110, 170, 200}));
}

// Both cameras show the same along the smaller side: 2 pixels of the level are 3 of the window.
TEST(Canvas, ALevelThatDoesNotDivideTheWindowLiesWhereItsCameraShowsIt) {
  Canvas canvas({3, 3});
  tile(canvas, 1, 2, {0, 0}, {2, 1}, 10);
  tile(canvas, 1, 2, {0, 1}, {1, 1}, 20);
  tile(canvas, 1, 2, {1, 1}, {1, 1}, 30);
  endPass(canvas, 1, 2);
  EXPECT_EQ(greys(canvas), (std::vector<int>{10, 10, 10, 15, 18, 20, 20, 25, 30}));
}

TEST(Canvas, WhatIsTransparentGivesNoColourToWhatIsBesideIt) {
  const std::vector<uint8_t> orange{255, 128, 0, 255, 0, 0, 0, 0};
  std::vector<uint8_t> coarse = orange, rgba(64);
  coarse.insert(coarse.end(), orange.begin(), orange.end());
  upsample(coarse, {2, 2}, rgba, {4, 4});
  const std::vector<uint8_t> row{255, 128, 0, 255, 255, 128, 0, 191, 255, 128, 0, 64, 0, 0, 0, 0};
  for (size_t i = 0; i < rgba.size(); i++) EXPECT_EQ(rgba[i], row[i % 16]) << i;
}

TEST(Canvas, TilesOfOlderFramesAndOfOtherSizesAreNotTaken) {
  Canvas canvas({2, 1});
  tile(canvas, 2, 1, {0, 0}, {2, 1}, 70);
  endPass(canvas, 2, 1);
  EXPECT_FALSE(tile(canvas, 1, 1, {0, 0}, {2, 1}, 20));
  EXPECT_FALSE(endPass(canvas, 1, 1));
  PixelHeader large;
  large.frame = 3;
  large.width = large.height = 64;
  large.w = large.h = 64;
  EXPECT_FALSE(canvas.take(large, Bytes(64 * 64 * 4)));
  EXPECT_EQ(greys(canvas), (std::vector<int>{70, 70}));
}

TEST(Canvas, AnotherSizeStretchesWhatIsShown) {
  Canvas canvas({2, 1});
  tile(canvas, 1, 1, {0, 0}, {1, 1}, 10);
  tile(canvas, 1, 1, {1, 0}, {1, 1}, 20);
  endPass(canvas, 1, 1);
  canvas.resize({4, 2});
  EXPECT_EQ(greys(canvas), (std::vector<int>{10, 10, 20, 20, 10, 10, 20, 20}));
}

TEST(Canvas, DataThatAreNotWhatTheirHeaderSaysAreAnError) {
  Canvas canvas({2, 2});
  PixelHeader h;
  h.frame = 1;
  h.width = h.height = h.w = h.h = 2;
  EXPECT_THROW(canvas.take(h, Bytes(15)), Error);
}

}  // namespace
}  // namespace gxy::test

// SPDX-License-Identifier: Apache-2.0
#include "gxyviewer/canvas.h"

#include <gtest/gtest.h>

#include "gxy/comm/error.h"
#include "gxy/protocol/tile_codec.h"

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

TEST(Canvas, CoarsePixelsAreSquaresCutOffAtTheEdges) {
  Canvas canvas({3, 3});
  tile(canvas, 1, 2, {0, 0}, {2, 1}, 10);
  tile(canvas, 1, 2, {0, 1}, {1, 1}, 20);
  tile(canvas, 1, 2, {1, 1}, {1, 1}, 30);
  endPass(canvas, 1, 2);
  EXPECT_EQ(greys(canvas), (std::vector<int>{10, 10, 10, 10, 10, 10, 20, 20, 30}));
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

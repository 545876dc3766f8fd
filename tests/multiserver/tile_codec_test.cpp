// SPDX-License-Identifier: Apache-2.0
#include "multiserver/protocol/tile_codec.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/comm/error.h"

namespace gxy::protocol {
namespace {

std::vector<uint8_t> noise(uint32_t w, uint32_t h) {
  std::mt19937 random(7);
  std::vector<uint8_t> rgba(size_t(w) * h * 4);
  for (uint8_t& v : rgba) v = uint8_t(random());
  return rgba;
}

PixelHeader header(uint32_t w, uint32_t h, PixelEncoding encoding) {
  PixelHeader header;
  header.width = header.w = w;
  header.height = header.h = h;
  header.encoding = encoding;
  header.format = formatOf(encoding);
  return header;
}

TEST(TileCodec, AllButJpegKeepEveryBit) {
  for (const auto encoding : {PixelEncoding::Raw, PixelEncoding::Zstd, PixelEncoding::Zlib})
    for (const auto& [w, h] : {std::pair{1u, 1u}, {256u, 256u}, {3u, 200u}}) {
      const auto rgba = noise(w, h);
      const TilePixels tile = decodeTile(header(w, h, encoding), encodeTile(rgba, w, h, encoding, 0));
      EXPECT_EQ(tile.bytes, rgba);
    }
}

TEST(TileCodec, JpegKeepsItsRowsAndIsOverBlack) {
  std::vector<uint8_t> rgba(64 * 64 * 4, 255);
  for (size_t i = 0; i < rgba.size() / 2; i += 4) rgba[i + 3] = 0;  // the lower half is transparent
  const TilePixels tile =
      decodeTile(header(64, 64, PixelEncoding::Jpeg), encodeTile(rgba, 64, 64, PixelEncoding::Jpeg, 90));
  EXPECT_EQ(tile.format, PixelFormat::Rgb8);
  EXPECT_LT(tile.bytes[(4 * 64 + 30) * 3], 8);
  EXPECT_GT(tile.bytes[(60 * 64 + 30) * 3], 247);
}

TEST(TileCodec, DataThatAreNotATilesAreRefused) {
  for (const auto encoding :
       {PixelEncoding::Raw, PixelEncoding::Zstd, PixelEncoding::Jpeg, PixelEncoding::Zlib}) {
    const Bytes good = encodeTile(noise(16, 16), 16, 16, encoding, 75);
    EXPECT_THROW(decodeTile(header(17, 16, encoding), good), Error);
    EXPECT_THROW(decodeTile(header(16, 16, encoding), Bytes(5)), Error);
    PixelHeader wrong = header(16, 16, encoding);
    wrong.format = encoding == PixelEncoding::Jpeg ? PixelFormat::Rgba8 : PixelFormat::Rgb8;
    EXPECT_THROW(decodeTile(wrong, good), Error);
  }
}

TEST(TileCodec, BrokenBytesNeverDoMoreThanFail) {
  std::mt19937 random(3);
  for (const auto encoding : {PixelEncoding::Zstd, PixelEncoding::Jpeg, PixelEncoding::Zlib}) {
    const Bytes good = encodeTile(noise(32, 32), 32, 32, encoding, 75);
    for (int i = 0; i < 500; i++) {
      Bytes bad = good;
      for (int k = 0; k < 3; k++) bad[random() % bad.size()] = std::byte(random());
      bad.resize(1 + random() % bad.size());
      try {
        decodeTile(header(32, 32, encoding), bad);
      } catch (const Error&) {
      }
    }
  }
}

}  // namespace
}  // namespace gxy::protocol

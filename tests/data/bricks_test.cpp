// SPDX-License-Identifier: Apache-2.0
#include "core/data/bricks.h"

#include <gtest/gtest.h>

#include <cstring>
#include <set>

#include "core/comm/error.h"

namespace gxy {
namespace {

TEST(Bricks, HaveAPlaceForEveryPointAndFillUpTheRest) {
  const Index3 n{17, 9, 8};
  const Bricks bricks(n);
  EXPECT_EQ(bricks.count(), size_t(24 * 16 * 8));
  std::set<size_t> places;
  for (int64_t z = 0; z < n[2]; z++)
    for (int64_t y = 0; y < n[1]; y++)
      for (int64_t x = 0; x < n[0]; x++) {
        const size_t place = bricks(x, y, z);
        EXPECT_LT(place, bricks.count());
        EXPECT_EQ(place / 512, size_t((z / 8 * 2 + y / 8) * 3 + x / 8));
        places.insert(place);
      }
  EXPECT_EQ(places.size(), size_t(n[0] * n[1] * n[2]));
}

TEST(Bricks, PiecesOfARowAreItsPointsInOrder) {
  const Bricks bricks({30, 9, 9});
  int64_t next = 0;
  bricks.alongX(5, 8, 3, 20, [&](size_t place, int64_t first, int64_t n) {
    EXPECT_EQ(first, next);
    for (int64_t i = 0; i < n; i++) EXPECT_EQ(place + size_t(i), bricks(5 + first + i, 8, 3));
    next += n;
  });
  EXPECT_EQ(next, 20);
}

TEST(Bricks, TakeEveryPointInPlace) {
  for (const Index3& n : {Index3{2, 2, 2}, Index3{8, 8, 16}, Index3{19, 3, 26}, Index3{5, 20, 9}}) {
    const size_t count = size_t(n[0] * n[1] * n[2]);
    Samples samples(count * 3);
    for (size_t i = 0; i < samples.size(); i++) samples[i] = std::byte(1 + i % 251);
    const Samples rows = samples;
    putIntoBricks(samples, n, 3);
    const Bricks bricks(n);
    ASSERT_EQ(samples.size(), bricks.count() * 3);
    size_t i = 0, filled = 0;
    for (int64_t z = 0; z < n[2]; z++)
      for (int64_t y = 0; y < n[1]; y++)
        for (int64_t x = 0; x < n[0]; x++, i++)
          ASSERT_EQ(std::memcmp(&samples[bricks(x, y, z) * 3], &rows[i * 3], 3), 0)
              << x << " " << y << " " << z;
    for (const std::byte b : samples) filled += b == std::byte(0);
    EXPECT_EQ(filled, (bricks.count() - count) * 3);
  }
}

TEST(Bricks, TakeABoxInPartsAndGiveItBack) {
  const Extent block{{3, 5, 7}, {19, 10, 9}}, box{{6, 5, 9}, {14, 9, 5}};
  for (const size_t bytes : {1, 2, 3, 4, 8, 12}) {
    Samples bricks(Bricks(block.points).count() * bytes, std::byte(0xff));
    clearPadding(bricks, block.points, bytes);
    size_t cleared = 0;
    for (const std::byte b : bricks) cleared += b == std::byte(0);
    EXPECT_EQ(cleared, bricks.size() - size_t(block.count()) * bytes) << "the padding only";
    Samples samples(size_t(box.count()) * bytes), found(samples.size());
    for (size_t i = 0; i < samples.size(); i++) samples[i] = std::byte(1 + i % 251);
    for (int64_t first = 0, n = 1; first < box.count();
         first += n, n = n * 3 % 101)  // from any point on, of any length
      storeInBricks(
          bricks, block, box, first,
          std::span(samples).subspan(size_t(first) * bytes, size_t(std::min(n, box.count() - first)) * bytes),
          bytes);
    copyFromBricks(bricks, block, box, found, bytes);
    EXPECT_EQ(found, samples) << bytes;
    size_t others = 0;
    for (const std::byte b : bricks) others += b == std::byte(0xff);
    EXPECT_EQ(others, size_t(block.count() - box.count()) * bytes) << "nothing else is changed";
  }
}

TEST(Bricks, OfTooManyPointsInALayerAreRefused) {
  EXPECT_NO_THROW(Bricks({16000, 16000, 2}));
  EXPECT_THROW(Bricks({17000, 17000, 2}), Error);
}

}  // namespace
}  // namespace gxy

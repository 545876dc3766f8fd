// SPDX-License-Identifier: Apache-2.0
// Blocks that cover a grid, and those that do not.
#include <gtest/gtest.h>

#include <string>

#include "core/comm/error.h"
#include "insitu/plan/blocks.h"
#include "tests/insitu/random_blocks.h"
#include "tests/support/seeds.h"

namespace gxy::insitu {
namespace {

std::string errorOf(std::vector<Block> blocks, const Index3& points) {
  try {
    checkCover(BlockSearch(std::move(blocks)), points);
  } catch (const Error& e) {
    return e.what();
  }
  return {};
}

TEST(Blocks, OfRandomDecompositionsCoverTheirGrid) {
  for (uint64_t seed = 1; seed <= 200; seed++) {
    Random random(seed);
    const Index3 points = randomPoints(random);
    EXPECT_EQ(errorOf(randomBlocks(random, points, 1 + int(random.below(64))), points), "") << seed;
  }
}

TEST(Blocks, AHoleIsNamedWithItsBox) {
  std::vector<Block> blocks{{0, 0, {{0, 0, 0}, {4, 4, 2}}}, {1, 0, {{0, 0, 3}, {4, 4, 2}}}};
  const std::string error = errorOf(blocks, {4, 4, 5});
  EXPECT_NE(error.find("a hole of 4 x 4 x 1 points, (0, 0, 2) to (3, 3, 2)"), std::string::npos) << error;
}

TEST(Blocks, EveryHoleIsFoundWhateverBlockIsLeftOut) {
  for (uint64_t seed = 1; seed <= 200; seed++) {
    Random random(seed);
    const Index3 points = randomPoints(random);
    auto blocks = randomBlocks(random, points, 2 + int(random.below(40)));
    if (blocks.size() < 2) continue;
    blocks.erase(blocks.begin() + std::ptrdiff_t(random.below(blocks.size())));
    EXPECT_NE(errorOf(blocks, points).find("a hole of"), std::string::npos) << seed;
  }
}

TEST(Blocks,
     ManyAreCheckedInTime) {  // what takes the square of their number, or a deep stack, does not end here
  constexpr int64_t kMany = test::sweep(200000);
  std::vector<Block> slabs;
  for (int64_t i = 0; i < kMany; i++) slabs.push_back({int(i), 0, {{0, 0, i}, {4, 4, 1}}});
  EXPECT_EQ(errorOf(slabs, {4, 4, kMany}), "");
  EXPECT_NE(errorOf(slabs, {4, 4, kMany + 1}).find("a hole of 4 x 4 x 1 points"), std::string::npos);
  EXPECT_NE(
      errorOf(std::vector(size_t(kMany), Block{0, 0, {{0, 0, 0}, {4, 4, 4}}}), {4, 4, 4}).find("overlap"),
      std::string::npos);
  std::vector<Block> rows{{0, 0, {{0, 0, 0}, {kMany, 1, 1}}}};  // one that is as long as all others
  for (int64_t i = 0; i < kMany; i++) rows.push_back({int(i), 0, {{i, 1, 0}, {1, 1, 1}}});
  EXPECT_EQ(errorOf(rows, {kMany, 2, 1}), "");
}

TEST(Blocks, ThatOverlapAreNamedBoth) {
  const std::vector<Block> blocks{{0, 0, {{0, 0, 0}, {4, 4, 3}}}, {2, 1, {{0, 0, 2}, {4, 4, 3}}}};
  const std::string error = errorOf(blocks, {4, 4, 5});
  EXPECT_NE(error.find("overlap in points (0, 0, 2) to (3, 3, 2)"), std::string::npos) << error;
  EXPECT_NE(error.find("block 0 of rank 0"), std::string::npos) << error;
  EXPECT_NE(error.find("block 1 of rank 2"), std::string::npos) << error;
}

TEST(Blocks, AreFoundAsByLookingAtAll) {
  for (uint64_t seed = 1; seed <= 200; seed++) {
    Random random(seed);
    const Index3 points = randomPoints(random);
    const BlockSearch search(randomBlocks(random, points, 30));
    const Extent box = randomBox(random, points);
    int64_t found = 0, expected = 0;
    search.overlapping(box, [&](size_t, const Extent& common) {
      found += common.count();
      return true;
    });
    for (const Block& b : search.blocks()) expected += intersection(b.extent, box).count();
    EXPECT_EQ(found, expected) << seed;
    EXPECT_EQ(found, box.count()) << seed << ": the blocks cover the grid";
  }
}

}  // namespace
}  // namespace gxy::insitu

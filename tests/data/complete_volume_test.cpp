// SPDX-License-Identifier: Apache-2.0
#include "core/data/complete_volume.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <string>
#include <vector>

#include "core/comm/error.h"
#include "core/data/bricks.h"
#include "tests/support/thread_ranks.h"

namespace gxy {
namespace {

const Grid kGrid{{0, 0, 0}, {1, 1, 1}, {21, 18, 15}};

double sampleAt(int64_t x, int64_t y, int64_t z) {
  if (x == 3 && y == 4 && z == 5) return NAN;
  return 1e5 + std::sin(double(x + 21 * (y + 18 * z)) * 0.37);
}

/// The blocks of a rank, of doubles.
Volume samplesOf(const Partitioning& cut, int rank) {
  Volume volume;
  volume.grid = kGrid;
  volume.stored = ScalarType::Float64;
  for (const int partition : cut.owned(rank)) {
    VolumeBlock& block = volume.blocks[partition];
    block.extent = extentOf(kGrid, cut.box(partition), kGhostLayers);
    const auto& [first, n] = block.extent;
    std::vector<double> values;
    for (int64_t z = 0; z < n[2]; z++)
      for (int64_t y = 0; y < n[1]; y++)
        for (int64_t x = 0; x < n[0]; x++)
          values.push_back(sampleAt(first[0] + x, first[1] + y, first[2] + z));
    block.samples.resize(values.size() * sizeof(double));
    std::memcpy(block.samples.data(), values.data(), block.samples.size());
  }
  return volume;
}

TEST(CompleteVolume, EveryRankHasTheRangesAndTheEncodingOfTheWholeField) {
  SingleRank one;
  const Partitioning single = decomposed(kGrid, 1, 1);
  Volume whole = samplesOf(single, 0);
  completeVolume(whole, single, one);
  EXPECT_EQ(whole.stored, ScalarType::Float32);
  EXPECT_EQ(whole.noDataSamples, 1);
  EXPECT_NEAR(whole.ranges.at(0).min, 1e5 - 1, 1e-4);
  EXPECT_NEAR(whole.ranges.at(0).max, 1e5 + 1, 1e-4);
  EXPECT_NEAR(whole.shift, 1e5, 1) << "the offset of a small signal is taken out";

  const Partitioning cut = decomposed(kGrid, 7, 3);
  test::ThreadRanks three(3);
  const auto errors = three.run([&](Collectives& ranks) {
    Volume mine = samplesOf(cut, ranks.rank());
    completeVolume(mine, cut, ranks);
    EXPECT_EQ(mine.ranges, whole.ranges);
    EXPECT_EQ(mine.noDataSamples, 1);
    EXPECT_EQ(mine.stored, whole.stored);
    EXPECT_EQ(mine.shift, whole.shift);
    EXPECT_EQ(mine.scale, whole.scale);
    const VolumeBlock& all = whole.blocks.at(0);
    for (const auto& [partition, block] : mine.blocks)
      for (int64_t k = 0; k < block.macrocells[2]; ++k)
        for (int64_t j = 0; j < block.macrocells[1]; ++j)
          for (int64_t i = 0; i < block.macrocells[0]; ++i) {
            const auto place = [](const VolumeBlock& b, Index3 at) {
              return size_t((at[2] * b.macrocells[1] + at[1]) * b.macrocells[0] + at[0]);
            };
            const Index3 at{i + block.firstMacrocell[0], j + block.firstMacrocell[1],
                            k + block.firstMacrocell[2]};
            EXPECT_EQ(block.summaries[0][place(block, {i, j, k})], all.summaries[0][place(all, at)]);
          }
  });
  EXPECT_EQ(errors, std::vector<std::string>(3));
}

/// One block of floats, x fastest, with the points of the grid and a value for each.
Volume floatsOf(const Grid& grid, const std::function<float(const Index3&)>& value) {
  Volume volume;
  volume.grid = grid;
  VolumeBlock& block = volume.blocks[0];
  block.extent = {{0, 0, 0}, grid.points};
  std::vector<float> values;
  for (int64_t z = 0; z < grid.points[2]; z++)
    for (int64_t y = 0; y < grid.points[1]; y++)
      for (int64_t x = 0; x < grid.points[0]; x++) values.push_back(value({x, y, z}));
  block.samples.resize(values.size() * sizeof(float));
  std::memcpy(block.samples.data(), values.data(), block.samples.size());
  return volume;
}

TEST(CompleteVolume, RangesAreThoseOfTheDomainWhereTheGridIsLarger) {
  const Grid grid{{0, 0, 0}, {1, 1, 1}, {9, 8, 7}};
  SingleRank one;
  const auto largeAtTheCorner = [](const Index3& p) { return p == Index3{0, 0, 0} ? 1e6f : float(p[0]); };
  for (const bool whole : {true, false}) {
    const double from = whole ? 0 : 2;
    const Partitioning cut = Partitioning::lattice({std::vector<double>{from, 8}, {from, 7}, {from, 6}}, 1);
    Volume volume = floatsOf(grid, largeAtTheCorner);
    EXPECT_EQ(needsStatistics(volume, cut), !whole);
    completeVolume(volume, cut, one);
    EXPECT_EQ(volume.ranges.at(0).max, whole ? 1e6 : 8);
    EXPECT_EQ(volume.ranges.at(0).min, whole ? 0 : 2);
  }
}

TEST(CompleteVolume, AFieldWithoutDataHasNoRange) {
  SingleRank one;
  const Partitioning cut = decomposed(kGrid, 1, 1);
  Volume volume = floatsOf(kGrid, [](const Index3&) { return NAN; });
  completeVolume(volume, cut, one);
  EXPECT_TRUE(volume.ranges.at(0).empty());
  EXPECT_EQ(volume.noDataSamples, 21 * 18 * 15);
}

TEST(CompleteVolume, BlocksOfAnotherSizeAndCompleteOnesAreErrors) {
  SingleRank one;
  const Partitioning cut = decomposed(kGrid, 1, 1);
  const auto zero = [](const Index3&) { return 0.f; };
  for (const int64_t more : {-4, 4}) {
    Volume volume = floatsOf(kGrid, zero);
    Samples& samples = volume.blocks[0].samples;
    samples.resize(size_t(int64_t(samples.size()) + more));
    EXPECT_THROW(completeVolume(volume, cut, one), Error);
  }
  Volume volume = floatsOf(kGrid, zero);
  completeVolume(volume, cut, one);
  EXPECT_THROW(completeVolume(volume, cut, one), Error);
  Volume doubles = samplesOf(cut, 0);
  putIntoBricks(doubles.blocks[0].samples, doubles.blocks[0].extent.points, sizeof(double));
  EXPECT_THROW(completeBricks(doubles, cut, one, {}, 1), Error) << "without statistics";
}

TEST(CompleteVolume, SamplesAreStoredLikeOthersWhereThatSuffices) {
  SingleRank one;
  const Partitioning cut = decomposed(kGrid, 1, 1);
  Volume own = samplesOf(cut, 0);
  completeVolume(own, cut, one);
  const double shifts[] = {own.shift, own.shift + 2, own.shift + 100};
  for (int n = 0; n < 6; n++) {
    const double shift = shifts[n % 3];
    const bool suffices = shift < own.shift + 3, ofStored = n < 3;
    Volume volume = samplesOf(cut, 0);
    completeVolume(volume, cut, one, 1, {}, StoredLike{{ScalarType::Float32, shift, own.scale}, ofStored});
    EXPECT_EQ(volume.shift, suffices ? shift : own.shift);
    EXPECT_EQ(volume.noDataSamples, 1);
    EXPECT_NEAR(volume.ranges.at(0).min, own.ranges.at(0).min, 1e-6);
    EXPECT_NEAR(volume.ranges.at(0).max, own.ranges.at(0).max, 1e-6);
    EXPECT_EQ(volume.rangesOfStored, suffices && ofStored);
    EXPECT_EQ(volume.ranges == own.ranges, !volume.rangesOfStored);
  }
}

TEST(CompleteVolume, TellsEachPointThatIsStoredOnce) {
  SingleRank one;
  const Partitioning cut = decomposed(kGrid, 3, 1);
  Volume volume = samplesOf(cut, 0);
  int64_t points = 0, told = 0;
  for (const auto& [partition, block] : volume.blocks) points += block.extent.count();
  completeVolume(volume, cut, one, 1, [&](int64_t more) { told += more; });
  EXPECT_EQ(told, points);
}

}  // namespace
}  // namespace gxy

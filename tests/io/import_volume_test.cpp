// SPDX-License-Identifier: Apache-2.0
#include "core/io/import_volume.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/comm/error.h"
#include "core/data/bricks.h"
#include "core/data/complete_volume.h"
#include "core/io/write_volume.h"
#include "tests/io/fixtures.h"

namespace gxy {
namespace {

using testing::EndsAt;
using testing::TemporaryFolder;
using testing::ThreadRanks;

const Grid kGrid{{0, 0, 0}, {1, 1, 1}, {21, 18, 15}};

template <class T>
void write(const std::string& path, ScalarType type, const std::vector<T>& samples,
           const Grid& grid = kGrid) {
  VolumeWriter(path, grid, {{"field", type, 1, {}}}).write(0, 0, std::as_bytes(std::span(samples)));
}

TEST(ImportVolume, EveryRankSeesTheSameRangesAndSummariesAsOne) {
  const TemporaryFolder folder;
  std::vector<float> samples(size_t(wholeOf(kGrid).count()));
  for (size_t i = 0; i < samples.size(); ++i) samples[i] = float(std::sin(double(i) * 0.37) * 100);
  samples[1234] = NAN;
  samples[4000] = INFINITY;
  write(folder / "v.json", ScalarType::Float32, samples);
  SingleRank one;
  const auto whole = importVolume(folder / "v.json", "", decomposed(kGrid, 1, 1), kGhostLayers, one);
  EXPECT_EQ(whole->noDataSamples, 2);

  const Partitioning cut = decomposed(kGrid, 7, 3);
  ThreadRanks ranks(3);
  const auto errors = ranks.run([&](Collectives& mine) {
    const auto volume = importVolume(folder / "v.json", "", cut, kGhostLayers, mine);
    EXPECT_EQ(volume->ranges, whole->ranges);
    EXPECT_EQ(volume->noDataSamples, 2);
    const VolumeBlock& all = whole->blocks.at(0);
    for (const auto& [partition, block] : volume->blocks) {
      EXPECT_EQ(cut.owner(partition), mine.rank());
      for (int64_t k = 0; k < block.macrocells[2]; ++k)
        for (int64_t j = 0; j < block.macrocells[1]; ++j)
          for (int64_t i = 0; i < block.macrocells[0]; ++i) {
            const int64_t here = (k * block.macrocells[1] + j) * block.macrocells[0] + i;
            const int64_t there =
                ((k + block.firstMacrocell[2]) * all.macrocells[1] + j + block.firstMacrocell[1]) *
                    all.macrocells[0] +
                i + block.firstMacrocell[0];
            EXPECT_EQ(block.summaries[0][size_t(here)], all.summaries[0][size_t(there)]);
          }
    }
  });
  EXPECT_EQ(errors, std::vector<std::string>(3));
}

// Of 20 x 80 x 200 points: read at once, stored in 25 layers of macrocells.
TEST(ImportVolume, EndsWithinABlockWhenItIsToldTo) {
  const TemporaryFolder folder;
  Grid grid = kGrid;
  grid.points = {20, 80, 200};
  write(folder / "v.json", ScalarType::Float32, std::vector<float>(size_t(wholeOf(grid).count())), grid);
  const Partitioning single = Partitioning::single(grid.box());
  EndsAt never(-1);
  importVolume(folder / "v.json", "", single, kGhostLayers, never);
  EXPECT_GE(never.asked, 25);
  EndsAt before(never.asked - 10);
  EXPECT_THROW(importVolume(folder / "v.json", "", single, kGhostLayers, before), Error);
  EXPECT_EQ(before.asked, never.asked - 10);
}

TEST(ImportVolume, EndsBetweenTwoBlocksWhenItIsToldTo) {
  const TemporaryFolder folder;
  write(folder / "v.json", ScalarType::Float32, std::vector<float>(size_t(wholeOf(kGrid).count())));
  EndsAt third(3);
  EXPECT_THROW(importVolume(folder / "v.json", "", decomposed(kGrid, 7, 1), kGhostLayers, third), Error);
  EXPECT_EQ(third.asked, 3);
}

/// One rank that keeps what it is told of.
struct Told : EndsAt {
  Told() : EndsAt(1 << 30) {}
  void done(double share) const override { shares.push_back(share); }
  mutable std::vector<double> shares;
};

// 3 blocks of 24 MB in all: each is read in slabs, then stored.
TEST(ImportVolume, TellsWhatHasBeenReadAndStored) {
  const TemporaryFolder folder;
  const Grid grid{{0, 0, 0}, {1, 1, 1}, {256, 256, 384}};
  write(folder / "v.json", ScalarType::UInt8, std::vector<uint8_t>(size_t(wholeOf(grid).count())), grid);
  Told told;
  importVolume(folder / "v.json", "", decomposed(grid, 3, 1), 0, told);
  EXPECT_TRUE(std::is_sorted(told.shares.begin(), told.shares.end()));
  EXPECT_GT(told.shares.size(), 6u) << "more than its blocks, of which each is read and stored";
  EXPECT_GT(told.shares.front(), 0);
  EXPECT_DOUBLE_EQ(told.shares.back(), 1);
  EXPECT_GE(told.asked, int(told.shares.size())) << "and could be ended there";
}

TEST(ImportVolume, WideTypesKeepASmallSignalOnALargeOffset) {
  const TemporaryFolder folder;
  std::vector<double> samples(size_t(wholeOf(kGrid).count()));
  for (size_t i = 0; i < samples.size(); ++i) samples[i] = 101325.0 + 0.01 * std::sin(double(i));
  write(folder / "v.vti", ScalarType::Float64, samples);
  SingleRank one;
  const auto volume = importVolume(folder / "v.vti", "field", decomposed(kGrid, 1, 1), 0, one);
  ASSERT_EQ(volume->stored, ScalarType::Float32);
  const auto* stored = reinterpret_cast<const float*>(volume->blocks.at(0).samples.data());
  const Bricks bricks(kGrid.points);
  size_t i = 0;
  for (int64_t z = 0; z < kGrid.points[2]; ++z)
    for (int64_t y = 0; y < kGrid.points[1]; ++y)
      for (int64_t x = 0; x < kGrid.points[0]; ++x)
        ASSERT_NEAR(volume->shift + volume->scale * double(stored[bricks(x, y, z)]), samples[i++], 2e-9);
}

/// Floats of one partition alone, `there`; 1e-42 in the others.
std::vector<float> denormalsBeside(float there) {
  std::vector<float> samples(size_t(wholeOf(kGrid).count()), 1e-42f);
  samples.back() = there;
  return samples;
}

TEST(ImportVolume, FloatsAreScaledByWhatIsLargestOnAllRanks) {
  const TemporaryFolder folder;
  const Partitioning cut = decomposed(kGrid, 7, 3);
  for (const float largest : {1e-38f, 1.f}) {
    const std::vector<float> samples = denormalsBeside(largest);
    write(folder / "v.json", ScalarType::Float32, samples);
    ThreadRanks ranks(3);
    const auto errors = ranks.run([&](Collectives& mine) {
      const auto volume = importVolume(folder / "v.json", "", cut, kGhostLayers, mine);
      EXPECT_EQ(volume->scale, largest == 1 ? 1 : 0x1p-126);
      EXPECT_EQ(volume->ranges[0].max, double(largest));

      Volume made;  // the same, computed
      made.grid = kGrid;
      for (const auto& [partition, imported] : volume->blocks) {
        VolumeBlock& block = made.blocks[partition];
        block.extent = imported.extent;
        const auto& [first, n] = block.extent;
        for (int64_t z = first[2]; z < first[2] + n[2]; z++)
          for (int64_t y = first[1]; y < first[1] + n[1]; y++) {
            const auto row = std::as_bytes(std::span(
                &samples[size_t((z * kGrid.points[1] + y) * kGrid.points[0] + first[0])], size_t(n[0])));
            block.samples.insert(block.samples.end(), row.begin(), row.end());
          }
      }
      completeVolume(made, cut, mine);
      EXPECT_EQ(made.scale, volume->scale);
      EXPECT_EQ(made.ranges, volume->ranges);
      for (const auto& [partition, block] : made.blocks) {
        EXPECT_EQ(block.samples, volume->blocks.at(partition).samples);
        EXPECT_EQ(block.summaries, volume->blocks.at(partition).summaries);
        for (const Macrocell& m : block.summaries[0]) {
          EXPECT_GE(m.min, float(1e-42 / volume->scale) * 0.9f) << "of the samples as they are stored";
          EXPECT_LE(m.max, float(largest / volume->scale) * 1.1f);
        }
      }
    });
    EXPECT_EQ(errors, std::vector<std::string>(3));
  }
}

TEST(ImportVolume, WhatIsNotShownAndWhatOthersNeedIsNotRead) {
  const TemporaryFolder folder;
  const std::vector<ArrayInfo> arrays{{"shown", ScalarType::Float32, 1, {}},
                                      {"other", ScalarType::UInt8, 3, {}}};
  const Extent lower{{0, 0, 0}, {21, 18, 8}}, upper{{0, 0, 7}, {21, 18, 8}};
  for (const auto& [name, extent] : {std::pair("a.vti", lower), std::pair("b.vti", upper)}) {
    Grid grid = kGrid;
    grid.origin.z = double(extent.first[2]);
    grid.points = extent.points;
    VolumeWriter writer(folder / name, grid, arrays, extent.first);
    const std::vector<std::byte> shown(size_t(extent.count()) * 4), other(size_t(extent.count()) * 3);
    writer.write(0, 0, shown);
    writer.write(1, 0, other);
  }
  writePvti(folder / "v.pvti", kGrid, arrays, {{lower, "a.vti"}, {upper, "b.vti"}});
  const Partitioning cut = Partitioning::lattice(
      {std::vector<double>{0, 20}, std::vector<double>{0, 17}, std::vector<double>{0, 7, 14}}, 2);
  ThreadRanks ranks(2);
  const auto errors = ranks.run([&](Collectives& mine) {
    LeftOut leftOut;
    importVolume(folder / "v.pvti", "shown", cut, 0, mine, {}, &leftOut);
    EXPECT_EQ(leftOut.arrays, 1u);
    EXPECT_EQ(leftOut.pieces, mine.rank() == 0 ? 1u : 0u) << "the layer that both hold is in the first";
    EXPECT_EQ(leftOut.bytes, 21u * 18 * (15 * 7 - 8 * 4));
  });
  EXPECT_EQ(errors, std::vector<std::string>(2));
}

TEST(ImportVolume, AnErrorOnOneRankIsThrownOnAll) {
  const TemporaryFolder folder;
  write(folder / "a.vti", ScalarType::Float32, std::vector<float>(size_t(wholeOf(kGrid).count()), 1.f));
  // The second half of the image lies in a piece that does not exist: only its rank can notice.
  writePvti(folder / "v.pvti", kGrid, {{"field", ScalarType::Float32, 1, {}}},
            {{{{0, 0, 0}, {21, 18, 8}}, "a.vti"}, {{{0, 0, 7}, {21, 18, 8}}, "gone.vti"}});
  const Partitioning cut = Partitioning::lattice(
      {std::vector<double>{0, 20}, std::vector<double>{0, 17}, std::vector<double>{0, 7, 14}}, 2);
  ThreadRanks ranks(2);
  const auto errors =
      ranks.run([&](Collectives& mine) { importVolume(folder / "v.pvti", "", cut, 0, mine); });
  EXPECT_EQ(errors[0].find("rank 1: "), 0u) << errors[0];
  EXPECT_NE(errors[0].find("gone.vti"), std::string::npos);
  EXPECT_EQ(errors[0], errors[1]);
}

}  // namespace
}  // namespace gxy

// SPDX-License-Identifier: Apache-2.0
#include "core/data/volume.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>

#include "core/comm/error.h"
#include "tests/data/bytes.h"
#include "tests/data/random_partitioning.h"

namespace gxy {
namespace {

Box slab(double lo, double hi) {
  Box b;
  b.lo = {lo, 0, 0};
  b.hi = {hi, 1, 1};
  return b;
}

TEST(Extent, AFaceOnAGridPlaneDoesNotPullInTheCellBeyond) {
  // Planes at 1e6 + 0.1 i: neither the spacing nor most planes are exact in binary.
  const Grid grid{{1e6, 0, 0}, {0.1, 0.5, 0.5}, {101, 3, 3}};
  for (int i = 0; i < 100; ++i) {
    for (int n : {1, 5}) {
      if (i + n > 100) continue;
      const Box part = slab(1e6 + 0.1 * i, 1e6 + 0.1 * (i + n));
      const Extent e = extentOf(grid, part, 0);
      EXPECT_EQ(e.first, (Index3{i, 0, 0}));
      EXPECT_EQ(e.points, (Index3{n + 1, 3, 3}));
      const Extent g = extentOf(grid, part, 2);
      EXPECT_EQ(g.first[0], std::max(i - 2, 0));
      EXPECT_EQ(g.first[0] + g.points[0], std::min(i + n + 2, 100) + 1);
    }
  }
}

TEST(Extent, EvenFacesOfAGridAreOnItsPlanes) {
  const Grid grid{{-1e3, 7, 0.3}, {1.0 / 3, 1e-5, 0.7}, {998, 64, 129}};
  for (int parts : {1, 2, 3, 7, 12, 27}) {
    const Partitioning p = decomposed(grid, parts, 2);
    int64_t cells = 0;
    for (int i = 0; i < p.partitions(); ++i) {
      const Extent e = extentOf(grid, p.box(i), 0);
      cells += (e.points[0] - 1) * (e.points[1] - 1) * (e.points[2] - 1);
    }
    EXPECT_EQ(cells, int64_t(997) * 63 * 128) << parts;
  }
}

TEST(Extent, HoldsBothEndsOfACellThatAFaceCuts) {
  const Grid grid{{0, 0, 0}, {1, 1, 1}, {11, 2, 2}};
  EXPECT_EQ(extentOf(grid, slab(2.5, 4.25), 0), (Extent{{2, 0, 0}, {4, 2, 2}}));
  EXPECT_EQ(extentOf(grid, slab(2.5, 2.75), 0), (Extent{{2, 0, 0}, {2, 2, 2}}));
  EXPECT_EQ(extentOf(grid, slab(3 - 1e-9, 3 + 1e-9), 0), (Extent{{2, 0, 0}, {3, 2, 2}}));
  EXPECT_EQ(extentOf(grid, slab(-5, 0.5), 1), (Extent{{0, 0, 0}, {3, 2, 2}}));
  EXPECT_EQ(extentOf(grid, slab(-5, 50), 2), (Extent{{0, 0, 0}, {11, 2, 2}}));
}

TEST(Extent, IsEmptyWhereThePartitionMissesTheGrid) {
  const Grid grid{{0, 0, 0}, {1, 1, 1}, {11, 2, 2}};
  EXPECT_EQ(extentOf(grid, slab(10, 12), 0).count(), 0);  // shares a face only
  EXPECT_EQ(extentOf(grid, slab(-3, 0), 0).count(), 0);
  EXPECT_EQ(extentOf(grid, slab(20, 22), 2).count(), 0);
}

TEST(Extent, GhostsReachPartitionsThatShareAFaceWithTheGrid) {
  const Grid grid{{0, 0, 0}, {1, 1, 1}, {11, 2, 2}};
  EXPECT_EQ(extentOf(grid, slab(10, 12), 2), (Extent{{8, 0, 0}, {3, 2, 2}}));
  EXPECT_EQ(extentOf(grid, slab(10 + 1e-6, 12), 2), (Extent{{8, 0, 0}, {3, 2, 2}}));
  EXPECT_EQ(extentOf(grid, slab(-3, 0), 2), (Extent{{0, 0, 0}, {3, 2, 2}}));
  EXPECT_EQ(extentOf(grid, slab(11, 12), 2).count(), 0);
  EXPECT_EQ(extentOf(grid, slab(-3, -1), 2).count(), 0);
}

TEST(Extent, CountsBeyond32BitsAreExact) {
  const Grid grid{{0, 0, 0}, {1, 1, 1}, {int64_t(1) << 20, int64_t(1) << 20, 4096}};
  const Extent e = extentOf(grid, grid.box(), 2);
  EXPECT_EQ(e.points, grid.points);
  EXPECT_EQ(e.count(), int64_t(1) << 52);
}

TEST(OwnedPoints, EachGridPointIsCountedOnce) {
  std::mt19937 random(3);
  const Grid grid{{-1, 2, 0}, {0.1, 0.3, 1}, {12, 9, 7}};
  for (int parts = 1; parts <= 27; ++parts) {
    const Partitioning anywhere = test::randomPartitioning(random, grid.box(), parts, 3);
    std::vector<int> seen(12 * 9 * 7, 0);
    for (int i = 0; i < parts; ++i) {
      const Extent e = ownedPoints(grid, anywhere, i);
      for (int64_t z = e.first[2]; z < e.first[2] + e.points[2]; ++z)
        for (int64_t y = e.first[1]; y < e.first[1] + e.points[1]; ++y)
          for (int64_t x = e.first[0]; x < e.first[0] + e.points[0]; ++x)
            ++seen[size_t((z * 9 + y) * 12 + x)];
    }
    for (int s : seen) ASSERT_EQ(s, 1) << parts;
  }
  for (int parts : {1, 2, 8, 12}) {
    const Partitioning onPlanes = decomposed(grid, parts, 3);
    int64_t count = 0;
    for (int i = 0; i < parts; ++i) count += ownedPoints(grid, onPlanes, i).count();
    EXPECT_EQ(count, 12 * 9 * 7) << parts;
  }
}

TEST(OwnedPoints, TheLastPointsCountWhereAFaceLiesOnTheEndOfTheGrid) {
  const Grid grid{{0, 0, 0}, {1, 1, 1}, {5, 5, 5}};
  const std::vector<double> faces{-4, 0, 2, 4, 8};
  const Partitioning wider = Partitioning::lattice({faces, faces, faces}, 1);
  const auto at = [](int i, int j, int k) { return (k * 4 + j) * 4 + i; };
  EXPECT_EQ(ownedPoints(grid, wider, at(1, 1, 1)), (Extent{{0, 0, 0}, {2, 2, 2}}));
  EXPECT_EQ(ownedPoints(grid, wider, at(2, 1, 2)), (Extent{{2, 0, 2}, {3, 2, 3}}));
  int64_t count = 0;
  for (int p = 0; p < wider.partitions(); ++p) count += ownedPoints(grid, wider, p).count();
  EXPECT_EQ(count, 5 * 5 * 5) << "partitions that only touch the grid own no points";
}

TEST(Statistics, RangesArePerComponentAndOfTheMagnitude) {
  const std::vector<float> values{3, 4, 0, 0, NAN, 12, -8, 6};
  const FieldStatistics s = statisticsOf(bytes(values), ScalarType::Float32, 2);
  ASSERT_EQ(s.ranges.size(), 3u);
  EXPECT_EQ(s.ranges[0], (Range{-8, 3}));
  EXPECT_EQ(s.ranges[1], (Range{0, 12}));
  EXPECT_EQ(s.ranges[2], (Range{0, 10}));
  EXPECT_EQ(s.noDataSamples, 1);
}

TEST(Statistics, AllPointsOfALongRowCount) {
  // Rows of 1 to 50 points with the extremes, a NaN and an infinity at every place.
  for (size_t n = 4; n <= 50; ++n) {
    for (size_t at = 0; at + 3 < n; ++at) {
      std::vector<float> values(n, 5);
      values[at] = -7;
      values[at + 1] = NAN;
      values[at + 2] = 90;
      values[at + 3] = -INFINITY;
      const FieldStatistics s = statisticsOf(bytes(values), ScalarType::Float32, 1);
      ASSERT_EQ(s.ranges[0], (Range{-7, 90}));
      ASSERT_EQ(s.noDataSamples, 2);
      std::vector<int16_t> shorts(n, -5);
      shorts[at] = -32768;
      shorts[at + 1] = 32767;
      ASSERT_EQ(statisticsOf(bytes(shorts), ScalarType::Int16, 1).ranges[0], (Range{-32768, 32767}));
    }
  }
  EXPECT_TRUE(statisticsOf(bytes(std::vector<float>(33, NAN)), ScalarType::Float32, 1).ranges[0].empty());
}

TEST(Statistics, HugeFiniteValuesAreData) {
  const FieldStatistics s = statisticsOf(bytes(std::vector<double>{1e300, -1e300}), ScalarType::Float64, 1);
  EXPECT_EQ(s.ranges[0], (Range{-1e300, 1e300}));
  EXPECT_EQ(s.noDataSamples, 0);
}

TEST(Statistics, SumOverOwnedPointsIsThatOfTheWholeGrid) {
  std::mt19937 random(11);
  const Grid grid{{0, 0, 0}, {1, 1, 1}, {9, 8, 7}};
  const Extent whole{{0, 0, 0}, grid.points};
  std::vector<double> values(size_t(whole.count()));
  for (double& v : values) v = random() % 10 == 0 ? NAN : double(random() % 1000);
  const FieldStatistics expected = statisticsOf(bytes(values), ScalarType::Float64, 1);
  const Partitioning p = test::randomPartitioning(random, grid.box(), 9, 2);
  FieldStatistics sum;
  for (int i = 0; i < p.partitions(); ++i) {
    sum.merge(statisticsOf(bytes(values), ScalarType::Float64, 1, whole, ownedPoints(grid, p, i)));
  }
  EXPECT_EQ(sum.ranges, expected.ranges);
  EXPECT_EQ(sum.noDataSamples, expected.noDataSamples);
}

}  // namespace
}  // namespace gxy

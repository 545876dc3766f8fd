// SPDX-License-Identifier: Apache-2.0
#include "core/data/distribute.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <mutex>
#include <numeric>
#include <string>
#include <vector>

#include "core/comm/error.h"
#include "tests/support/thread_ranks.h"

namespace gxy {
namespace {

/// 100 particles along x, every `of`th of them.
OwnedGeometry particles(int part, int of) {
  OwnedGeometry owned;
  owned.name = "particles";
  owned.primitives = 100;
  owned.droppedPrimitives = 3;
  owned.range = {0, 99};
  for (int n = 0; n < 100; n++) {
    const glm::dvec3 p(n / 100.0, 0.5, 0.5);
    owned.box.extend(p);
    if (n % of != part) continue;
    owned.block.points.push_back(p);
    owned.block.values.push_back(float(n));
    owned.block.ids.push_back(uint64_t(n));
  }
  return owned;
}

TEST(Distribute, PartitionsHoldTheSameOnAnyNumberOfRanks) {
  const auto halves = [](int ranks) {
    return Partitioning::lattice(
        {std::vector<double>{0, 0.5, 1}, std::vector<double>{0, 1}, std::vector<double>{0, 1}}, ranks);
  };
  std::map<int, GeometryBlock> expected;
  for (const int count : {1, 2, 3}) {
    std::map<int, GeometryBlock> blocks;
    std::mutex mutex;
    test::ThreadRanks ranks(count);
    const auto errors = ranks.run([&](Collectives& mine) {
      const auto geometry = distribute(
          particles(mine.rank(), count), halves(count), [](double) { return 0.015; }, mine);
      EXPECT_EQ(geometry->name, "particles");
      EXPECT_EQ(geometry->primitives, 100u);
      EXPECT_EQ(geometry->droppedPrimitives, 3u);
      EXPECT_EQ(geometry->range, (Range{0, 99}));
      const std::lock_guard lock(mutex);
      blocks.insert(geometry->blocks.begin(), geometry->blocks.end());
    });
    EXPECT_EQ(errors, std::vector<std::string>(size_t(count)));
    if (expected.empty()) expected = blocks;
    EXPECT_EQ(blocks, expected) << count;
  }
  ASSERT_EQ(expected.size(), 2u);
  EXPECT_EQ(expected[0].ids.size(), 52u) << "0.5 and 0.51 reach across the border";
  EXPECT_EQ(expected[1].ids.size(), 51u) << "0.49 too";
}

/// Triangles of a strip along x, each beside the one before, with a value at each point; numbers of points do not follow x.
GeometryBlock strip(uint32_t triangles) {
  GeometryBlock block;
  const uint32_t points = triangles + 2;
  for (uint32_t i = 0; i < points; i++) {
    const uint32_t at = uint32_t(uint64_t(i) * 7919 % points);
    block.points.push_back({at / double(points), at % 2 ? 0.25 : 0.75, 0.5});
    block.values.push_back(float(at));
  }
  std::vector<uint32_t> numbers(points);
  for (uint32_t i = 0; i < points; i++) numbers[uint64_t(i) * 7919 % points] = i;
  for (uint32_t t = 0; t < triangles; t++) {
    block.triangles.push_back({numbers[t], numbers[t + 1], numbers[t + 2]});
    block.ids.push_back(t + 5);
  }
  block.fields = {{"two", 2, std::vector<float>(2 * size_t(points))}};
  std::iota(block.fields[0].values.begin(), block.fields[0].values.end(), 0.0f);
  return block;
}

TEST(Distribute, RanksGetTheirHomesInAnyNumberOfPortions) {
  const Partitioning cut = Partitioning::lattice(
      {std::vector<double>{0, 0.8, 0.9, 1}, std::vector<double>{0, 1}, std::vector<double>{0, 1}}, 3);
  for (const uint32_t triangles :
       {1u, 300u, 700'000u}) {  // the last in several portions, with a border in one
    const GeometryBlock whole = strip(triangles);
    const auto homes = homesOf(whole, GeometryKind::Triangles, cut, 3);
    const auto errors = test::ThreadRanks(3).run([&](Collectives& mine) {
      GeometryBlock none;
      none.fields = emptyLike(whole.fields);
      const GeometryBlock home =
          keepHome(mine.rank() == 0 ? whole : none, GeometryKind::Triangles, cut, mine);
      EXPECT_TRUE(home == subset(whole, GeometryKind::Triangles, homes[size_t(mine.rank())])) << triangles;
    });
    EXPECT_EQ(errors, std::vector<std::string>(3));
  }
}

TEST(Distribute, ManyPrimitivesComeInPortions) {
  const Partitioning cut = Partitioning::lattice(
      {std::vector<double>{0, 0.3, 1}, std::vector<double>{0, 1}, std::vector<double>{0, 1}}, 2);
  OwnedGeometry owned;
  owned.kind = GeometryKind::Triangles;
  owned.block = strip(600'000);
  std::map<int, GeometryBlock> expected;
  for (int part = 0; part < 2; part++) {
    std::vector<uint32_t> touching;
    for (uint32_t t = 0; t < owned.block.triangles.size(); t++) {
      Box box;
      for (const uint32_t p : owned.block.triangles[t]) box.extend(owned.block.points[p]);
      const std::vector<int> touched = partitionsTouched(cut, box, 0);
      if (std::count(touched.begin(), touched.end(), part)) touching.push_back(t);
    }
    const GeometryBlock some = subset(owned.block, GeometryKind::Triangles, touching);
    expected[part] = merged(GeometryKind::Triangles, std::span(&some, 1));
  }
  const auto errors = test::ThreadRanks(2).run([&](Collectives& mine) {
    OwnedGeometry none = owned;
    none.block = {};
    none.block.fields = emptyLike(owned.block.fields);
    const auto geometry = distribute(
        mine.rank() == 1 ? owned : none, cut, [](double) { return 0.0; }, mine);
    ASSERT_EQ(geometry->blocks.size(), 1u);
    EXPECT_TRUE(geometry->blocks.begin()->second == expected[mine.rank()]);
  });
  EXPECT_EQ(errors, std::vector<std::string>(2));
}

TEST(Distribute, AnErrorOnOneRankIsThrownOnAll) {
  test::ThreadRanks ranks(2);
  const Partitioning single = Partitioning::single({{0, 0, 0}, {1, 1, 1}});
  const auto errors = ranks.run([&](Collectives& mine) {
    OwnedGeometry owned = particles(mine.rank(), 2);
    if (mine.rank() == 1) owned.block.ids.pop_back();
    distribute(
        owned, single, [](double) { return 0.0; }, mine);
  });
  EXPECT_EQ(errors[0].find("rank 1: "), 0u) << errors[0];
  EXPECT_EQ(errors[0], errors[1]);
}

}  // namespace
}  // namespace gxy

// SPDX-License-Identifier: Apache-2.0
#include "core/data/distribute.h"

#include <gtest/gtest.h>

#include <map>
#include <mutex>
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

// SPDX-License-Identifier: Apache-2.0
#include "core/data/merge_ranges.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/support/thread_ranks.h"

namespace gxy {
namespace {

TEST(MergeRanges, EveryRankHasTheUnionAndEmptyOnesDoNotCount) {
  test::ThreadRanks three(3);
  const auto errors = three.run([](Collectives& ranks) {
    std::vector<Range> ranges(2);
    if (ranks.rank() != 1) ranges[0] = {double(ranks.rank()), double(ranks.rank()) + 0.5};
    mergeRanges(ranks, ranges);
    EXPECT_EQ(ranges[0], (Range{0, 2.5}));
    EXPECT_TRUE(ranges[1].empty());
  });
  EXPECT_EQ(errors, std::vector<std::string>(3));
}

TEST(MergeBox, EveryRankHasTheUnionAndEmptyOnesDoNotCount) {
  test::ThreadRanks three(3);
  const auto errors = three.run([](Collectives& ranks) {
    Box box;
    if (ranks.rank() != 1) box.extend(glm::dvec3(double(ranks.rank()), 1, 2));
    mergeBox(ranks, box);
    EXPECT_EQ(box, (Box{{0, 1, 2}, {2, 1, 2}}));
  });
  EXPECT_EQ(errors, std::vector<std::string>(3));
}

}  // namespace
}  // namespace gxy

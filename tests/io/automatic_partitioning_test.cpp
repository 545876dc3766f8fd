// SPDX-License-Identifier: Apache-2.0
#include "core/io/automatic_partitioning.h"

#include <gtest/gtest.h>

#include "core/comm/error.h"

namespace gxy {
namespace {

TEST(AutomaticPartitioning, GivesAnyNumberOfRanksADivisionOfASmallGrid) {
  for (int64_t n : {2, 4, 12}) {
    const Grid grid{{0, 0, 0}, {1, 1, 1}, {n, n, n}};
    for (int ranks = 1; ranks <= 40; ++ranks) {
      const int parts = automaticPartitioning(grid.box(), &grid, {0, 0, 0}, ranks)->partitions();
      EXPECT_GE(parts, 1);
      EXPECT_LE(parts, ranks);
      if (ranks < n) {
        EXPECT_EQ(parts, ranks);
      }
    }
  }
  const Grid grid{{0, 0, 0}, {1, 1, 1}, {12, 12, 12}};
  EXPECT_EQ(automaticPartitioning(grid.box(), &grid, {0, 0, 0}, 13)->partitions(), 12);
}

TEST(AutomaticPartitioning, RefusesADivisionThatWasAskedFor) {
  const Grid grid{{0, 0, 0}, {1, 1, 1}, {12, 12, 12}};
  EXPECT_THROW(automaticPartitioning(grid.box(), &grid, {13, 0, 0}, 2), Error);
}

}  // namespace
}  // namespace gxy

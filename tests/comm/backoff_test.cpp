// SPDX-License-Identifier: Apache-2.0
#include "core/comm/backoff.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace gxy {
namespace {

using std::chrono::milliseconds;

/// The longest sleep of a thread that has never been active.
Backoff::Microseconds longest(int ranks, int ranksOnNode) {
  Backoff backoff(false, ranks, ranksOnNode);
  Backoff::Microseconds longest{0};
  for (int i = 0; i < 100; i++) longest = std::max(longest, backoff.next(false));
  return longest;
}

TEST(Backoff, OfRanksOnManyNodesIsShorterTheFewerShareANode) {
  EXPECT_EQ(longest(1000, 1), milliseconds(1));
  EXPECT_EQ(longest(1000, 4), milliseconds(4));
  EXPECT_EQ(longest(1000, 64), milliseconds(16));
}

TEST(Backoff, OfRanksOnOneNodeIsLong) {
  for (const int ranks : {1, 2, 64}) EXPECT_EQ(longest(ranks, ranks), milliseconds(16));
}

TEST(Backoff, BeginsShortAndStaysSoInATransfer) {
  Backoff backoff(false, 1000, 1);
  for (int i = 0; i < 100; i++) EXPECT_EQ(backoff.next(true), Backoff::firstSleep);
  EXPECT_EQ(backoff.next(false), Backoff::firstSleep);
  EXPECT_GT(backoff.next(false), Backoff::firstSleep);
}

}  // namespace
}  // namespace gxy

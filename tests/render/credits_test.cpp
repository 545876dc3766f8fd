// SPDX-License-Identifier: Apache-2.0
#include "core/render/credits.h"

#include <gtest/gtest.h>

namespace gxy {
namespace {

// Takes single credits in turn until nobody may; what each has then.
std::vector<int64_t> most(const std::vector<Priority>& shares, int64_t all) {
  Credits credits(all);
  std::vector<int64_t> out(shares.size(), 0);
  for (bool any = true; any;) {
    any = false;
    for (size_t i = 0; i < shares.size(); i++)
      if (credits.mayTake(shares[i], 1)) {
        credits.take(shares[i], 1);
        out[i]++;
        any = true;
      }
  }
  return out;
}

TEST(Credits, OneMayHaveSevenEighthsOfThemAndOfItsTenantsPart) {
  EXPECT_EQ(most({{1, false}}, 6400)[0], 4900)
      << "7/8 of 7/8: there is room for another tenant and another stream";
}

TEST(Credits, OthersHaveAsManyEach) {
  const auto out = most({{1, false}, {2, false}, {3, false}}, 100000);
  EXPECT_NEAR(double(out[0]), double(out[1]), 10);
  EXPECT_NEAR(double(out[0]), double(out[2]), 10);
  EXPECT_NEAR(double(out[0]), 100000 * 49. / (15 + 3 * 49), 10) << "49/15 of what is free";
}

TEST(Credits, WhoComesFindsRoomHoweverManyStreamsAnotherHas) {
  Credits credits(100000);
  for (bool any = true; any;) {
    any = false;
    for (uint64_t stream = 0; stream < 30; stream++)
      if (credits.mayTake({1, true, stream}, 50)) credits.take({1, true, stream}, 50), any = true;
  }
  EXPECT_GE(credits.outOfTenant({1}), 85000);
  EXPECT_LE(credits.outOfTenant({1}), 87500);
  EXPECT_TRUE(credits.mayTake({2, true}, 12000));
}

TEST(Credits, WithNothingOutATileGoesWhateverItCosts) {
  Credits credits(10);
  EXPECT_TRUE(credits.mayTake({1, false}, 1000));
  credits.take({1, false}, 1000);
  EXPECT_FALSE(credits.mayTake({2, true}, 1));
  credits.giveBack({1, false}, 991);
  EXPECT_TRUE(credits.mayTake({2, true}, 1)) << "it has nothing out, and one is free";
  credits.giveBack({1, false}, 9);
  EXPECT_EQ(credits.out(), 0);
  EXPECT_EQ(credits.mostOut(), 1000);
  EXPECT_TRUE(credits.byTenant().empty());
}

}  // namespace
}  // namespace gxy

// SPDX-License-Identifier: Apache-2.0
#include "core/render/admission.h"

#include <gtest/gtest.h>

namespace gxy {
namespace {

using Ids = std::vector<uint64_t>;

TEST(Admission, FramesOfAStreamBeginInTheirOrderAsRoomComes) {
  Admission admission(100, 1);
  const Priority batch{1, false, 7};
  EXPECT_TRUE(admission.enter(batch, 1, 40));
  EXPECT_TRUE(admission.enter(batch, 2, 60));
  EXPECT_FALSE(admission.enter(batch, 3, 70));
  EXPECT_FALSE(admission.enter(batch, 4, 1)) << "there is room, but an older one waits";
  EXPECT_EQ(admission.over(1), Ids{}) << "60 + 70 are too many";
  EXPECT_EQ(admission.over(2), (Ids{3, 4}));
  EXPECT_EQ(admission.waiting(), 0u);
}

TEST(Admission, AFewBeginHoweverLargeTheyAre) {
  Admission admission(100, 2);
  const Priority batch{1, false, 7};
  EXPECT_TRUE(admission.enter(batch, 1, 1000));
  EXPECT_TRUE(admission.enter(batch, 2, 1000));
  EXPECT_FALSE(admission.enter(batch, 3, 1000));
  EXPECT_EQ(admission.over(2), Ids{3});
}

TEST(Admission, StreamsAndTenantsDoNotWaitForEachOther) {
  Admission admission(100, 1);
  EXPECT_TRUE(admission.enter({1, false, 7}, 1, 100));
  EXPECT_FALSE(admission.enter({1, false, 7}, 2, 100));
  EXPECT_TRUE(admission.enter({1, false, 8}, 3, 100));
  EXPECT_TRUE(admission.enter({2, false, 7}, 4, 100));
  EXPECT_EQ(admission.over(3), Ids{});
  EXPECT_EQ(admission.over(1), Ids{2});
}

TEST(Admission, OneThatBeginsAnywayTakesRoomUntilItIsOver) {
  Admission admission(100, 1);
  const Priority batch{1, false, 7};
  EXPECT_TRUE(admission.enter(batch, 1, 100));
  for (const uint64_t id : {2, 3}) EXPECT_FALSE(admission.enter(batch, id, 100));
  admission.beginAnyway(2);
  EXPECT_EQ(admission.over(1), Ids{});
  EXPECT_EQ(admission.over(2), Ids{3});
  EXPECT_EQ(admission.over(99), Ids{}) << "nobody entered it";
}

}  // namespace
}  // namespace gxy

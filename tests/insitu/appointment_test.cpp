// SPDX-License-Identifier: Apache-2.0
// Two threads that decide about the same publishes.
#include <gtest/gtest.h>

#include <thread>

#include "insitu/plan/appointment.h"

namespace gxy::insitu {
namespace {

TEST(Appointment, IsTakenByThePublishWithItsCount) {
  Appointment a;
  EXPECT_FALSE(a.publish());
  EXPECT_TRUE(a.appoint(3));
  EXPECT_FALSE(a.publish());
  EXPECT_TRUE(a.publish());
  EXPECT_FALSE(a.publish()) << "taken once";
  EXPECT_EQ(a.count(), 4u);
}

TEST(Appointment, OfAPublishThatHasBeenIsMissed) {
  Appointment a;
  a.publish();
  a.publish();
  EXPECT_FALSE(a.appoint(2));
  EXPECT_FALSE(a.appoint(1));
  EXPECT_FALSE(a.publish()) << "a missed appointment is not taken later";
}

TEST(Appointment, CanBeTakenBackUntilItIsTaken) {
  Appointment a;
  EXPECT_TRUE(a.appoint(1));
  EXPECT_TRUE(a.cancel(1));
  EXPECT_FALSE(a.publish());
  EXPECT_TRUE(a.appoint(2));
  EXPECT_TRUE(a.publish());
  EXPECT_FALSE(a.cancel(2));
}

TEST(Appointment, IsTakenOrMissedAndNeverBoth) {
  Appointment a;
  constexpr uint64_t kPublishes = 200000;
  std::atomic<uint64_t> taken = 0;
  std::atomic<bool> over = false;
  std::thread simulation([&] {
    for (uint64_t i = 0; i < kPublishes; i++)
      if (a.publish()) taken++;
    over = true;
  });
  uint64_t kept = 0, missed = 0;
  while (!over) {
    const uint64_t count = a.count() + 1 + kept % 3;
    if (!a.appoint(count))
      missed++;
    else if (!(a.count() > count + 1000 && a.cancel(count))) {
      while (a.count() < count && !over) {
      }
      a.cancel(count) ? missed++ : kept++;
    }
  }
  simulation.join();
  EXPECT_EQ(taken, kept) << missed << " missed";
}

}  // namespace
}  // namespace gxy::insitu

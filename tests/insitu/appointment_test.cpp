// SPDX-License-Identifier: Apache-2.0
// Two threads that decide about the same publishes.
#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

#include "insitu/plan/appointment.h"
#include "tests/support/seeds.h"

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

TEST(Appointment, OfAnyLaterPublishIsTakenByTheLast) {
  Appointment a;
  a.publish();
  EXPECT_FALSE(a.publishLast()) << "nothing is appointed";
  EXPECT_EQ(a.count(), 1u) << "so it is not counted";
  EXPECT_FALSE(a.isDue());
  EXPECT_TRUE(a.appoint(7));
  EXPECT_TRUE(a.isDue());
  EXPECT_TRUE(a.publishLast());
  EXPECT_EQ(a.count(), 7u);
  EXPECT_FALSE(a.publishLast()) << "taken once";
  EXPECT_FALSE(a.appoint(7)) << "as it has been";
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

TEST(Appointment, IsTakenByItsPublishOrMissedAndNeverBoth) {
  Appointment a;
  std::vector<uint64_t> taken, kept;
  std::atomic<bool> over = false;
  std::thread simulation([&] {
    for (uint64_t count = 1; !over; count++)
      if (a.publish()) taken.push_back(count);
  });
  for (uint64_t ahead = 0; ahead < uint64_t(test::sweep(20000)); ahead++) {
    const uint64_t count = a.count() + ahead % 4;
    if (count == 0 || !a.appoint(count)) continue;
    while (a.count() < count) std::this_thread::yield();
    if (!a.cancel(count)) kept.push_back(count);
  }
  over = true;
  simulation.join();
  EXPECT_EQ(taken, kept);
  EXPECT_GT(taken.size(), 10u);
}

}  // namespace
}  // namespace gxy::insitu

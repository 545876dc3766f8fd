// SPDX-License-Identifier: Apache-2.0
// What rank 0 does with messages that come late, or that nobody should send.
#include <gtest/gtest.h>

#include <limits>
#include <optional>
#include <string>

#include "core/comm/error.h"
#include "insitu/plan/conductor.h"
#include "insitu/plan/receiver.h"
#include "insitu/plan/sender.h"
#include "tests/insitu/planned.h"

namespace gxy::insitu {
namespace {

using Kind = Control::Kind;
using Messages = std::vector<Control>;

/// Begins a step, and answers with these numbers of publishes; returns the count that is appointed.
uint64_t appointed(Conductor& conductor, std::vector<uint64_t> newest) {
  const Messages asked = conductor.begin();
  EXPECT_EQ(asked.size(), 1u);
  Messages last;
  for (size_t r = 0; r < newest.size(); r++)
    last = conductor.receive(int(r), {Kind::Newest, asked[0].count, newest[r]});
  EXPECT_EQ(last.size(), 1u);
  return last.empty() ? 0 : last[0].count;
}

TEST(Conductor, AppointsThePublishAfterTheNewestOfAllRanks) {
  Conductor conductor = test::planned(3, {0});
  EXPECT_EQ(appointed(conductor, {7, 9, 8}), 10u);
}

TEST(Conductor, AppointsLaterOnesOnly) {
  Conductor conductor = test::planned(1, {0});
  EXPECT_EQ(appointed(conductor, {0}), 1u);
  EXPECT_EQ(conductor.abandon(), (Messages{{Kind::Cancel, 1, 0}}));
  EXPECT_EQ(appointed(conductor, {0}), 2u) << "chunks of the first may still be on their way";
}

TEST(Conductor, AsksAnewAfterAMissAndAppointsFurtherAhead) {
  Conductor conductor = test::planned(2, {0});
  EXPECT_EQ(appointed(conductor, {5, 5}), 6u);
  const Messages then = conductor.receive(1, {Kind::Missed, 6, 8});
  EXPECT_EQ(then, (Messages{{Kind::Cancel, 6, 0}, {Kind::AskNewest, 2, 0}}));
  EXPECT_EQ(conductor.counters().margin, 3u) << "it came two publishes too late";
  EXPECT_EQ(conductor.receive(0, {Kind::Missed, 6, 8}), Messages{}) << "the second miss of the same";
  conductor.receive(0, {Kind::Newest, 2, 9});
  EXPECT_EQ(conductor.receive(1, {Kind::Newest, 2, 9}), (Messages{{Kind::Appoint, 13, 0}}));
  EXPECT_EQ(conductor.receive(0, {Kind::Missed, 6, 8}), Messages{}) << "of an older appointment";
}

TEST(Conductor, DoesNotAppointFurtherAheadForARankThatHasNoRoom) {
  Conductor conductor = test::planned(1, {0});
  EXPECT_EQ(appointed(conductor, {5}), 6u);
  conductor.receive(0, {Kind::Missed, 6, 5});
  EXPECT_EQ(conductor.counters().margin, 0u);
}

TEST(Conductor, AppointsLessFarAheadIfNobodyComesToIt) {
  Conductor conductor = test::planned(1, {0});
  EXPECT_EQ(conductor.again(), Messages{}) << "there is no appointment";
  EXPECT_EQ(appointed(conductor, {5}), 6u);
  EXPECT_EQ(conductor.again(), Messages{}) << "it is the next publish";
  const Messages asked = conductor.receive(0, {Kind::Missed, 6, 1005});
  EXPECT_EQ(conductor.receive(0, {Kind::Newest, asked[1].count, 1005}), (Messages{{Kind::Appoint, 2006, 0}}));
  const Messages then = conductor.again();
  EXPECT_EQ(then, (Messages{{Kind::Cancel, 2006, 0}, {Kind::AskNewest, 3, 0}}));
  EXPECT_EQ(conductor.counters().margin, 500u);
}

TEST(Conductor, AppointsTheNextPublishForRanksThatWait) {
  Conductor conductor = test::planned(1, {});
  EXPECT_EQ(appointed(conductor, {5}), 6u);
  Messages asked = conductor.receive(0, {Kind::Missed, 6, 8});  // so there is a margin now
  EXPECT_FALSE(conductor.isAwaited());
  EXPECT_EQ(conductor.receive(0, {Kind::Waits, 9, 0}), Messages{});
  EXPECT_TRUE(conductor.isAwaited());
  EXPECT_EQ(conductor.receive(0, {Kind::Newest, asked[1].count, 8}), (Messages{{Kind::Appoint, 9, 0}}));
  conductor.receive(0, StepHeader{9, 9, 0});
  ASSERT_TRUE(conductor.isComplete());
  conductor.published();
  EXPECT_FALSE(conductor.isAwaited());
  conductor.receive(0, {Kind::Waits, 9, 0});
  EXPECT_FALSE(conductor.isAwaited()) << "it was said before the appointment came";
  EXPECT_EQ(appointed(conductor, {20}), 21u) << "it will wait, though it does not yet";
  asked = conductor.receive(0, {Kind::Missed, 21, 21});
  EXPECT_EQ(conductor.receive(0, {Kind::Newest, asked[1].count, 21}), (Messages{{Kind::Appoint, 22, 0}}));
  asked = conductor.receive(0, {Kind::Missed, 22, 22});
  EXPECT_EQ(conductor.receive(0, {Kind::Newest, asked[1].count, 22}), (Messages{{Kind::Appoint, 35, 0}}))
      << "it does not wait for long enough";
}

TEST(Sender, TellsEachServerOnceWhatItWaitsFor) {
  Sender sender;
  sender.begin();
  EXPECT_EQ(sender.waits(), std::nullopt);
  sender.await();
  EXPECT_EQ(sender.waits(), (Control{Kind::Waits, 1, 0}));
  EXPECT_EQ(sender.waits(), std::nullopt);
  sender.begin();  // with another server
  EXPECT_EQ(sender.waits(), (Control{Kind::Waits, 1, 0}));
  sender.publish();  // The time was out.
  sender.await();
  EXPECT_EQ(sender.waits(), std::nullopt) << "it has not answered yet";
  sender.receive({Kind::AskNewest, 1, 0});
  EXPECT_EQ(sender.waits(), (Control{Kind::Waits, 2, 0}));
  sender.publish();
  sender.begin();
  EXPECT_EQ(sender.waits(), std::nullopt);
}

TEST(Sender, SaysNothingWhileItHasNoRoom) {
  Sender sender;
  sender.expect({{0, {{1, 4}}}});
  EXPECT_EQ(sender.receive({Kind::Appoint, 1, 0}), std::nullopt);
  EXPECT_TRUE(sender.publish());
  EXPECT_EQ(sender.receive({Kind::Cancel, 1, 0}), std::nullopt);
  EXPECT_EQ(sender.receive({Kind::AskNewest, 9, 0}), std::nullopt)
      << "the simulation still copies into the slot";
  EXPECT_EQ(sender.answer(), std::nullopt);
  sender.filled(1, 0);
  EXPECT_EQ(sender.announcement(), std::nullopt) << "the step was cancelled";
  EXPECT_EQ(sender.answer(), (Control{Kind::Newest, 9, 1}));
  EXPECT_EQ(sender.answer(), std::nullopt);
}

TEST(Conductor, IgnoresAnswersToOlderQuestions) {
  Conductor conductor = test::planned(1, {0});
  conductor.begin();
  EXPECT_EQ(conductor.abandon(), Messages{});
  const Messages asked = conductor.begin();
  EXPECT_EQ(conductor.receive(0, {Kind::Newest, asked[0].count - 1, 3}), Messages{});
  EXPECT_EQ(conductor.receive(0, {Kind::Newest, asked[0].count, 4}), (Messages{{Kind::Appoint, 5, 0}}));
}

TEST(Conductor, LeavesOutPublishesThatAreNotNeeded) {
  Conductor conductor = test::planned(1, {});
  const auto answer = [&](const Messages& asked, uint64_t newest) {
    return conductor.receive(0, {Kind::Newest, asked.back().count, newest});
  };
  EXPECT_EQ(answer(conductor.begin(100), 95), (Messages{{Kind::Appoint, 100, 0}}));
  EXPECT_EQ(conductor.again(), Messages{}) << "nobody is late";
  conductor.receive(0, StepHeader{100, 1, 0});
  conductor.published();
  EXPECT_EQ(answer(conductor.begin(50), 200), (Messages{{Kind::Appoint, 201, 0}})) << "it is farther already";
  conductor.receive(0, StepHeader{201, 2, 0});
  conductor.published();
  conductor.receive(0, {Kind::Waits, 202, 0});
  EXPECT_EQ(answer(conductor.begin(500), 201), (Messages{{Kind::Appoint, 202, 0}}))
      << "where a rank waits, none is left out";
}

TEST(Conductor, LooksHowManyPublishesThereHaveBeen) {
  Conductor conductor = test::planned(2, {});
  const Messages asked = conductor.look();
  ASSERT_EQ(asked.size(), 1u);
  EXPECT_EQ(conductor.look(), Messages{}) << "it has asked";
  EXPECT_EQ(conductor.receive(0, {Kind::Newest, asked[0].count, 7}), Messages{});
  EXPECT_EQ(conductor.newest(), 0u);
  EXPECT_EQ(conductor.receive(1, {Kind::Newest, asked[0].count, 9}), Messages{});
  EXPECT_EQ(conductor.newest(), 9u);
  const Messages again = conductor.look();
  const Messages begun = conductor.begin();
  ASSERT_EQ(begun.size(), 1u) << "although not all have answered";
  EXPECT_EQ(conductor.receive(0, {Kind::Newest, again[0].count, 10}), Messages{}) << "too late";
  conductor.receive(0, {Kind::Newest, begun[0].count, 11});
  EXPECT_EQ(conductor.receive(1, {Kind::Newest, begun[0].count, 12}), (Messages{{Kind::Appoint, 13, 0}}));
}

TEST(Conductor, KnowsWhichRankTookTheStepLast) {
  Conductor conductor = test::planned(3, {0});
  const uint64_t count = appointed(conductor, {4, 4, 4});
  EXPECT_EQ(conductor.latest(), -1);
  for (const int rank : {2, 0, 1}) {
    conductor.receive(rank, StepHeader{count, 70, 0.5});
    EXPECT_EQ(conductor.latest(), rank);
  }
  conductor.receive(2, StepHeader{count, 70, 0.5});
  EXPECT_EQ(conductor.latest(), 1) << "rank 2 has said so before";
  conductor.receive(0, StepHeader{count - 1, 69, 0.5});
  EXPECT_EQ(conductor.latest(), 1) << "of another publish";
}

TEST(Conductor, IsCompleteWithTheWordOfAllRanksAndAllSamples) {
  Conductor conductor = test::planned(2, {1});
  const uint64_t count = appointed(conductor, {0, 0});
  conductor.receive(0, StepHeader{count, 70, 0.5});
  conductor.complete(1, count);
  EXPECT_FALSE(conductor.isComplete());
  EXPECT_EQ(
      conductor.missing(),
      "ranks of the simulation that have not published it: 1; ranks of the server that lack samples: none");
  conductor.receive(1, StepHeader{count, 70, 0.5});
  EXPECT_TRUE(conductor.isComplete());
  EXPECT_EQ(conductor.step(), (StepHeader{count, 70, 0.5}));
  EXPECT_EQ(conductor.published(), (Messages{{Kind::Published, count, 0}}));
  EXPECT_FALSE(conductor.isComplete());
}

TEST(Conductor, RefusesRanksThatDisagreeAndTakesTimesThatAreUnknown) {
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  Conductor conductor = test::planned(3, {});
  const uint64_t count = appointed(conductor, {0, 0, 0});
  conductor.receive(0, StepHeader{count, 70, kUnknown});
  EXPECT_NO_THROW(conductor.receive(1, StepHeader{count, 70, kUnknown}));
  EXPECT_THROW(conductor.receive(2, StepHeader{count, 71, kUnknown}), Error);
}

TEST(Conductor, RefusesWhatOnlyServersSay) {
  Conductor conductor = test::planned(1, {0});
  EXPECT_THROW(conductor.receive(0, Control{Kind::Appoint, 1, 0}), Error);
}

TEST(Sender, SaysThatAStepWithoutRoomForItsCopyIsMissed) {
  Sender sender;
  sender.expect({{0, {{1, 4}}}});
  EXPECT_EQ(sender.receive({Kind::Appoint, 1, 0}), std::nullopt);
  EXPECT_TRUE(sender.publish());
  sender.notFilled(true);
  EXPECT_EQ(sender.announcement(), std::nullopt);
  EXPECT_EQ(sender.answer(), (Control{Kind::Missed, 1, 1}));
  EXPECT_EQ(sender.answer(), std::nullopt);
  EXPECT_EQ(sender.receive({Kind::AskNewest, 9, 0}), (Control{Kind::Newest, 9, 1}));
  EXPECT_EQ(sender.receive({Kind::Appoint, 2, 0}), std::nullopt) << "the slot is free";
  EXPECT_TRUE(sender.publish());
  EXPECT_EQ(sender.receive({Kind::Cancel, 2, 0}), std::nullopt);
  sender.notFilled(false);
  EXPECT_EQ(sender.answer(), std::nullopt) << "the server has cancelled it by itself";
}

TEST(Sender, SendsAsManyPointsCellsAndCornersAsThereAre) {
  // Positions, a field of points; types, ends; corners.
  const std::vector<Item> items{{0, 24, 3, true}, {0, 4, 3}, {0, 1, 4, true}, {0, 4, 4}, {0, 4, 5, true}};
  Sender sender;
  sender.expect({{0, items}});
  Receiver receiver({items});
  uint64_t count = 0;
  for (const Counts& counts :
       {Counts{0, 0, 0, 4, 2, 6}, Counts{0, 0, 0, 9, 0, 0}, Counts{0, 0, 0, 100000, 300000, 900000}}) {
    sender.receive({Kind::Appoint, ++count, 0});
    ASSERT_TRUE(sender.publish());
    sender.filled(1, 0, counts);
    receiver.open();
    uint64_t place = 0;
    while (const auto chunk = sender.next(0)) {
      EXPECT_FALSE(receiver.complete());
      EXPECT_EQ(chunk->place, place);
      place += chunk->bytes;
      EXPECT_TRUE(receiver.accept(0, chunk->header, chunk->bytes));
    }
    EXPECT_EQ(place, counts[3] * 28 + counts[4] * 5 + counts[5] * 4);
    EXPECT_TRUE(receiver.complete());
    EXPECT_TRUE(receiver.take(count));
    receiver.close(count);
    sender.receive({Kind::Published, count, 0});
  }
  receiver.open();
  receiver.accept(0, {9, 0, 2, 0, 0}, 48);
  receiver.accept(0, {9, 0, 2, 1, 0}, 8);
  receiver.accept(0, {9, 0, 3, 2, 0}, 3);
  EXPECT_THROW(receiver.accept(0, {9, 0, 2, 3, 0}, 8), Error) << "as many ends as types";
}

TEST(Sender, SendsAsManyParticlesAsThereAre) {
  Sender sender;
  sender.expect({{0, {{2, 4}, {0, 24, 1, true}, {0, 8, 1}}}, {1, {{0, 24, 2, true}}}});
  uint64_t count = 0;
  for (const uint64_t particles : {3, 0, 50000}) {
    sender.receive({Kind::Appoint, ++count, 0});
    ASSERT_TRUE(sender.publish());
    sender.filled(1, 0, {0, particles, 1});
    uint64_t place = 0, item = 0, offset = 0;
    const uint64_t points[] = {2, particles, particles}, bytes[] = {4, 24, 8};
    while (const auto chunk = sender.next(0)) {
      EXPECT_EQ(chunk->header, (PieceHeader{count, offset, points[item], uint32_t(item), 0}));
      EXPECT_EQ(chunk->place, place);
      EXPECT_EQ(chunk->bytes % bytes[item], 0u);
      place += chunk->bytes;
      offset += chunk->bytes;
      if (offset == points[item] * bytes[item]) item++, offset = 0;
    }
    EXPECT_EQ(item, 3u);
    const auto other = sender.next(1);
    ASSERT_TRUE(other);
    EXPECT_EQ(other->place, place);
    EXPECT_EQ(other->bytes, 24u);
    sender.receive({Kind::Published, count, 0});
  }
}

TEST(Sender, SendsStepsOfAnotherFormFromTheNextOneOn) {
  Sender sender;
  sender.expect({{0, {{2, 8}}}});
  Receiver receiver({{{2, 8}}});
  uint64_t count = 0;
  for (const uint64_t bytes : {8, 4, 4, 8}) {
    sender.expect({{0, {{2, bytes}}}});
    receiver.expect({{{2, bytes}}});
    receiver.open();
    EXPECT_THROW(receiver.expect({}), Error) << "there is room";
    sender.receive({Kind::Appoint, ++count, 0});
    EXPECT_THROW(sender.expect({}), Error) << "a step is appointed";
    ASSERT_TRUE(sender.publish());
    sender.filled(1, 0);
    EXPECT_THROW(sender.expect({}), Error) << "a step is sent";
    const auto chunk = sender.next(0);
    ASSERT_TRUE(chunk);
    EXPECT_EQ(chunk->bytes, 2 * bytes);
    EXPECT_TRUE(receiver.accept(0, chunk->header, chunk->bytes));
    EXPECT_TRUE(receiver.take(count));
    receiver.close(count);
    EXPECT_FALSE(receiver.accept(0, chunk->header, 1)) << "chunks of before are dropped, whatever they have";
    sender.receive({Kind::Published, count, 0});
  }
}

TEST(Receiver, IsEmptyWhenThereIsRoomAgain) {
  Receiver receiver({{{1, 4}}});
  receiver.open();
  EXPECT_TRUE(receiver.accept(0, {1, 0, 1, 0, 0}, 4));
  EXPECT_TRUE(receiver.complete());
  EXPECT_TRUE(receiver.take(1));
  receiver.close(1);
  receiver.open();
  EXPECT_FALSE(receiver.complete());
  EXPECT_FALSE(receiver.take(1));
}

TEST(Receiver, TakesWholePointsInTheirOrderOnly) {
  const std::vector<Receiver::Source> sources{{{3, 4}, {1, 8}}, {}};
  const auto expectRefused = [&](const PieceHeader& header, uint64_t bytes) {
    Receiver receiver(sources);
    receiver.open();
    EXPECT_THROW(receiver.accept(0, header, bytes), Error);
  };
  expectRefused({1, 0, 1, 1, 0}, 8);   // the second item first
  expectRefused({1, 4, 3, 0, 0}, 4);   // not at its begin
  expectRefused({1, 0, 3, 0, 0}, 6);   // half a point
  expectRefused({1, 0, 3, 0, 0}, 16);  // more than there is
  expectRefused({1, 0, 2, 0, 0}, 8);   // an item of another size
  expectRefused({1, 0, 3, 0, 0}, 0);
  Receiver receiver(sources);
  EXPECT_THROW(receiver.accept(0, {1, 0, 3, 0, 0}, 4), Error) << "there is no room";
  receiver.open();
  EXPECT_THROW(receiver.accept(1, {1, 0, 3, 0, 0}, 4), Error) << "nothing comes from this rank";
}

TEST(Receiver, TakesAsManyParticlesAsTheFirstArrayHas) {
  const std::vector<Receiver::Source> sources{{{0, 24, 0, true}, {0, 4, 0}}, {{0, 24, 0, true}, {0, 4, 0}}};
  Receiver receiver(sources);
  receiver.open();
  EXPECT_TRUE(receiver.accept(0, {1, 0, 2, 0, 0}, 24));
  EXPECT_THROW(receiver.accept(0, {1, 24, 3, 0, 0}, 24), Error) << "now there is one more";
  EXPECT_TRUE(receiver.accept(0, {1, 24, 2, 0, 0}, 24));
  EXPECT_THROW(receiver.accept(0, {1, 0, 1, 1, 0}, 4), Error) << "a value too few";
  EXPECT_TRUE(receiver.accept(0, {1, 0, 2, 1, 0}, 8));
  EXPECT_TRUE(receiver.accept(1, {1, 0, 0, 0, 0}, 0)) << "a rank without particles";
  EXPECT_FALSE(receiver.complete());
  EXPECT_TRUE(receiver.accept(1, {1, 0, 0, 1, 0}, 0));
  EXPECT_TRUE(receiver.complete());
  EXPECT_TRUE(receiver.accept(0, {2, 0, 1, 0, 0}, 24)) << "a later step may have others";
  EXPECT_FALSE(receiver.complete());
  EXPECT_THROW(receiver.accept(1, {2, 0, kMostParticles + 1, 0, 0}, 24), Error);
}

TEST(Receiver, DropsWhatComesOfAStepThatIsRefused) {
  Receiver receiver({{{2, 4}}, {{1, 4}}});
  receiver.open();
  EXPECT_TRUE(receiver.accept(0, {5, 0, 2, 0, 0}, 4));
  receiver.refuse(5);
  EXPECT_FALSE(receiver.accept(0, {5, 4, 2, 0, 0}, 4));
  EXPECT_FALSE(receiver.accept(1, {5, 0, 1, 0, 0}, 4));
  EXPECT_FALSE(receiver.complete());
  EXPECT_TRUE(receiver.accept(0, {6, 0, 2, 0, 0}, 8));
  EXPECT_TRUE(receiver.accept(1, {6, 0, 1, 0, 0}, 4));
  EXPECT_TRUE(receiver.take(6));
}

}  // namespace
}  // namespace gxy::insitu

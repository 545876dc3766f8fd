// SPDX-License-Identifier: Apache-2.0
// Flights of items that are no rays, under many schedules: always complete, never early, exact, nothing left
// behind. --schedules=100000 tries so many.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/render/walkers.h"
#include "tests/support/seeds.h"

namespace gxy::test {
namespace {

uint64_t schedules(int usual) {
  for (const std::string& arg : testing::internal::GetArgvs())
    if (arg.rfind("--schedules=", 0) == 0) return std::stoull(arg.substr(12));
  return uint64_t(seeds(usual));
}

// Runs to the end, and expects that nothing is left and that nothing was refused.
void runAll(Walks& walks) {
  ASSERT_TRUE(walks.run()) << "there is no end";
  ASSERT_EQ(walks.errors(), std::vector<std::string>{});
  ASSERT_EQ(walks.leftOver(), "");
}

// Every rank has ended the flight once.
void expectEnded(Walks& walks, FlightId id) {
  const Walks::Outcome& outcome = walks.outcome(id);
  ASSERT_EQ(outcome.complete, 1);
  for (const int ends : outcome.ends) ASSERT_EQ(ends, 1);
  ASSERT_EQ(outcome.counted, outcome.ending.counts() ? int(outcome.ends.size()) : 0);
  ASSERT_EQ(outcome.reports, int(outcome.ends.size()));
}

void expectWhole(Walks& walks, FlightId id, const Walk& walk) {
  expectEnded(walks, id);
  const Walks::Outcome& outcome = walks.outcome(id);
  ASSERT_TRUE(outcome.ending.counts()) << outcome.ending.error;
  const auto [sum, count] = Walks::expected(walk, int(outcome.ends.size()));
  ASSERT_EQ(outcome.count, count) << "when it was complete";
  ASSERT_EQ(outcome.sum, sum);
  ASSERT_EQ(outcome.reported, sum) << "what rank 0 was told";
}

TEST(Flights, AreExactUnderManySchedules) {
  uint64_t overtaking = 0;
  for (uint64_t seed = 1; seed <= schedules(1000); seed++) {
    SCOPED_TRACE("schedule " + std::to_string(seed));
    Walks::Options options;
    options.ranks = 1 + int(seed % 5);
    options.packet = 1 + int(seed % 4);
    options.credits = seed % 3 ? 1 + int64_t(seed % 7) : 1 << 20;
    options.runners = 1 + int(seed % 6);
    Walks walks(seed, options);
    std::vector<std::pair<FlightId, Walk>> begun;
    for (uint32_t i = 0; i < 3; i++) {
      Walk walk;
      walk.salt = seed * 3 + i;
      walk.tenant = i % 2;
      walk.partitions = 1 + int(seed % 9);
      walk.walkers = int(seed / 2 % 8);  // none, too
      walk.children = int(seed % 2);
      begun.push_back({walks.start(walk), walk});
    }
    runAll(walks);
    for (const auto& [id, walk] : begun) expectWhole(walks, id, walk);
    overtaking += walks.mostParked() > 0;
    ASSERT_EQ(walks.mostBytes("parked messages") > 0, walks.mostParked() > 0);
    ASSERT_EQ(walks.mostBytes("items") > 0, begun[0].second.walkers > 0);
    if (HasFailure()) return;
  }
  EXPECT_GT(overtaking, schedules(1000) / 10) << "schedules in which messages overtook the start";
}

TEST(Flights, ThatAreCancelledEndWhereverTheyAre) {
  uint64_t cancelled = 0, whole = 0;
  for (uint64_t seed = 1; seed <= schedules(500); seed++) {
    SCOPED_TRACE("schedule " + std::to_string(seed));
    Walks::Options options;
    options.ranks = 1 + int(seed % 4);
    options.credits = seed % 2 ? 4 : 1 << 20;
    options.runners = 4;  // so that what is slow is not one of too many
    Walks walks(seed, options);
    Walk walk, other;
    walk.salt = other.salt = seed;
    other.tenant = 1;
    walk.endless = int(seed % 3);
    walk.children = walk.endless < 2;
    const FlightId id = walks.announce();
    if (seed % 11 == 0) walks.rank(0).cancel(id);  // before it begins
    walks.begin(id, walk);
    const FlightId beside = walks.start(other);
    for (uint64_t steps = Random(seed).below(200); steps > 0 && walks.step(); steps--) {
    }
    walks.rank(0).cancel(id);
    walks.rank(0).cancel(id);
    runAll(walks);
    walks.rank(0).cancel(id);
    runAll(walks);
    expectWhole(walks, beside, other);
    if (walks.outcome(id).ending.counts())
      expectWhole(walks, id, walk);
    else
      expectEnded(walks, id);
    cancelled += walks.outcome(id).ending.cancelled;
    whole += walks.outcome(id).ending.counts();
    ASSERT_EQ(walks.outcome(id).ending.error, "");
    if (HasFailure()) return;
  }
  EXPECT_GT(cancelled, schedules(500) * 6 / 10);
  EXPECT_GT(whole, 0u) << "some were complete before";
}

// A cancelled flight makes no more items, and those that it has made end within a few steps.
TEST(Flights, ThatAreCancelledEndAtOnce) {
  Walks::Options options;
  options.credits = 1;  // a chunk at a time
  Walks walks(1, options);
  Walk walk;
  walk.walkers = 1'000'000;
  const FlightId id = walks.start(walk);
  for (int i = 0; i < 200; i++) walks.step();
  walks.rank(0).cancel(id);
  ASSERT_TRUE(walks.run(1000));
  expectEnded(walks, id);
  EXPECT_LT(walks.outcome(id).count, 100u);
  EXPECT_EQ(walks.leftOver(), "");
}

TEST(Flights, FailWithTheErrorOfTheRankThatCannotDoItsPart) {
  uint64_t failed = 0;
  for (uint64_t seed = 1; seed <= schedules(500); seed++) {
    SCOPED_TRACE("schedule " + std::to_string(seed));
    Walks::Options options;
    options.ranks = 2 + int(seed % 3);
    options.credits = seed % 2 ? 3 : 1 << 20;
    options.runners = 4;
    Walks walks(seed, options);
    Walk walk, other;
    walk.salt = other.salt = seed;
    other.tenant = 1;
    walk.failure = Failure(1 + seed % 5);
    walk.failingRank = int(seed / 5 % uint64_t(options.ranks));
    // Walkers that stay where they are, and have all credits, may never come to a rank that fails when they do.
    walk.endless = int(seed / 15 % (walk.failure <= Failure::Spawn ? 3 : 2));
    walk.children = walk.endless < 2;
    const FlightId id = walks.start(walk), beside = walks.start(other);
    ASSERT_TRUE(walks.run()) << "there is no end";
    ASSERT_EQ(walks.leftOver(), "");
    const std::string reason = walk.failure == Failure::Result ? "the device is lost" : "no room";
    if (walks.outcome(id).ending.counts()) {  // no walker came to the rank that would have failed
      ASSERT_GE(walk.failure, Failure::Advance);
      expectWhole(walks, id, walk);
    } else {
      expectEnded(walks, id);
      ASSERT_EQ(walks.outcome(id).ending.error, "rank " + std::to_string(walk.failingRank) + ": " + reason);
      ASSERT_FALSE(walks.outcome(id).ending.cancelled);
      failed++;
    }
    expectWhole(walks, beside, other);
    for (const std::string& error : walks.errors())  // of handlers: refused messages
      EXPECT_TRUE(walk.failure == Failure::Read && error.find("no room") != std::string::npos) << error;
    if (HasFailure()) return;
  }
  EXPECT_GT(failed, schedules(500) * 9 / 10);
}

TEST(Flights, TellTheFirstErrorOnly) {
  Walks walks(1, {});
  Walk walk;
  walk.endless = 1;
  const FlightId id = walks.start(walk);
  walks.rank(0).created(id, 2);  // both messages
  for (const char* error : {"rank 1: first", "rank 2: second"}) {
    ASSERT_EQ(walks.outcome(id).complete, 0);
    walks.world().rank(1).send(0, Walks::kControl, Writer().write(uint8_t(4)).write(id).write(error).take());
    walks.run(3000);  // the waves of Completion go on until it has got both
  }
  expectEnded(walks, id);
  EXPECT_EQ(walks.outcome(id).ending.error, "rank 1: first");
}

// Walkers without children never have more credits than they took: the bound holds.
TEST(Flights, KeepToTheirCredits) {
  for (const int64_t credits : {1, 6, 20}) {
    Walks::Options options;
    options.credits = credits;
    Walks walks(uint64_t(credits), options);
    Walk walk;
    walk.children = 0;
    walk.walkers = 60;
    std::vector<FlightId> ids;
    for (uint32_t tenant = 0; tenant < 3; tenant++) {
      walk.tenant = tenant;
      ids.push_back(walks.start(walk));
    }
    runAll(walks);
    for (const FlightId id : ids) expectWhole(walks, id, walk);
    int64_t most = 0;
    for (int r = 0; r < options.ranks; r++) most = std::max(most, walks.rank(r).counters().mostCredits);
    EXPECT_LE(most, std::max(credits, int64_t(walk.chunk))) << credits;
    EXPECT_GE(most, int64_t(walk.chunk)) << credits;
  }
}

// A rank that works, or has items that wait, holds back the wave of Completion. So on one rank there are two
// waves and the word that the flight is done, however long it takes.
TEST(Flights, HoldBackTheWaveWhileItemsWait) {
  for (uint64_t seed = 1; seed <= schedules(300); seed++) {
    Walks::Options options;
    options.ranks = 1;
    Walks walks(seed, options);
    Walk walk;
    walk.salt = seed;
    walk.walkers = 20;
    walk.sends = 0;  // messages under way hold nothing back
    const FlightId id = walks.start(walk);
    runAll(walks);
    expectWhole(walks, id, walk);
    ASSERT_EQ(walks.completionMessages(), 3u) << "schedule " << seed;
  }
  for (uint64_t seed = 1; seed <= schedules(300); seed++) {
    Walks walks(seed, {});
    Walk walk;
    walk.salt = seed;
    const FlightId id = walks.start(walk);
    runAll(walks);
    expectWhole(walks, id, walk);
    ASSERT_EQ(walks.answersWhileTasksWaited(), 0u) << "schedule " << seed;
  }
}

TEST(Flights, RefuseWhatTheyWouldNotSend) {
  const auto header = [](FlightId id, int32_t partition, int32_t origin, int32_t count, uint32_t kind,
                         size_t bytes) {
    Bytes message = Writer().write(id).write(partition).write(origin).write(count).write(kind).take();
    message.resize(message.size() + bytes);
    return message;
  };
  struct Case {
    Channel channel;
    Bytes message;
    const char* expected;
  };
  const std::vector<Case> cases{
      {Walks::kItems, header(1, 0, 0, 1, 2, 8), "header"},
      {Walks::kItems, header(1, 0, 0, 1, 2, 0), "header"},
      {Walks::kItems, header(1, 0, 0, 2, 0, 12), "header"},
      {Walks::kItems, header(1, 0, 0, 0, 0, 0), "header"},
      {Walks::kItems, header(1, 0, 3, 1, 0, 12), "header"},
      {Walks::kItems, header(1, 0, -1, 1, 0, 12), "header"},
      {Walks::kItems, header(0, 0, 0, 1, 0, 12), "header"},
      {Walks::kItems, header(1, 0, 0, 1, 0, 12), "walk 1, which is over"},
      {Walks::kItems, {}, "walkers"},
      {Walks::kCredits, Writer().write(uint32_t(0)).write(uint64_t(0)).write(INT64_MIN).take(),
       "credits come back"},
      {Walks::kControl, Writer().write(uint8_t(5)).write(FlightId(1)).take(), "kind is 5"},
      {Walks::kControl, Writer().write(uint8_t(1)).write(FlightId(0)).take(), "not for rank 1"},
      {Walks::kControl, Writer().write(uint8_t(3)).write(FlightId(1)).take(), "not for rank 1"},
      {Walks::kControl, Writer().write(uint8_t(0)).write(FlightId(1)).write(Walk{}).take(),
       "walk 1 has started before"},
      {Walks::kControl, Writer().write(uint8_t(0)).write(FlightId(9)).write(uint8_t(0)).take(),
       "walk message"},
      {Walks::kControl, Writer().write(uint8_t(2)).write(FlightId(1)).write(true).take(),
       "walk 1 was said to be finished"},
  };
  for (const Case& c : cases) {
    Walks walks(1, {});
    walks.start({});
    ASSERT_TRUE(walks.run());
    walks.world().rank(0).send(1, c.channel, c.message);
    ASSERT_TRUE(walks.run());
    ASSERT_EQ(walks.errors().size(), 1u) << c.expected;
    EXPECT_NE(walks.errors()[0].find(c.expected), std::string::npos) << walks.errors()[0];
    const Walk next;
    const FlightId id = walks.start(next);
    ASSERT_TRUE(walks.run());
    expectWhole(walks, id, next);
    EXPECT_EQ(walks.leftOver(), "") << c.expected;
  }
}

// What is queued is dropped, whatever it holds.
TEST(Flights, MayBeDestroyedInTheMiddle) {
  for (uint64_t seed = 1; seed <= schedules(100); seed++) {
    Walks walks(seed, {});
    Walk walk;
    walk.endless = 1;
    walks.start(walk);
    for (uint64_t steps = Random(seed).below(300); steps > 0 && walks.step(); steps--) {
    }
  }
}

}  // namespace
}  // namespace gxy::test

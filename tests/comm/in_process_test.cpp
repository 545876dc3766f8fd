// SPDX-License-Identifier: Apache-2.0
#include "core/comm/in_process.h"

#include <gtest/gtest.h>

#include <atomic>
#include <set>
#include <string>
#include <thread>

#include "core/comm/error.h"
#include "core/comm/wire.h"

using namespace gxy;

namespace {

Bytes number(uint64_t value) { return Writer().write(value).take(); }
uint64_t numberIn(const Bytes& bytes) { return Reader(bytes, "number").read<uint64_t>(); }

/// The order in which 3 ranks get 20 numbered messages each and run 5 tasks each.
std::string schedule(uint64_t seed) {
  std::string order;
  InProcessWorld world(3, seed);
  for (int r = 0; r < 3; ++r)
    world.rank(r).onMessage(Channel::Test, [&order, r](int source, Bytes message) {
      order +=
          std::to_string(r) + "<" + std::to_string(source) + ":" + std::to_string(numberIn(message)) + " ";
    });
  for (uint64_t i = 0; i < 20; ++i)
    for (int r = 0; r < 3; ++r) world.rank(r).send(int(i + r) % 3, Channel::Test, number(i));
  for (int i = 0; i < 5; ++i)
    for (int r = 0; r < 3; ++r) world.rank(r).post([&order, r] { order += std::to_string(r) + "t "; });
  world.run();
  return order;
}

}  // namespace

TEST(SeededWorld, TheSameSeedGivesTheSameSchedule) {
  for (uint64_t seed = 0; seed < 50; ++seed) EXPECT_EQ(schedule(seed), schedule(seed));
}

TEST(SeededWorld, SeedsGiveDifferentSchedules) {
  std::set<std::string> schedules;
  for (uint64_t seed = 0; seed < 200; ++seed) schedules.insert(schedule(seed));
  EXPECT_EQ(schedules.size(), 200u);
}

TEST(SeededWorld, NothingIsLostAndNothingComesTwice) {
  for (uint64_t seed = 0; seed < 200; ++seed) {
    const std::string order = schedule(seed);
    std::multiset<std::string> events;
    for (size_t at = 0; at < order.size();) {
      const size_t end = order.find(' ', at);
      events.insert(order.substr(at, end - at));
      at = end + 1;
    }
    EXPECT_EQ(events.size(), 75u);
    EXPECT_EQ(events.count("1t"), 5u);
    EXPECT_EQ(events.count("1<0:4"), 1u);
  }
}

TEST(SeededWorld, AMessageBeforeItsHandlerIsKept) {
  InProcessWorld world(2, 1);
  world.rank(0).send(1, Channel::Test, number(5));
  world.run();
  uint64_t got = 0;
  world.rank(1).onMessage(Channel::Test, [&](int, Bytes message) { got = numberIn(message); });
  EXPECT_EQ(got, 0u);
  world.run();
  EXPECT_EQ(got, 5u);
}

TEST(SeededWorld, ARemovedHandlerKeepsMessagesForTheNext) {
  InProcessWorld world(1, 1);
  int first = 0, second = 0;
  world.rank(0).onMessage(Channel::Test, [&](int, Bytes) { ++first; });
  world.rank(0).onMessage(Channel::Test, nullptr);
  world.rank(0).send(0, Channel::Test, {});
  world.run();
  world.rank(0).onMessage(Channel::Test, [&](int, Bytes) { ++second; });
  world.run();
  EXPECT_EQ(first, 0);
  EXPECT_EQ(second, 1);
}

TEST(SeededWorld, SendingToARankThatIsNotThereIsAnError) {
  InProcessWorld world(2, 1);
  EXPECT_THROW(world.rank(0).send(2, Channel::Test, {}), Error);
  EXPECT_THROW(world.rank(0).send(-1, Channel::Test, {}), Error);
}

TEST(ThreadedWorld, HandlersOfARankRunOneAtATimeAndNothingIsLost) {
  InProcessWorld::Options options;
  options.threaded = true;
  constexpr int ranks = 4, messages = 500;
  uint64_t sums[ranks] = {};  // written by handlers without a lock: the sanitizer would tell
  InProcessWorld world(ranks, 3, options);
  for (int r = 0; r < ranks; ++r)
    world.rank(r).onMessage(Channel::Test, [&sums, r](int, Bytes message) { sums[r] += numberIn(message); });
  for (int r = 0; r < ranks; ++r)
    for (uint64_t i = 0; i < messages; ++i)
      world.rank(r).post([&world, r, i] { world.rank(r).send(int(i) % ranks, Channel::Test, number(i)); });
  world.run();
  uint64_t total = 0;
  for (const uint64_t sum : sums) total += sum;
  EXPECT_EQ(total, uint64_t(ranks) * messages * (messages - 1) / 2);
  EXPECT_EQ(world.rank(0).counters().messagesSent, uint64_t(messages));
}

TEST(ThreadedWorld, WaitingTasksMayWaitForEachOther) {
  InProcessWorld::Options options;
  options.threaded = true;
  options.workers = 1;
  InProcessWorld world(2, 3, options);
  std::atomic<int> there = 0;
  for (int i = 0; i < 6; ++i)
    world.rank(i % 2).postWaiting([&] {
      ++there;
      while (there < 6) std::this_thread::yield();
    });
  world.run();
  EXPECT_EQ(there, 6);
}

TEST(ThreadedWorld, AnExceptionOutOfAHandlerOrTaskIsReportedWithItsRank) {
  InProcessWorld::Options options;
  options.threaded = true;
  std::mutex mutex;
  std::set<std::string> reports;
  options.onError = [&](int rank, const std::string& message) {
    std::lock_guard lock(mutex);
    reports.insert(std::to_string(rank) + " " + message);
  };
  InProcessWorld world(2, 3, options);
  world.rank(1).onMessage(Channel::Test, [](int, Bytes) { throw Error("no such frame"); });
  world.rank(0).send(1, Channel::Test, {});
  world.rank(0).post([] { throw 5; });
  world.run();
  EXPECT_EQ(reports, (std::set<std::string>{"1 a message handler failed: no such frame",
                                            "0 a task failed with an exception that is no std::exception"}));
}

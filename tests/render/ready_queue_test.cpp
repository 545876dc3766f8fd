// SPDX-License-Identifier: Apache-2.0
#include "core/render/ready_queue.h"

#include <gtest/gtest.h>

#include <string>

namespace gxy {
namespace {

using namespace std::chrono_literals;

/// A queue whose tasks write what they are.
class Written {
 public:
  explicit Written(const ReadyQueue::Options& options = {}) : queue_(options) {}

  void push(const Priority& priority, char name, uint64_t frame = 1, bool first = false) {
    queue_.push(
        priority, frame, [this, name] { ran_ += name; }, first);
  }
  /// Runs the next, which takes so long; false where there is none.
  bool runOne(ReadyQueue::Time time = 1ms) {
    const ReadyQueue::Next next = queue_.pop();
    if (!next) return false;
    next.task();
    queue_.ran(next, time);
    return true;
  }
  const std::string& runAll() {
    while (runOne()) {
    }
    return ran_;
  }
  const std::string& ran() const { return ran_; }
  ReadyQueue& queue() { return queue_; }

 private:
  ReadyQueue queue_;
  std::string ran_;
};

/// Tiles of a frame that write its name; their rays end when the test gives the credits back.
struct NamedTiles : TileSource {
  NamedTiles(std::string& ran, char name, int tiles, int64_t credits)
      : written(ran), frame(name), left(tiles), each(credits) {}
  bool empty() const override { return left == 0; }
  int64_t cost() const override { return each; }
  std::function<void()> take() override {
    left--;
    return [&written = written, frame = frame] { written += frame; };  // the source may be gone by then
  }
  std::string& written;
  char frame;
  int left;
  int64_t each;
};

TEST(ReadyQueue, ServesWatchedTasksFirst) {
  Written w({1, 1s});
  for (int i = 0; i < 3; i++) w.push({1, false}, 'b');
  w.push({2, true}, 'I');
  EXPECT_EQ(w.runAll(), "Ibbb");
  EXPECT_FALSE(w.queue().ready());
}

TEST(ReadyQueue, ServesTenantsInTurnHoweverManyTasksTheyHave) {
  Written w;
  for (int i = 0; i < 6; i++) w.push({1, false}, 'a');
  for (int i = 0; i < 2; i++) w.push({2, false}, 'b');
  w.push({3, false}, 'c');
  EXPECT_EQ(w.runAll(), "abcabaaaa");
}

TEST(ReadyQueue, ServesTheStreamsOfATenantInTurn) {
  Written w;
  for (int i = 0; i < 4; i++) w.push({1, false, 1}, 'a');
  for (int i = 0; i < 2; i++) w.push({1, false, 2}, 'b');
  for (int i = 0; i < 6; i++) w.push({2, false, 1}, 'c');
  EXPECT_EQ(w.runAll(), "acbcacbcacac") << "half is the other tenant's";
}

TEST(ReadyQueue, SharesTimeAndNotTurns) {
  Written w;
  for (int i = 0; i < 1000; i++)
    for (const uint32_t tenant : {1, 2}) w.push({tenant, false}, char('0' + tenant));
  ReadyQueue::Time time[2]{};
  for (int i = 0; i < 400; i++) {
    const size_t before = w.ran().size();
    const ReadyQueue::Next next = w.queue().pop();
    next.task();
    const bool heavy = w.ran()[before] == '1';
    const ReadyQueue::Time took = heavy ? 5ms : 300us;
    time[!heavy] += took;
    w.queue().ran(next, took);
  }
  EXPECT_LE(std::chrono::abs(time[0] - time[1]), 5ms + 300us) << "a task of each";
}

TEST(ReadyQueue, TheRestOfATaskComesBeforeTheOthersOfItsFrame) {
  Written w;
  w.push({1, false}, 'n');
  w.push({1, false}, 'r', 1, true);
  w.push({2, false}, 'o');
  EXPECT_EQ(w.runAll(), "ron");
}

TEST(ReadyQueue, OfAStreamTheOldestFrameIsFirst) {
  Written w;
  for (const char name : std::string("cab")) w.push({1, false}, name, uint64_t(name));
  w.push({1, false}, 'A', 'a');
  EXPECT_EQ(w.runAll(), "aAbc");
}

TEST(ReadyQueue, WhoComesLateIsNextAndCatchesUpOnNothing) {
  Written w;
  for (int i = 0; i < 500; i++) w.push({1, false}, 'a');
  for (int i = 0; i < 100; i++) w.runOne();
  for (int i = 0; i < 50; i++) w.push({2, false}, 'b');
  for (int i = 0; i < 20; i++) w.runOne();
  const std::string then = w.ran().substr(100);
  EXPECT_EQ(then[0], 'b');
  EXPECT_EQ(std::count(then.begin(), then.end(), 'b'), 10) << "it had 100 ms less, when it wanted nothing";
}

TEST(ReadyQueue, WhoComesWhileAnothersTaskRunsDoesNotCatchUpEither) {
  Written w;
  for (int i = 0; i < 50; i++) w.push({1, false}, 'a');
  for (int i = 0; i < 49; i++) w.runOne();
  const ReadyQueue::Next last = w.queue().pop();
  for (int i = 0; i < 20; i++) w.push({2, false}, 'b');
  w.runOne();
  w.queue().ran(last, 1ms);
  for (int i = 0; i < 20; i++) w.push({1, false}, 'a');
  for (int i = 0; i < 10; i++) w.runOne();
  const std::string then = w.ran().substr(50);
  EXPECT_EQ(std::count(then.begin(), then.end(), 'a'), 5);
}

// A watched frame does not wait, but nobody is kept from working for ever by one who watches all the time.
TEST(ReadyQueue, WatchedTasksGetAheadByABoundedTime) {
  Written w({1, 100ms});
  for (int i = 0; i < 1000; i++) {
    w.push({1, false}, 'b');
    w.push({2, true}, 'W');
  }
  for (int i = 0; i < 300; i++) w.runOne();
  EXPECT_EQ(w.ran().substr(0, 100), std::string(100, 'W'));
  const std::string then = w.ran().substr(100);
  EXPECT_NEAR(double(std::count(then.begin(), then.end(), 'W')), 100, 1);
}

// Who begins to watch is ahead of a batch, and not of others who watch.
TEST(ReadyQueue, WatchersShareWhoeverCameFirst) {
  Written w({1, 1s});
  for (int i = 0; i < 500; i++) {
    w.push({1, false}, 'b');
    w.push({2, true}, 'W');
  }
  for (int i = 0; i < 200; i++) w.runOne();
  for (int i = 0; i < 500; i++) w.push({3, true}, 'V');
  for (int i = 0; i < 40; i++) w.runOne();
  const std::string then = w.ran().substr(200);
  EXPECT_EQ(then[0], 'V');
  EXPECT_NEAR(double(std::count(then.begin(), then.end(), 'W')), 20, 1);
  EXPECT_NEAR(double(std::count(then.begin(), then.end(), 'V')), 20, 1);
}

TEST(ReadyQueue, WhatWaitsOfAFrameIsNotWatchedAnyMoreOnceItIsNot) {
  Written w({1, 1s});
  w.push({1, true}, 'f');
  w.push({2, true}, 'W');
  w.push({2, true}, 'W');
  w.push({1, false}, 'f');
  EXPECT_EQ(w.runAll(), "WWff");
}

TEST(ReadyQueue, SpawnsTilesWhenNothingThatHasBegunWaitsAndWhileThereAreCredits) {
  Written w({640, 0s});
  std::string ran;
  w.queue().addTiles({1, false}, 1, std::make_shared<NamedTiles>(ran, 't', 1000, 1));
  w.queue().push({1, false}, 1, [&] { ran += 'o'; });
  w.queue().push(
      {1, false}, 1, [&] { ran += 'r'; }, true);
  w.runAll();
  const int64_t all = 490;  // 7/8 of 7/8 (Credits)
  EXPECT_EQ(ran, "r" + std::string(all, 't') + "o");
  EXPECT_EQ(w.queue().credits().out(), all);
  w.queue().giveBack({1, false}, 3);
  w.runAll();
  EXPECT_EQ(ran, "r" + std::string(all, 't') + "ottt");
}

TEST(ReadyQueue, OfAStreamTheTilesOfTheOldestFrameAreFirst) {
  Written w({1000, 0s});
  std::string ran;
  for (const char name : std::string("bac"))
    w.queue().addTiles({1, false}, uint64_t(name), std::make_shared<NamedTiles>(ran, name, 2, 1));
  w.runAll();
  EXPECT_EQ(ran, "aabbcc");
}

// One that has little out is not overtaken by those with more, however small their tiles are.
TEST(ReadyQueue, WhoWaitsForCreditsIsServedBeforeThoseWhoHaveMore) {
  Written w({1000, 0s});
  std::string ran;
  w.queue().addTiles({1, false}, 1, std::make_shared<NamedTiles>(ran, 's', 1000, 10));
  w.runAll();
  EXPECT_EQ(ran, std::string(76, 's')) << "49/64 of them (Credits)";
  w.queue().addTiles({2, false}, 2, std::make_shared<NamedTiles>(ran, 'L', 1, 500));
  w.runAll();
  EXPECT_EQ(ran, std::string(76, 's')) << "only 240 are free";
  for (int i = 0; i < 26; i++) {
    w.queue().giveBack({1, false}, 10);
    w.runAll();
  }
  EXPECT_EQ(ran, std::string(76, 's') + 'L');
}

TEST(ReadyQueue, ForgetsTilesThatAreDropped) {
  Written w({1000, 0s});
  std::string ran;
  w.queue().addTiles({1, false}, 1, std::make_shared<NamedTiles>(ran, 't', 3, 1));
  w.runOne();
  EXPECT_TRUE(w.queue().dropTiles({1, false}, 1));
  EXPECT_FALSE(w.queue().dropTiles({1, false}, 1));
  EXPECT_FALSE(w.queue().dropTiles({1, false}, 9));
  EXPECT_FALSE(w.runOne());
  EXPECT_EQ(ran, "t");
}

}  // namespace
}  // namespace gxy

// SPDX-License-Identifier: Apache-2.0
// Completion under seeded schedules; `--schedules N` sets how many (nightly: 100000).
#include "core/comm/completion.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <cstring>
#include <thread>

#include "core/comm/error.h"
#include "tests/comm/spawning_tree.h"

using namespace gxy;

namespace {

uint64_t schedules = 3000;

}  // namespace

TEST(Completion, IsNeverEarlyAndAlwaysReached) {
  for (uint64_t seed = 0; seed < schedules; ++seed) {
    const TreeOutcome outcome = SpawningTree(seed, {}).run();
    ASSERT_EQ(outcome.doneEarly, 0) << "seed " << seed;
    ASSERT_EQ(outcome.doneTwice, 0) << "seed " << seed;
    ASSERT_EQ(outcome.neverDone, 0) << "seed " << seed;
    ASSERT_EQ(outcome.setsKept, 0u) << "seed " << seed;
  }
}

/// Eight ranks in a ring, each with packets to send once around and room for one under way: the next starts
/// when the last has come home.
TEST(Completion, ARingWithABudgetOfOnePacketIsDone) {
  constexpr int ranks = 8, packets = 5;
  constexpr SetId set = 77;
  for (uint64_t seed = 0; seed < schedules; ++seed) {
    InProcessWorld world(ranks, seed);
    std::vector<std::unique_ptr<Completion>> completions;
    for (int r = 0; r < ranks; ++r) completions.push_back(std::make_unique<Completion>(world.rank(r)));
    int home = 0, homeWhenDone = -1;
    std::vector<int> sent(ranks);
    const auto launch = [&](int r) {
      completions[r]->created(set, 1);
      world.rank(r).send((r + 1) % ranks, Channel::Test, Writer().write(int32_t(r)).take());
      if (++sent[r] == packets) completions[r]->spawned(set);
    };
    for (int r = 0; r < ranks; ++r)
      world.rank(r).onMessage(Channel::Test, [&, r](int, Bytes message) {
        const Completion::Active active(*completions[r], set);
        const auto owner = Reader(message, "packet").read<int32_t>();
        if (owner != r) return world.rank(r).send((r + 1) % ranks, Channel::Test, std::move(message));
        ++home;
        if (sent[r] < packets) launch(r);
        completions[r]->retired(set, 1);
      });
    completions[0]->begin(set, [&] { homeWhenDone = home; });
    for (int r = 0; r < ranks; ++r) world.rank(r).post([&launch, r] { launch(r); });
    world.run();
    ASSERT_EQ(homeWhenDone, ranks * packets) << "seed " << seed;
  }
}

TEST(Completion, AnEmptySetIsDoneInTwoWaves) {
  for (int ranks = 1; ranks <= 8; ++ranks) {
    InProcessWorld world(ranks, 5);
    std::vector<std::unique_ptr<Completion>> completions;
    for (int r = 0; r < ranks; ++r) completions.push_back(std::make_unique<Completion>(world.rank(r)));
    bool done = false;
    completions[0]->begin(1, [&] { done = true; });
    for (int r = 0; r < ranks; ++r) completions[r]->spawned(1);
    world.run();
    EXPECT_TRUE(done);
    EXPECT_EQ(completions[0]->wavesStarted(), 2u);
  }
}

TEST(Completion, BeginsOnRankZeroAndOnce) {
  InProcessWorld world(2, 5);
  Completion zero(world.rank(0)), one(world.rank(1));
  EXPECT_THROW(one.begin(1, [] {}), Error);
  zero.begin(1, [] {});
  EXPECT_THROW(zero.begin(1, [] {}), Error);
}

TEST(Completion, HoldsWithRealThreads) {
  InProcessWorld::Options options;
  options.threaded = true;
  constexpr int ranks = 4, sets = 20, items = 30;
  InProcessWorld world(ranks, 11, options);
  std::vector<std::unique_ptr<Completion>> completions;
  for (int r = 0; r < ranks; ++r) completions.push_back(std::make_unique<Completion>(world.rank(r)));
  std::atomic<int> ended[sets] = {};
  int endedWhenDone[sets] = {};
  for (int r = 0; r < ranks; ++r)
    world.rank(r).onMessage(Channel::Test, [&, r](int, Bytes message) {
      Reader reader(message, "item");
      const auto set = reader.read<SetId>();
      const auto hops = reader.read<int32_t>();
      auto active = std::make_shared<Completion::Active>(*completions[r], set);
      world.rank(r).post([&, r, set, hops, active] {
        if (hops > 0) {
          completions[r]->created(set, 1);
          world.rank(r).send((r + hops) % ranks, Channel::Test, Writer().write(set).write(hops - 1).take());
        }
        ++ended[set];
        completions[r]->retired(set, 1);
      });
    });
  for (SetId set = 0; set < sets; ++set) {
    completions[0]->begin(set, [&, set] { endedWhenDone[set] = ended[set]; });
    for (int r = 0; r < ranks; ++r)
      world.rank(r).post([&, r, set] {
        for (int i = 0; i < items; ++i) {
          completions[r]->created(set, 1);
          world.rank(r).send(i % ranks, Channel::Test, Writer().write(set).write(int32_t(3)).take());
        }
        completions[r]->spawned(set);
      });
  }
  world.run();
  for (const int n : endedWhenDone) EXPECT_EQ(n, ranks * items * 4);
  for (const auto& completion : completions) EXPECT_EQ(completion->setsKept(), 0u);
}

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  if (argc == 3 && std::strcmp(argv[1], "--schedules") == 0) schedules = std::strtoull(argv[2], nullptr, 10);
  return RUN_ALL_TESTS();
}

// SPDX-License-Identifier: Apache-2.0
// Each clause of the completion rule is needed: without it some schedule fails.
#include <gtest/gtest.h>

#include "tests/comm/spawning_tree.h"

using namespace gxy;

namespace {

constexpr uint64_t seeds = 1000;

/// Schedules in which a set was reported done early.
int earlySchedules(TreeOptions options) {
  int early = 0;
  for (uint64_t seed = 0; seed < seeds; ++seed) early += SpawningTree(seed, options).run().doneEarly > 0;
  return early;
}

/// Waves that go round while rank 5 of 8 works on an item and everything else has ended.
uint64_t wavesWhileBusy(uint64_t seed, MutantCompletion::Rule rule) {
  constexpr int ranks = 8, busy = 5;
  InProcessWorld world(ranks, seed);
  std::vector<std::unique_ptr<MutantCompletion>> completions;
  for (int r = 0; r < ranks; ++r)
    completions.push_back(std::make_unique<MutantCompletion>(world.rank(r), rule));
  bool done = false;
  completions[0]->begin(1, [&] { done = true; });
  for (int r = 0; r < ranks; ++r) completions[r]->created(1, uint64_t(r == busy));
  auto active = std::make_unique<Completion::Active>(*completions[busy], 1);
  for (int r = 0; r < ranks; ++r) completions[r]->spawned(1);
  for (int i = 0; i < 5000; ++i) world.step();
  const uint64_t waves = completions[0]->wavesStarted();
  EXPECT_FALSE(done);
  completions[busy]->retired(1, 1);
  active.reset();
  world.run();
  EXPECT_TRUE(done);
  return waves;
}

}  // namespace

TEST(CompletionRule, ComparingTheSumsOfOneWaveIsCaught) {
  TreeOptions options;
  options.rule.comparesTwoWaves = false;
  EXPECT_GT(earlySchedules(options), 0);
}

TEST(CompletionRule, StartingWithoutTokensIsCaught) {
  TreeOptions options;
  options.rule.tokensAtRoot = false;
  EXPECT_GT(earlySchedules(options), 0);
}

TEST(CompletionRule, CountingChildrenAfterTheirParentRetiresIsCaught) {
  TreeOptions options;
  options.countsChildrenBeforeParentRetires = false;
  EXPECT_GT(earlySchedules(options), 0);
}

TEST(CompletionRule, CountingItemsAfterTheyAreSentIsCaught) {
  TreeOptions options;
  options.countsBeforeSending = false;
  EXPECT_GT(earlySchedules(options), 0);
}

TEST(CompletionRule, RetiringATokenBeforeAllIsSpawnedIsCaught) {
  TreeOptions options;
  options.retiresTokenAfterSpawning = false;
  EXPECT_GT(earlySchedules(options), 0);
}

TEST(CompletionRule, ABusyRankHoldsTheOneWave) {
  for (uint64_t seed = 0; seed < 200; ++seed) EXPECT_EQ(wavesWhileBusy(seed, {}), 1u) << "seed " << seed;
}

TEST(CompletionRule, AnsweringWhenBusyIsCaughtByItsWaves) {
  MutantCompletion::Rule rule;
  rule.answersWhenIdle = false;
  for (uint64_t seed = 0; seed < 20; ++seed) EXPECT_GT(wavesWhileBusy(seed, rule), 50u) << "seed " << seed;
}

TEST(CompletionRule, WithAllClausesTheSameSchedulesPass) { EXPECT_EQ(earlySchedules({}), 0); }

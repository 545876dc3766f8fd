// SPDX-License-Identifier: Apache-2.0
#include "core/comm/presence.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <memory>

#include "core/comm/in_process.h"

namespace gxy {
namespace {

using namespace std::chrono_literals;

/// AskedRanks of a seeded world, with a clock of their own.
struct AskedRanks {
  AskedRanks(int ranks, uint64_t seed) : world(ranks, seed), presence(size_t(ranks)) {}
  void join(int rank, const ProcessId& process = {}) {
    presence[size_t(rank)] =
        std::make_unique<Presence>(world.rank(rank), Presence::Options{[this] { return now; }, process});
  }
  void ask() {
    presence[0]->ask();
    world.run();
  }
  std::string missing() const { return textOf(presence[0]->missing(10s)); }

  Presence::Clock::time_point now{};
  InProcessWorld world;
  std::vector<std::unique_ptr<Presence>> presence;
};

TEST(Presence, ARankIsMissingFromWhenItsAnswerIsOutForAsLongAsIsSaid) {
  for (uint64_t seed = 0; seed < 20; seed++) {
    AskedRanks ranks(4, seed);
    for (int r : {0, 2}) ranks.join(r);  // to the others messages come, and nobody takes them
    ranks.ask();
    ranks.now += 9999ms;
    EXPECT_EQ(ranks.missing(), "");
    ranks.now += 1ms;
    EXPECT_EQ(ranks.missing(), "ranks 1 and 3 have not answered for 10 s");
    ranks.ask();
    ranks.now += 5s;
    EXPECT_EQ(ranks.missing(), "ranks 1 and 3 have not answered for 15 s") << "asked again or not";
    ranks.join(3);
    ranks.world.run();
    EXPECT_EQ(ranks.missing(), "rank 1 has not answered for 15 s");
    ranks.join(1);
    ranks.world.run();
    EXPECT_EQ(ranks.missing(), "");
    ranks.ask();
    ranks.now += 1h;
    EXPECT_EQ(ranks.missing(), "") << "those that have answered are not missed, however long ago that was";
  }
}

TEST(Presence, ASilentRankHasOneQuestionToAnswer) {
  AskedRanks ranks(2, 1);
  ranks.join(0);
  for (int i = 0; i < 100; i++) ranks.ask();
  EXPECT_EQ(ranks.world.rank(0).counters().messagesSent, 1u);
}

TEST(Presence, AProcessThatHasEndedIsKnownBeforeItsParentHasAskedForIt) {
  const pid_t child = fork();
  if (child == 0) {
    for (;;) pause();
  }
  ProcessId id = ProcessId::ofThis();
  id.number = child;
  AskedRanks ranks(3, 1);
  ranks.join(0);
  ranks.join(1, id);
  ranks.join(2, ProcessId::ofThis());
  ranks.ask();
  EXPECT_EQ(ranks.missing(), "");
  kill(child, SIGSTOP);
  EXPECT_EQ(ranks.missing(), "");
  kill(child, SIGKILL);
  siginfo_t ended{};
  ASSERT_EQ(waitid(P_PID, id_t(child), &ended, WEXITED | WNOWAIT), 0);
  EXPECT_EQ(ranks.missing(), "rank 1 has died");
  EXPECT_TRUE(ranks.presence[0]->died(1));
  EXPECT_FALSE(ranks.presence[0]->died(2));
  ranks.presence[0]->ask();
  ranks.presence[0]->answered(1h);  // it does not wait for the dead
  waitpid(child, nullptr, 0);
  EXPECT_EQ(ranks.missing(), "rank 1 has died");
}

TEST(Presence, OfAnotherMachineNothingIsKnown) {
  ProcessId id = ProcessId::ofThis();
  id.number = 1 << 30;  // nobody's here
  id.machine += "0";
  EXPECT_FALSE(WatchedProcess(id).ended());
}

}  // namespace
}  // namespace gxy

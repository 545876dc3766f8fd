// SPDX-License-Identifier: Apache-2.0
#include "core/comm/collective.h"

#include <gtest/gtest.h>

#include "core/comm/in_process.h"
#include "tests/comm/collective_checks.h"

using namespace gxy;

namespace {

/// Runs `perRank(collective, transport)` as a task that may wait, on each rank of a threaded world.
template <class PerRank>
void onAllRanks(int ranks, uint64_t seed, PerRank perRank) {
  InProcessWorld::Options options;
  options.threaded = true;
  InProcessWorld world(ranks, seed, options);
  std::vector<std::unique_ptr<Collective>> collectives;
  for (int r = 0; r < ranks; ++r) collectives.push_back(std::make_unique<Collective>(world.rank(r)));
  for (int r = 0; r < ranks; ++r)
    world.rank(r).postWaiting([&, r] { perRank(*collectives[r], world.rank(r)); });
  world.run();
}

}  // namespace

TEST(Collective, EachOneBringsWhatWasGiven) {
  for (int ranks = 1; ranks <= 8; ++ranks)
    onAllRanks(ranks, uint64_t(ranks), [](Collective& collective, Transport& transport) {
      for (uint64_t key = 0; key < 20; ++key) checkCollectives(collective, transport, key);
    });
}

TEST(Collective, RequestsInAnyOrderOnEachRankNeitherMixNorDeadlock) {
  constexpr int requests = 12;
  for (uint64_t seed = 0; seed < 20; ++seed)
    onAllRanks(4, seed, [](Collective& collective, Transport& transport) {
      for (uint64_t i = 0; i < requests; ++i)
        transport.postWaiting([&collective, &transport, i] {
          const uint64_t key = (i * 5 + uint64_t(transport.rank()) * 7) % requests;
          checkCollectives(collective, transport, key);
        });
    });
}

TEST(Collective, AnErrorOnOneRankIsThrownOnAll) {
  onAllRanks(4, 1,
             [](Collective& collective, Transport& transport) { checkAgreement(collective, transport, 9); });
}

TEST(Collective, AllToAllWantsOneEntryPerRank) {
  InProcessWorld world(2, 1);
  Collective collective(world.rank(0));
  EXPECT_THROW(collective.allToAll(1, std::vector<Bytes>(3)), Error);
}

TEST(Collective, MalformedMessagesAreErrors) {
  InProcessWorld world(2, 1);
  Collective collective(world.rank(0));
  Random random(3);
  int refused = 0;
  for (int i = 0; i < 2000; ++i) {
    Bytes message(random.below(60));
    for (auto& byte : message) byte = std::byte(random.next() & random.next());
    world.rank(1).send(0, Channel::Collective, std::move(message));
    try {
      world.run();
    } catch (const Error&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 1900);
}

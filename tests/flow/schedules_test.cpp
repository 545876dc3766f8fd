// SPDX-License-Identifier: Apache-2.0
// A graph and its host with every order of events that a seed draws: edits, steps of several publishers, drops and imports under the
// same name, failures, cancels, evictions, adoptions granted and refused, views shown and hidden. world.h says what is checked.
#include <gtest/gtest.h>

#include "tests/flow/world.h"
#include "tests/support/seeds.h"

namespace gxy::test {
namespace {

void add(World::Counters& sum, const World::Counters& more) {
  sum.evaluations += more.evaluations;
  sum.shown += more.shown;
  sum.cancelled += more.cancelled;
  sum.failed += more.failed;
  sum.adopted += more.adopted;
  sum.refused += more.refused;
  sum.held += more.held;
  sum.lost += more.lost;
  sum.evicted += more.evicted;
  sum.leftOut += more.leftOut;
  sum.missing += more.missing;
}

TEST(Schedules, EveryViewEndsWithTheNewestDocumentAndTheNewestStepAndNothingElseIsHeld) {
  World::Counters sum;
  const int many = seeds(1500);
  for (int seed = 1; seed <= many; seed++) {
    World world{uint64_t(seed)};
    for (int part = 0; part < 3; part++) {
      world.run(60);
      world.rest();
    }
    world.leave();
    for (const std::string& error : world.errors) ADD_FAILURE() << "seed " << seed << ": " << error;
    if (HasFailure()) return;
    add(sum, world.counters);
  }
  // What is to be tested did happen.
  for (const int64_t count : {sum.evaluations, sum.shown, sum.cancelled, sum.failed, sum.adopted, sum.refused,
                              sum.held, sum.lost, sum.evicted, sum.leftOut, sum.missing})
    EXPECT_GT(count, many / 20);
}

}  // namespace
}  // namespace gxy::test

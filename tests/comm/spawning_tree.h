// SPDX-License-Identifier: Apache-2.0
// A random program for completion: items that spawn items, over all ranks, in several sets at once.
#pragma once
#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <vector>

#include "core/comm/completion.h"
#include "core/comm/in_process.h"
#include "core/comm/random.h"
#include "core/comm/wire.h"

namespace gxy {

/// Completion with clauses of its rule dropped.
class MutantCompletion : public Completion {
 public:
  using Completion::Rule;
  MutantCompletion(Transport& transport, Rule rule) : Completion(transport, rule) {}
};

/// What the program gets wrong on purpose.
struct TreeOptions {
  MutantCompletion::Rule rule = {};
  bool countsChildrenBeforeParentRetires = true;
  bool countsBeforeSending = true;
  bool retiresTokenAfterSpawning = true;
};

/// What was seen of one schedule.
struct TreeOutcome {
  int sets = 0;
  int doneEarly = 0;  ///< sets reported done while items were alive or ranks had still to spawn
  int doneTwice = 0;
  int neverDone = 0;    ///< when nothing was left to happen
  size_t setsKept = 0;  ///< counters left on all ranks, after all sets were done
};

/// Runs one schedule: 1 to 8 ranks, 1 to 4 sets. Each rank hears of a set by a message of its own, spawns a
/// few items in random portions, and each item ends or spawns up to three on random ranks, `depth`
/// generations at most.
class SpawningTree {
 public:
  SpawningTree(uint64_t seed, TreeOptions options) : random_(~seed), options_(options) {
    ranks_ = 1 + int(random_.below(8));
    world_ = std::make_unique<InProcessWorld>(ranks_, seed);
    for (int r = 0; r < ranks_; ++r) {
      completions_.push_back(std::make_unique<MutantCompletion>(world_->rank(r), options.rule));
      world_->rank(r).onMessage(Channel::Test, [this, r](int, Bytes message) { receive(r, message); });
    }
  }

  TreeOutcome run() {
    TreeOutcome outcome;
    outcome.sets = 1 + int(random_.below(4));
    for (SetId set = 0; set < SetId(outcome.sets); ++set) {
      Truth& truth = truth_[set];
      truth.ranksToSpawn = ranks_;
      completions_[0]->begin(set, [&truth, &outcome] {
        outcome.doneTwice += truth.done;
        outcome.doneEarly += !truth.done && (truth.alive > 0 || truth.ranksToSpawn > 0);
        truth.done = true;
      });
      for (int r = 0; r < ranks_; ++r)
        world_->rank(0).send(r, Channel::Test, Writer().write(set).write(start).take());
    }
    for (uint64_t step = 0; step < maxSteps && world_->step(); ++step) {
    }
    for (const auto& [set, truth] : truth_) outcome.neverDone += !truth.done;
    for (const auto& completion : completions_) outcome.setsKept += completion->setsKept();
    return outcome;
  }

 private:
  static constexpr int32_t start = -1;
  static constexpr int32_t depth = 4;
  static constexpr uint64_t maxSteps = 2'000'000;

  struct Truth {
    int64_t alive = 0;  ///< items made and not ended, known as no real program could
    int ranksToSpawn = 0;
    bool done = false;
  };

  void receive(int r, const Bytes& message) {
    Reader reader(message, "tree");
    const auto set = reader.read<SetId>();
    const auto generation = reader.read<int32_t>();
    if (generation == start) {
      if (!options_.retiresTokenAfterSpawning) completions_[r]->spawned(set);
      return spawn(r, set, int(random_.below(4)));
    }
    auto active = std::make_shared<Completion::Active>(*completions_[r], set);
    if (random_.oneIn(3))
      act(r, set, generation);
    else
      world_->rank(r).post([this, r, set, generation, active] { act(r, set, generation); });
  }

  /// Makes one item and comes back later for the rest, as a throttled rank does.
  void spawn(int r, SetId set, int rest) {
    if (rest == 0) {
      --truth_[set].ranksToSpawn;
      if (options_.retiresTokenAfterSpawning) completions_[r]->spawned(set);
      return;
    }
    make(r, set, 0);
    world_->rank(r).post([this, r, set, rest] { spawn(r, set, rest - 1); });
  }

  void make(int r, SetId set, int32_t generation) {
    if (!options_.countsBeforeSending) return makeAndCountLater(r, set, generation);
    completions_[r]->created(set, 1);
    sendItem(r, set, generation);
  }

  void makeAndCountLater(int r, SetId set, int32_t generation) {
    sendItem(r, set, generation);
    world_->rank(r).post([this, r, set] { completions_[r]->created(set, 1); });
  }

  void sendItem(int r, SetId set, int32_t generation) {
    ++truth_[set].alive;
    world_->rank(r).send(int(random_.below(uint64_t(ranks_))), Channel::Test,
                         Writer().write(set).write(generation).take());
  }

  void act(int r, SetId set, int32_t generation) {
    const int children = generation < depth ? int(random_.below(4)) - 1 : 0;
    for (int i = 0; i < children; ++i) {
      if (options_.countsChildrenBeforeParentRetires)
        make(r, set, generation + 1);
      else
        makeAndCountLater(r, set, generation + 1);
    }
    --truth_[set].alive;
    completions_[r]->retired(set, 1);
  }

  Random random_;
  TreeOptions options_;
  int ranks_;
  std::unique_ptr<InProcessWorld> world_;
  std::map<SetId, Truth> truth_;
  std::vector<std::unique_ptr<MutantCompletion>> completions_;
};

}  // namespace gxy

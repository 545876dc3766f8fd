// SPDX-License-Identifier: Apache-2.0
// What belongs to one step of a simulation is seen together, whatever comes in between.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/comm/error.h"
#include "core/comm/random.h"
#include "core/space/directory.h"
#include "core/space/objects.h"
#include "tests/support/seeds.h"

namespace gxy {
namespace {

const std::string kTenant = "ann";
const std::vector<std::string> kNames{"density", "pressure", "velocity"};
constexpr int kRanks = 3;

/// The objects of all ranks, and rank 0's names. The data of an object are the number of the step that they are of.
struct World {
  struct Rank {
    Observers observers;
    Objects objects{observers};
  };
  std::array<Rank, kRanks> ranks;
  Directory directory;
  KeySource keys{0};
  std::set<Key> dropped;

  World() {
    for (const std::string& name : kNames) {
      const Key key = keys.next();
      for (Rank& rank : ranks) rank.objects.add(key, makePayload<int>(1));
      directory.bind(name, Scope::Private, {key, "Volume", kTenant});
    }
  }
  Objects& objects(int rank) { return ranks[size_t(rank)].objects; }
  Objects& objects() { return objects(0); }
};

/// What rank 0 does to show a scene of all names: one call.
std::vector<Pin> pinAll(const Objects& objects, const Directory& directory,
                        std::vector<ObjectGeneration>& generations) {
  std::vector<Key> keys;
  std::vector<Pin> pins = objects.pin([&] {
    for (const auto& found : directory.find(kTenant, kNames)) keys.push_back(found.value().entry.key);
    return keys;
  });
  for (size_t i = 0; i < pins.size(); i++) generations.push_back({keys[i], pins[i].generation()});
  return pins;
}

bool areOfOneStep(const std::vector<Pin>& pins) {
  return std::all_of(pins.begin(), pins.end(),
                     [&](const Pin& pin) { return *pin.get<int>() == *pins.front().get<int>(); });
}

/// Publishes one step after the other, one call of one rank a turn: reserves on rank 0, then on the others, stages, commits on
/// the others, then on rank 0. Sometimes an object of a step is a new one that takes over the name.
class Publisher {
 public:
  Publisher(World& world, uint64_t seed) : world_(world), random_(seed) { begin(); }

  int steps() const { return step_ - 1; }

  void turn() {
    const size_t item = turn_ % kNames.size();
    const auto rank = int(turn_ / kNames.size());
    if (turn_ < kNames.size() * kRanks) {
      reserve(rank, item);
    } else if (turn_ < 2 * kNames.size() * kRanks) {
      stage(rank - kRanks, item);
    } else {
      const auto committed = int(turn_ - 2 * kNames.size() * kRanks);
      commit((committed + 1) % kRanks);
    }
  }

 private:
  void begin() {
    turn_ = 0;
    step_++;
    items_.clear();
    for (const std::string& name : kNames) {
      const Key old = world_.directory.get(kTenant, name).key;
      if (random_.oneIn(6))
        items_.push_back({world_.keys.next(), 1});
      else
        items_.push_back({old, world_.objects().pin(old).generation() + 1});
    }
  }

  void reserve(int rank, size_t item) {
    Objects& objects = world_.objects(rank);
    const auto& [key, generation] = items_[item];
    turn_++;
    if (generation == 1 || objects.reserve(key)) return;
    EXPECT_EQ(rank, 0) << "what rank 0 has room for, all have";
    for (size_t i = 0; i < item; i++)
      if (items_[i].generation > 1) objects.abandon(items_[i].key);
    step_--;
    begin();
  }

  void stage(int rank, size_t item) {
    Objects& objects = world_.objects(rank);
    const auto& [key, generation] = items_[item];
    turn_++;
    generation == 1 ? objects.add(key, makePayload<int>(step_)) : objects.stage(key, makePayload<int>(step_));
  }

  void commit(int rank) {
    turn_++;
    std::vector<ObjectGeneration> next;
    for (const ObjectGeneration& item : items_)
      if (item.generation > 1) next.push_back(item);
    if (rank != 0) return world_.objects(rank).commit(next);
    std::vector<Key> replaced;
    world_.objects().commit(next, [&] {
      for (size_t i = 0; i < kNames.size(); i++)
        if (items_[i].generation == 1)
          replaced.push_back(
              world_.directory.bind(kNames[i], Scope::Private, {items_[i].key, "Volume", kTenant})->key);
    });
    for (const Key key : replaced) {
      for (World::Rank& each : world_.ranks) each.objects.drop(key);
      world_.dropped.insert(key);
    }
    begin();
  }

  World& world_;
  Random random_;
  std::vector<ObjectGeneration> items_;
  size_t turn_ = 0;
  int step_ = 1;
};

/// Looks at all names on rank 0, then, while it holds what it saw there, at the same generations on another rank.
class Reader {
 public:
  Reader(World& world, uint64_t seed) : world_(world), random_(seed) {}

  int looks = 0, looksElsewhere = 0;

  void turn() {
    if (pins_.empty()) {
      generations_.clear();
      pins_ = pinAll(world_.objects(), world_.directory, generations_);
      EXPECT_TRUE(areOfOneStep(pins_));
      looks++;
    } else if (random_.oneIn(4)) {
      pins_.clear();
    } else {
      lookElsewhere(1 + int(random_.below(kRanks - 1)));
    }
  }

 private:
  void lookElsewhere(int rank) {
    const bool anyDropped = std::any_of(generations_.begin(), generations_.end(),
                                        [&](const auto& g) { return world_.dropped.count(g.key) > 0; });
    if (anyDropped) {
      EXPECT_THROW(world_.objects(rank).pin(generations_), Error);
      return;
    }
    const std::vector<Pin> there = world_.objects(rank).pin(generations_);
    for (size_t i = 0; i < there.size(); i++) EXPECT_EQ(*there[i].get<int>(), *pins_[i].get<int>());
    looksElsewhere++;
  }

  World& world_;
  Random random_;
  std::vector<ObjectGeneration> generations_;
  std::vector<Pin> pins_;
};

TEST(Steps, AreNeverSeenMixedOnAnyRankWhateverTheOrderOfCalls) {
  int steps = 0, looks = 0, looksElsewhere = 0;
  for (uint64_t seed = 1; seed <= uint64_t(test::seeds(100)); seed++) {
    World world;
    Random random(seed);
    Publisher publisher(world, seed + 1000000);
    std::vector<Reader> readers;
    for (uint64_t i = 0; i < 2; i++) readers.emplace_back(world, seed + 2000000 * (i + 1));
    const auto told = world.ranks[0].observers.subscribe({}, [&](const ObjectEvent& event) {
      std::vector<ObjectGeneration> generations;
      if (event.kind != ObjectEvent::Kind::Updated) return;
      EXPECT_TRUE(areOfOneStep(pinAll(world.objects(), world.directory, generations)));
    });
    for (int turn = 0; turn < 600 && !HasFailure(); turn++) {
      const uint64_t who = random.below(8);
      who < readers.size() ? readers[who].turn() : publisher.turn();
    }
    ASSERT_FALSE(HasFailure()) << "seed " << seed;
    steps += publisher.steps();
    for (const Reader& reader : readers) looks += reader.looks, looksElsewhere += reader.looksElsewhere;
  }
  EXPECT_GT(steps, test::seeds(100));
  EXPECT_GT(looks, test::seeds(100));
  EXPECT_GT(looksElsewhere, test::seeds(100));
}

TEST(Steps, AreNeverSeenMixedUnderThreads) {
  World world;
  std::atomic<bool> done = false;
  std::atomic<int> looks = 0, mixed = 0;
  std::vector<std::thread> readers;
  for (int t = 0; t < 2; t++)
    readers.emplace_back([&] {
      while (!done) {
        std::vector<ObjectGeneration> generations;
        if (!areOfOneStep(pinAll(world.objects(), world.directory, generations))) mixed++;
        looks++;
      }
    });
  Publisher publisher(world, 1);
  while (publisher.steps() < 100 || looks < 1000) publisher.turn();
  done = true;
  for (std::thread& reader : readers) reader.join();
  EXPECT_EQ(mixed, 0);
}

TEST(Steps, ACommitOfSeveralThatFailsChangesNothing) {
  World world;
  Objects& objects = world.objects();
  const Key a = world.directory.get(kTenant, "density").key, b = world.directory.get(kTenant, "pressure").key;
  ASSERT_TRUE(objects.reserve(a) && objects.reserve(b));
  objects.stage(a, makePayload<int>(2));
  const std::vector<ObjectGeneration> both{{a, 2}, {b, 2}};
  EXPECT_THROW(objects.commit(both), Error) << "of one nothing is staged";
  EXPECT_EQ(objects.pin(a).generation(), 1u);
  objects.stage(b, makePayload<int>(2));
  EXPECT_THROW(objects.commit(both, [] { throw Error("a name is taken"); }), Error);
  EXPECT_EQ(objects.pin(a).generation(), 1u);
  EXPECT_THROW(objects.commit(std::vector<ObjectGeneration>{{a, 2}, {a, 3}}), Error);
  objects.commit(both);
  EXPECT_EQ(objects.pin(a).generation(), 2u);
  EXPECT_EQ(objects.pin(b).generation(), 2u);
}

TEST(Steps, ACommitOfSeveralLeavesOutWhatHasBeenDropped) {
  World world;
  Objects& objects = world.objects();
  const Key a = world.directory.get(kTenant, "density").key, b = world.directory.get(kTenant, "pressure").key;
  ASSERT_TRUE(objects.reserve(a) && objects.reserve(b));
  objects.stage(a, makePayload<int>(2));
  objects.stage(b, makePayload<int>(2));
  objects.drop(a);
  objects.commit(std::vector<ObjectGeneration>{{a, 2}, {b, 2}});
  EXPECT_FALSE(objects.contains(a));
  EXPECT_EQ(objects.pin(b).generation(), 2u);
}

TEST(Steps, WhereOneOfSeveralIsMissingNoneIsPinned) {
  World world;
  Objects& objects = world.objects();
  const Key a = world.directory.get(kTenant, "density").key;
  const std::vector<ObjectGeneration> gone{{a, 1}, {Key{77}, 1}};
  EXPECT_THROW(objects.pin(gone), Error);
  EXPECT_THROW(objects.pin([&] { return std::vector<Key>{a, Key{77}}; }), Error);
  for (Generation g = 2; g < 4; g++) {  // nobody holds generation 1
    ASSERT_TRUE(objects.reserve(a));
    objects.stage(a, makePayload<int>(int(g)));
    objects.commit(a, g);
  }
}

}  // namespace
}  // namespace gxy

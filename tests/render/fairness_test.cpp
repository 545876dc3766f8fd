// SPDX-License-Identifier: Apache-2.0
// Whose packets are traced while a frame that somebody watches waits: counted, in worlds whose schedule a seed decides.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <future>
#include <mutex>
#include <string>
#include <thread>

#include "core/comm/random.h"
#include "tests/support/frames.h"
#include "tests/support/observed_backend.h"
#include "tests/support/seeds.h"

namespace gxy::test {
namespace {

constexpr int kSlabs = 3, kBatch = sweep(500), kInFlight = 8;
constexpr glm::ivec2 kBatchSize{40, 33}, kWatchedSize{20, 16};

/// What is counted of one rank.
struct Counts {
  int64_t packets = 0;        ///< of the batch, traced so far
  int64_t whenKnown = 0;      ///< of them, before the watched frame became known here
  bool waits = false;         ///< it is known, and nothing of it has been done
  int64_t mostWaitedFor = 0;  ///< of the batch's packets, by any watched frame
  int64_t watchedFrames = 0;  ///< that had something to do here

  void watchedBegins() {
    if (!std::exchange(waits, false)) return;
    mostWaitedFor = std::max(mostWaitedFor, packets - whenKnown);
    watchedFrames++;
  }
};

// Frames are told apart by their size.
Observer countingInto(Counts& counts) {
  Observer observer;
  observer.known = [&counts](glm::ivec2 size) {
    if (size != kWatchedSize) return;
    counts.waits = true;
    counts.whenKnown = counts.packets;
  };
  observer.begins = [&counts](glm::ivec2 size, int rays) {
    if (size == kWatchedSize)
      counts.watchedBegins();
    else
      counts.packets += rays > 0;
  };
  return observer;
}

TestScene balls(glm::ivec2 size) {
  TestScene scene = emptyScene("balls", size);
  addParticles(scene, 1);
  addLights(scene);
  return scene;
}

FrameRun inSmallPackets(uint64_t seed) {
  FrameRun run;
  run.seed = seed;
  run.options.packetRays = 64;
  return run;
}

// Two tenants: one has a batch of many frames, 8 in flight, the other looks at a frame now and then.
TEST(Fairness, AWatchedFrameWaitsForAtMostTwoPacketsOfABatchOnEachRank) {
  std::array<Counts, kSlabs> counts;
  std::vector<Observer> observers;
  for (Counts& c : counts) observers.push_back(countingInto(c));
  std::vector<std::unique_ptr<ObservedBackend>> backends;
  for (const Observer& o : observers) backends.push_back(std::make_unique<ObservedBackend>(o));
  TestScene scene = balls(kBatchSize);
  addMesh(scene, 1);
  const Cut cut = lattice(sceneDomain(), {3, 1, 1}, kSlabs);
  FrameRun run = inSmallPackets(7);
  run.options.raysInFlight = 40000;
  run.options.runners = 1;
  Frames frames(kSlabs, run);
  frames.add(1, compiledOn(cut, scene, [&](int rank) -> const Backend& { return *backends[size_t(rank)]; }));

  FrameRequest batch, watched;
  batch.scene = watched.scene = 1;
  batch.camera = watched.camera = scene.camera;
  batch.priority = {1, false};
  watched.priority = {2, true};
  watched.camera.dimensions = kWatchedSize;
  std::vector<FrameId> ids, watchedIds;
  const auto ended = [&](FrameId id) { return frames.outcome(id).finished > 0; };
  Random random(3);
  size_t done = 0;
  int64_t mostInAStep = 0;
  uint64_t untilNext = 1000;
  do {
    while (ids.size() < kBatch && ids.size() < done + kInFlight) ids.push_back(frames.start(batch));
    while (done < ids.size() && ended(ids[done])) done++;
    if (--untilNext == 0) {
      if (watchedIds.empty() || ended(watchedIds.back())) watchedIds.push_back(frames.start(watched));
      untilNext = 1 + random.below(2000);
    }
    int64_t before = 0, after = 0;
    for (const Counts& c : counts) before += c.packets;
    if (!frames.world().step()) break;
    for (const Counts& c : counts) after += c.packets;
    mostInAStep = std::max(mostInAStep, after - before);
  } while (done < kBatch);
  frames.run();

  EXPECT_TRUE(frames.errors().empty());
  EXPECT_EQ(done, size_t(kBatch));
  EXPECT_GT(watchedIds.size(), size_t(sweep(20)));
  EXPECT_EQ(mostInAStep, 1) << "a task goes on with the next packet by itself";
  for (const Counts& c : counts) {
    EXPECT_GT(c.packets, 10 * kBatch);
    EXPECT_GT(c.watchedFrames, sweep(20));
    EXPECT_LE(c.mostWaitedFor, 2);
  }
}

// A watched frame of many rays goes first until its time is up, and then takes turns with a batch.
TEST(Fairness, AFrameThatTakesLongIsNoLongerBeforeAllOthers) {
  const TestScene scene = balls({64, 64});
  const Cut cut = lattice(sceneDomain(), {1, 1, 1}, 1);
  FrameRequest large, small;
  large.scene = small.scene = 1;
  large.camera = small.camera = scene.camera;
  large.priority = {1, true};
  small.priority = {2, false};
  large.samples = 20;
  const auto largeIsFirst = [&](std::chrono::nanoseconds urgentWork) {
    FrameRun run = inSmallPackets(5);
    run.options.runners = 1;
    run.options.raysInFlight = 40000;
    run.options.urgentWork = urgentWork;
    Frames frames(1, run);
    frames.add(1, compiledOn(cut, scene));
    const FrameId watched = frames.start(large), other = frames.start(small);
    while (frames.outcome(watched).finished == 0 && frames.outcome(other).finished == 0)
      if (!frames.world().step()) break;
    const bool first = frames.outcome(watched).finished > 0;
    frames.run();
    EXPECT_EQ(frames.outcome(watched).finished + frames.outcome(other).finished, 2);
    return first;
  };
  EXPECT_TRUE(largeIsFirst(std::chrono::hours(1)));
  EXPECT_FALSE(largeIsFirst(std::chrono::nanoseconds(1)));
}

// However many frames one has, on each rank there is room for others, and they go on.
TEST(Fairness, ATenantsRaysLeaveRoomForOthers) {
  constexpr int64_t kAll = 200000;
  const TestScene scene = balls({64, 64});
  const Cut cut = lattice(sceneDomain(), {3, 1, 1}, kSlabs);
  FrameRun run = inSmallPackets(11);
  run.options.raysInFlight = kAll;
  Frames frames(kSlabs, run);
  frames.add(1, compiledOn(cut, scene));
  FrameRequest request;
  request.scene = 1;
  request.camera = scene.camera;
  std::vector<FrameId> ids;
  for (int i = 0; i < 40; i++) {
    request.priority.tenant = i < 38 ? 1 : 2;
    ids.push_back(frames.start(request));
  }
  std::map<uint32_t, int64_t> most;
  while (frames.world().step())
    for (int rank = 0; rank < kSlabs; rank++)
      for (const auto& [tenant, credits] : frames.renderer(rank).kept().tenantCredits)
        most[tenant] = std::max(most[tenant], credits);
  for (const FrameId id : ids) EXPECT_EQ(frames.outcome(id).finished, 1);
  EXPECT_LE(most.at(1), kAll * 7 / 8);
  EXPECT_GT(most.at(2), 0);
}

// Encoding takes long, and anybody may have many pictures to be encoded.
TEST(Fairness, PicturesThatNobodyWatchesAreHandedOutOneByOneInTurnByThreadsOfLowPriority) {
  const TestScene scene = balls(kWatchedSize);
  const Cut cut = whole(scene.domain);
  FrameRun run;
  run.threaded = true;
  run.options.handOuts = 1;
  Frames frames(1, run);
  frames.add(1, compiledOn(cut, scene));
  std::mutex mutex;
  std::string order;
  int atOnce = 0, mostAtOnce = 0, least = 19;
  std::promise<void> begun, goOn, watchedDone;
  frames.renderer(0).onPicture(
      [&, released = goOn.get_future().share()](FrameId, const FrameRequest& request, Picture) {
        if (request.priority.interactive) return watchedDone.set_value();
        bool first;
        {
          const std::lock_guard lock(mutex);
          first = order.empty();
          order += char('a' + request.priority.tenant);
          mostAtOnce = std::max(mostAtOnce, ++atOnce);
          least = std::min(least, getpriority(PRIO_PROCESS, 0));
        }
        if (first) begun.set_value();
        released.wait();
        const std::lock_guard lock(mutex);
        atOnce--;
      });
  FrameRequest request = requestOf(scene);
  const auto start = [&](uint32_t tenant) {
    request.priority = {tenant, false};
    frames.start(request);
  };
  start(0);
  begun.get_future().wait();
  for (const uint32_t tenant : {0, 0, 0, 1, 2}) start(tenant);
  const auto allAreRendered = [&] {
    const Renderer::ResourceCounts kept = frames.renderer(0).kept();
    return kept.frames == 0 && kept.tasks == 5;
  };
  while (!allAreRendered()) std::this_thread::yield();
  request.priority = {3, true};
  frames.start(request);
  watchedDone.get_future().wait();  // it waits for none of them
  goOn.set_value();
  frames.run();
  EXPECT_EQ(order.substr(0, 1), "a");
  std::string turn = order.substr(1, 2);
  std::sort(turn.begin(), turn.end());
  EXPECT_EQ(turn, "bc") << "of each other tenant one, before the next of this one";
  EXPECT_EQ(order.substr(3), "aaa");
  EXPECT_EQ(mostAtOnce, 1);
  if (const int own = getpriority(PRIO_PROCESS, 0); own < 19) {
    EXPECT_GT(least, own);
  }
}

}  // namespace
}  // namespace gxy::test

// SPDX-License-Identifier: Apache-2.0
// Devices that answer later, from a thread of their own, and devices that fail.
#include <gtest/gtest.h>

#include <condition_variable>
#include <deque>
#include <thread>

#include "backends/embree/embree_backend.h"
#include "core/comm/error.h"
#include "tests/support/frames.h"

namespace gxy::test {
namespace {

/// Runs what it is given, on one thread, later.
class LaterThread {
 public:
  LaterThread() : thread_([this] { work(); }) {}
  ~LaterThread() {
    add({});
    thread_.join();
  }
  void add(std::function<void()> task) {
    std::lock_guard lock(mutex_);
    tasks_.push_back(std::move(task));
    changed_.notify_one();
  }

 private:
  void work() {
    for (;;) {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [this] { return !tasks_.empty(); });
      const auto task = std::move(tasks_.front());
      tasks_.pop_front();
      lock.unlock();
      if (!task) return;
      task();
    }
  }
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::function<void()>> tasks_;
  std::thread thread_;
};

struct Faults {
  bool frame = false, memory = false, spawn = false, throws = false;
  int64_t traces = -1;  ///< fail from that many calls on; -1: never
};

/// Another scene, asked later, and failing at times.
class OddScene final : public DeviceScene {
 public:
  OddScene(std::shared_ptr<const DeviceScene> scene, Faults faults, bool later)
      : scene_(std::move(scene)),
        faults_(faults),
        later_(later ? std::make_unique<LaterThread>() : nullptr) {}
  std::shared_ptr<const DeviceFrame> makeFrame(const CompiledFrame& frame) const override {
    if (faults_.frame) throw Error("no room for a frame");
    if (faults_.memory) throw std::bad_alloc();
    return scene_->makeFrame(frame);
  }
  void spawn(const DeviceFrame& frame, const SpawnTile& tile, Done done) const override {
    run([this, &frame, tile, done] {
      if (faults_.spawn) return fail(0, done);
      scene_->spawn(frame, tile, done);
    });
  }
  void trace(const DeviceFrame& frame, int partition, bool primary, RayList rays, Done done) const override {
    const auto held = std::make_shared<RayList>(std::move(rays));
    const bool fails = faults_.traces >= 0 && calls_++ >= faults_.traces;
    if (fails && faults_.throws) throw Error("the device is gone");
    run([this, &frame, partition, primary, held, done, fails] {
      if (fails) return fail(uint64_t(held->size()), done);
      scene_->trace(frame, partition, primary, std::move(*held), done);
    });
  }
  size_t bytes() const override { return scene_->bytes(); }

 private:
  void run(std::function<void()> task) const {
    if (later_)
      later_->add(std::move(task));
    else
      task();
  }
  static void fail(uint64_t rays, const Done& done) {
    TraceResult result;
    result.retired = rays;
    result.error = "the device is gone";
    done(std::move(result));
  }
  const std::shared_ptr<const DeviceScene> scene_;
  const Faults faults_;
  mutable std::atomic<int64_t> calls_ = 0;
  const std::unique_ptr<LaterThread> later_;
};

const TestScene kScene = everything({24, 20});
const int kRanks = 3;

std::vector<RankScene> oddly(const Cut& cut, bool later, int faultyRank = -1, Faults faults = {}) {
  std::vector<RankScene> scenes = compiledOn(cut, kScene);
  for (int r = 0; r < cut.ranks; r++)
    scenes[size_t(r)].device =
        std::make_shared<OddScene>(scenes[size_t(r)].device, r == faultyRank ? faults : Faults{}, later);
  return scenes;
}

TEST(LateDevice, GivesTheSamePicture) {
  const Cut cut = kdCut(kScene.domain, 6, kRanks, 5);
  const Picture expected = wholeOnEmbree(kScene);
  for (bool threaded : {false, true})
    for (uint64_t seed = 1; seed <= 4; seed++) {
      FrameRun run;
      run.seed = seed;
      run.threaded = threaded;
      run.options.packetRays = 64;
      EXPECT_EQ(difference(expected, render(kScene, kRanks, oddly(cut, true), run)), "");
    }
}

TEST(LateDevice, IsWaitedForWhenARendererGoes) {
  const Cut cut = kdCut(kScene.domain, 6, kRanks, 5);
  FrameRun run;
  run.threaded = true;
  for (int i = 0; i < 10; i++) {
    const auto scenes = oddly(cut, true);
    Frames frames(kRanks, run);
    frames.add(1, scenes);
    frames.start(requestOf(kScene));
  }
}

/// The frame of a rank that fails ends with its error, everything is given back, and a scene that works is rendered after.
void expectOnlyThatFrameFails(const Faults& faults, const std::string& error, bool later) {
  const Cut cut = kdCut(kScene.domain, 6, kRanks, 5);
  const Picture expected = wholeOnEmbree(kScene);
  const int faulty = 2;
  const auto good = oddly(cut, later), bad = oddly(cut, later, faulty, faults);
  for (uint64_t seed = 1; seed <= 2; seed++) {
    FrameRun run;
    run.seed = seed;
    run.options.packetRays = 64;
    run.options.ranksPerPart = seed == 1 ? 1 : kRanks;
    Frames frames(kRanks, run);
    frames.add(1, good);
    frames.add(2, bad);
    FrameRequest failing = requestOf(kScene);
    failing.scene = 2;
    const FrameId before = frames.start(requestOf(kScene)), fails = frames.start(failing),
                  after = frames.start(requestOf(kScene));
    frames.run();
    EXPECT_EQ(frames.errors(), std::vector<std::string>());
    EXPECT_EQ(frames.outcome(fails).finished, 1);
    EXPECT_EQ(frames.outcome(fails).pictures, 0);
    EXPECT_EQ(frames.outcome(fails).error, "rank 2: " + error);
    for (FrameId id : {before, after}) {
      EXPECT_EQ(frames.outcome(id).error, "");
      EXPECT_EQ(difference(expected, frames.outcome(id).picture), "");
    }
    for (int r = 0; r < kRanks; r++) {
      const Renderer::ResourceCounts kept = frames.renderer(r).kept();
      EXPECT_EQ(kept.frames + kept.parkedMessages + kept.callbacks + kept.completionSets + kept.pictures, 0u);
      EXPECT_EQ(kept.credits, 0);
    }
  }
}

TEST(FailingDevice, EndsTheFrameItCannotBegin) {
  for (bool later : {false, true}) expectOnlyThatFrameFails({.frame = true}, "no room for a frame", later);
}

TEST(FailingDevice, MayHaveNoMemoryForAFrame) {
  for (bool later : {false, true}) expectOnlyThatFrameFails({.memory = true}, "not enough memory", later);
}

TEST(FailingDevice, SceneThatARankHasNotEndsTheFrame) {
  const Cut cut = kdCut(kScene.domain, 6, kRanks, 5);
  Frames frames(kRanks, {});
  frames.add(1, oddly(cut, false));
  frames.renderer(1).removeScene(1);
  const FrameId id = frames.start(requestOf(kScene));
  frames.run();
  EXPECT_EQ(frames.errors(), std::vector<std::string>());
  EXPECT_EQ(frames.outcome(id).finished, 1);
  EXPECT_EQ(frames.outcome(id).error, "rank 1: there is no scene 1");
}

TEST(FailingDevice, EndsTheFrameItCannotSpawn) {
  for (bool later : {false, true}) expectOnlyThatFrameFails({.spawn = true}, "the device is gone", later);
}

TEST(FailingDevice, EndsTheFrameItCannotTrace) {
  for (bool later : {false, true})
    for (int64_t traces : {0, 3}) expectOnlyThatFrameFails({.traces = traces}, "the device is gone", later);
}

TEST(FailingDevice, MayThrow) {
  for (bool later : {false, true})
    expectOnlyThatFrameFails({.throws = true, .traces = 2}, "the device is gone", later);
}

}  // namespace
}  // namespace gxy::test

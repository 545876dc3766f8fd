// SPDX-License-Identifier: Apache-2.0
// Many frames in flight: which are rendered first, and how many of them take memory.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/frames.h"
#include "tests/support/observed_backend.h"
#include "tests/support/seeds.h"

namespace gxy::test {
namespace {

constexpr int kFrames = std::max(20, sweep(50));
constexpr glm::ivec2 kSize{70, 40};
constexpr int64_t kBytes = kSize.x * kSize.y * (32 + 8);  // of a framebuffer with depths

struct Outcome {
  int mostFramebuffers = 0;        ///< of any rank
  std::vector<FrameId> inOrder{};  ///< as they finished
};

// All of them in flight at once, as one batch; each must be right.
Outcome batchOf(int ranks, const FrameRun& run) {
  TestScene scene = emptyScene("balls", kSize);
  addParticles(scene, 1);
  addLights(scene);
  static const Picture expected = wholeOnEmbree(scene);
  const auto compiled = compiledOn(lattice(sceneDomain(), {ranks, 1, 1}, ranks), scene);
  Frames frames(ranks, run);
  frames.add(1, compiled);
  std::vector<FrameId> ids;
  for (int i = 0; i < kFrames; i++) ids.push_back(frames.start(requestOf(scene)));
  Outcome outcome;
  size_t known = 0;
  std::vector<bool> finished(size_t(kFrames), false);
  while (frames.world().step()) {
    for (size_t i = 0; i < ids.size(); i++)
      if (!finished[i] && frames.outcome(ids[i]).finished) {
        finished[i] = true;
        outcome.inOrder.push_back(ids[i]);
        known++;
      }
  }
  EXPECT_EQ(known, size_t(kFrames));
  EXPECT_EQ(frames.errors(), std::vector<std::string>{});
  for (const FrameId id : ids) EXPECT_EQ(difference(expected, frames.outcome(id).picture), "");
  for (int r = 0; r < ranks; r++) {
    outcome.mostFramebuffers =
        std::max(outcome.mostFramebuffers, frames.renderer(r).counters().mostFramebuffers);
    EXPECT_EQ(frames.renderer(r).kept().frames, 0u);
    EXPECT_EQ(frames.renderer(r).kept().callbacks, 0u);
  }
  return outcome;
}

// How many places a frame came too early or too late.
int64_t mostOutOfPlace(const std::vector<FrameId>& order) {
  int64_t most = 0;
  for (size_t i = 0; i < order.size(); i++)
    most = std::max(most, std::abs(int64_t(order[i]) - int64_t(i) - 1));
  return most;
}

// Where all may begin at once, too: of a frame that has been begun all is done before the next begins, by one that works.
TEST(Batches, TheOldestFrameIsRenderedFirst) {
  TestScene scene = emptyScene("balls", kSize);
  addParticles(scene, 1);
  addLights(scene);
  std::vector<int> frameOfEach;  // piece of work, in their order
  Observer observer;
  observer.begins = [&](glm::ivec2 size, int) { frameOfEach.push_back(size.x - kSize.x); };
  const ObservedBackend backend(observer);
  const auto compiled =
      compiledOn(whole(sceneDomain()), scene, [&](int) -> const Backend& { return backend; });
  for (uint64_t seed = 1; seed <= uint64_t(seeds(5)); seed++) {
    FrameRun run;
    run.seed = seed;
    run.options.packetRays = 256;
    run.options.runners = 1;
    Frames frames(1, run);
    frames.add(1, compiled);
    frameOfEach.clear();
    for (int i = 0; i < kFrames; i++) {
      FrameRequest request = requestOf(scene);
      request.camera.dimensions.x += i;
      frames.start(request);
    }
    frames.run();
    EXPECT_TRUE(std::is_sorted(frameOfEach.begin(), frameOfEach.end())) << "schedule " << seed;
    EXPECT_GT(frameOfEach.size(), size_t(10 * kFrames));
    EXPECT_EQ(frameOfEach.back(), kFrames - 1);
  }
}

// Ranks that have less to do run ahead, and whoever hands out pictures may be slow: rank 0 begins so many and no more.
TEST(Batches, OnSeveralRanksFramesBeginAsOthersEnd) {
  for (uint64_t seed = 1; seed <= uint64_t(seeds(5)); seed++) {
    FrameRun run;
    run.seed = seed;
    run.options.packetRays = 256;
    run.options.framebufferBytes = 2 * kBytes;
    const Outcome outcome = batchOf(3, run);
    EXPECT_GE(outcome.mostFramebuffers, 1);
    EXPECT_LE(outcome.mostFramebuffers, 6) << "schedule " << seed;
    EXPECT_LE(mostOutOfPlace(outcome.inOrder), 2 * 6) << "schedule " << seed;
  }
}

// Of a batch that is given up, frames that have not begun end as the others do.
TEST(Batches, FramesThatWaitToBeginCanBeSuperseded) {
  TestScene scene = emptyScene("balls", {20, 16});
  addParticles(scene, 1);
  const auto compiled = compiledOn(lattice(sceneDomain(), {2, 1, 1}, 2), scene);
  const Picture expected = wholeOnEmbree(scene);
  for (uint64_t seed = 1; seed <= uint64_t(seeds(40)); seed++) {
    FrameRun run;
    run.seed = seed;
    run.options.framebufferBytes = 1;
    Frames frames(2, run);
    frames.add(1, compiled);
    std::vector<FrameId> ids;
    for (int i = 0; i < 12; i++) ids.push_back(frames.start(requestOf(scene)));
    for (uint64_t i = 0; i < 20 * seed && frames.world().step(); i++) {
    }
    for (size_t i = 1; i < ids.size(); i += 2) frames.renderer(0).supersede(ids[i]);
    frames.run();
    ASSERT_EQ(frames.errors(), std::vector<std::string>{});
    for (size_t i = 0; i < ids.size(); i++) {
      const Frames::Outcome& o = frames.outcome(ids[i]);
      ASSERT_EQ(o.finished, 1) << "frame " << i << ", schedule " << seed;
      ASSERT_EQ(o.pictures + o.superseded, 1) << "frame " << i << ", schedule " << seed;
      if (o.pictures) {
        ASSERT_EQ(difference(expected, o.picture), "") << "frame " << i << ", schedule " << seed;
      }
      if (i % 2 == 0) {
        ASSERT_EQ(o.pictures, 1) << "frame " << i << ", schedule " << seed;
      }
    }
    EXPECT_EQ(frames.outcome(ids.back()).superseded, 1) << "it waited, schedule " << seed;
    for (int r = 0; r < 2; r++) {
      EXPECT_EQ(frames.renderer(r).kept().frames, 0u);
      EXPECT_EQ(frames.renderer(r).kept().callbacks, 0u);
      EXPECT_EQ(frames.renderer(r).kept().completionSets, 0u);
    }
    if (HasFailure()) FAIL() << "schedule " << seed;
  }
}

}  // namespace
}  // namespace gxy::test

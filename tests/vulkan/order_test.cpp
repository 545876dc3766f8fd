// SPDX-License-Identifier: Apache-2.0
// What is urgent waits for what the device has begun, and for nothing else.
#include <gtest/gtest.h>

#include <condition_variable>
#include <functional>
#include <mutex>

#include "agreement/draw.h"
#include "gxy/vulkan/vulkan_scene.h"
#include "vulkan/test_device.h"

namespace gxy::vulkan_test {
namespace {

constexpr Tile kWhole{0, 0, kTile, kTile, 0};

agreement::TestScene oneTile() {
  agreement::TestScene scene = agreement::sceneFrom("wavy", {0, 0, 4}, kTile, kTile);
  scene.add(agreement::rendered({{0, 0}, {1, 1}}), agreement::wavy());
  return scene;
}

/// What was asked for and has not been answered, and in how many submissions what has been was done.
class Answers {
 public:
  DeviceScene::Done next(std::function<void(uint64_t submissions)> then) {
    std::lock_guard lock(mutex_);
    left_++;
    return [this, then = std::move(then)](TraceResult result) {
      EXPECT_EQ(result.error, "");
      std::lock_guard lock(mutex_);
      then(result.counters.submissions);
      left_--;
      changed_.notify_one();
    };
  }
  /// Nothing is answered meanwhile, so nothing more is handed to the device than it has.
  void hold(const std::function<void()>& what) {
    std::lock_guard lock(mutex_);
    what();
  }
  void wait() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return left_ == 0; });
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  int left_ = 0;
};

TEST(UrgentFrames, WaitForThreeBatchesAtMost) {
  constexpr int kTiles = 200;
  const agreement::TestScene scene = oneTile();
  const auto compiled = scene.compile();
  const auto device = testedVulkan().makeScene(compiled, 0);
  const CompiledFrame frame = compileFrame(*compiled, scene.camera, 0, false);
  const auto other = device->makeFrame(frame);
  const auto urgent = device->makeFrame(frame);
  urgent->setUrgent(true);
  uint64_t batches = 0, whenAsked = 0, whenAnswered = 0;  // of the other frame
  Answers answers;
  for (int i = 0; i < kTiles; i++) {
    if (i == kTiles / 2) {
      const auto done = answers.next([&](uint64_t) { whenAnswered = batches; });
      answers.hold([&] {
        whenAsked = batches;
        device->spawn(*urgent, kWhole, done);
      });
    }
    device->spawn(*other, kWhole, answers.next([&](uint64_t submissions) { batches += submissions; }));
  }
  answers.wait();
  EXPECT_GT(batches, 4u);
  EXPECT_LE(whenAnswered - whenAsked, 4u) << "three that the device has, and one that is being answered";
}

// Those of the frame whose turn was longer ago first, and none of one that has been cancelled.
TEST(UrgentFrames, TakeTurnsAndEndWhenTheyAreCancelled) {
  constexpr int kTiles = 200;
  const agreement::TestScene scene = oneTile();
  const auto compiled = scene.compile();
  const auto device = testedVulkan().makeScene(compiled, 0);
  const CompiledFrame frame = compileFrame(*compiled, scene.camera, 0, false);
  const auto first = device->makeFrame(frame), second = device->makeFrame(frame);
  first->setUrgent(true);
  second->setUrgent(true);
  uint64_t batches = 0, whenAsked = 0, whenAnswered = 0, whenCancelled = 0;  // of the first
  Answers answers;
  for (int i = 0; i < kTiles; i++) {
    if (i == kTiles / 2) {
      const auto done = answers.next([&](uint64_t) { whenAnswered = batches; });
      answers.hold([&] {
        whenAsked = batches;
        device->spawn(*second, kWhole, done);
      });
    }
    device->spawn(*first, kWhole, answers.next([&](uint64_t submissions) { batches += submissions; }));
  }
  answers.hold([&] {
    first->cancel();
    whenCancelled = batches;
  });
  answers.wait();
  EXPECT_LE(whenAnswered - whenAsked, 4u) << "three that the device has, and one that is being answered";
  EXPECT_LE(batches - whenCancelled, 4u);
}

// While somebody waits for another frame, so much goes to the device at once as takes it 5 ms, or one request.
TEST(OtherFrames, GoInSmallBatchesWhereTheDeviceTakesLong) {
  constexpr uint64_t kTiles = 7;  // sizes at most double from one batch to the next: 16 to 1024 rays
  const agreement::TestScene scene = oneTile();
  const auto compiled = scene.compile();
  const vulkan::VulkanScene device(std::make_shared<vulkan::Context>(testDevice()), compiled, 0);
  const CompiledFrame compiledFrame = compileFrame(*compiled, scene.camera, 0, false);
  const auto frame = device.makeFrame(compiledFrame);
  const auto urgent = device.makeFrame(compiledFrame);
  urgent->setUrgent(true);
  device.batchSize().took(device.batchSize().rays(), std::chrono::seconds(1));
  uint64_t batches = 0;
  Answers answers;
  device.spawn(*urgent, kWhole, answers.next([](uint64_t) {}));
  for (uint64_t i = 0; i < kTiles; i++)
    device.spawn(*frame, kWhole, answers.next([&](uint64_t submissions) { batches += submissions; }));
  answers.wait();
  EXPECT_EQ(batches, kTiles);
}

}  // namespace
}  // namespace gxy::vulkan_test

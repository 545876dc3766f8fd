// SPDX-License-Identifier: Apache-2.0
// What is urgent waits for what the device has begun, and for nothing else.
#include <gtest/gtest.h>

#include <condition_variable>
#include <functional>
#include <mutex>

#include "backends/vulkan/vulkan_scene.h"
#include "tests/agreement/draw.h"
#include "tests/vulkan/test_device.h"

namespace gxy::vulkan_test {
namespace {

constexpr SpawnTile kWhole{0, 0, kTile, kTile, 0};

agreement::TestScene oneTile() {
  agreement::TestScene scene = agreement::sceneFrom("wavy", {0, 0, 4}, kTile, kTile);
  scene.add(agreement::rendered({{0, 0}, {1, 1}}), agreement::wavy());
  return scene;
}

/// What was asked for and has not been answered.
class Answers {
 public:
  DeviceScene::Done next(std::function<void(const TraceCounters&)> then) {
    std::lock_guard lock(mutex_);
    left_++;
    return [this, then = std::move(then)](TraceResult result) {
      EXPECT_EQ(result.error, "");
      std::lock_guard lock(mutex_);
      then(result.counters);
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

class UrgentFrames : public ::testing::Test {
 protected:
  static constexpr int kTiles = 200;  // some eight batches
  static constexpr uint64_t kAll = uint64_t(kTiles) * kTile * kTile;

  std::shared_ptr<const DeviceFrame> makeFrame(bool urgent) {
    auto made = device_->makeFrame(frame_);
    made->setUrgent(urgent);
    return made;
  }

  /// Of `other` kTiles are asked for, and halfway one of `urgent`: the batches of `other` until it is answered. Then nobody
  /// wants the others any more.
  uint64_t batchesMeanwhile(const DeviceFrame& other, const DeviceFrame& urgent) {
    uint64_t whenAsked = 0, whenAnswered = 0;
    TraceCounters all;  // of the other frame
    Answers answers;
    for (int i = 0; i < kTiles; i++) {
      if (i == kTiles / 2) {
        const auto done = answers.next([&](const TraceCounters&) {
          whenAnswered = all.submissions;
          other.cancel();
        });
        answers.hold([&] {
          whenAsked = all.submissions;
          device_->spawn(urgent, kWhole, done);
        });
      }
      device_->spawn(other, kWhole, answers.next([&](const TraceCounters& c) { all += c; }));
    }
    answers.wait();
    EXPECT_LT(all.raysSpawned, kAll) << "or it waited for nothing";
    return whenAnswered - whenAsked;
  }

  const agreement::TestScene scene_ = oneTile();
  const std::shared_ptr<const CompiledScene> compiled_ = scene_.compile();
  const std::shared_ptr<const DeviceScene> device_ = testedVulkan().makeScene(compiled_, 0);
  const CompiledFrame frame_ = compileFrame(*compiled_, scene_.camera, 0, false);
};

TEST_F(UrgentFrames, WaitForThreeBatchesAtMost) {
  const auto other = makeFrame(false), urgent = makeFrame(true);
  EXPECT_LE(batchesMeanwhile(*other, *urgent), 4u)
      << "three that the device has, and one that is being answered";
}

// Those of the frame whose turn was longer ago first.
TEST_F(UrgentFrames, TakeTurns) {
  const auto first = makeFrame(true), second = makeFrame(true);
  EXPECT_LE(batchesMeanwhile(*first, *second), 4u)
      << "three that the device has, and one that is being answered";
}

TEST_F(UrgentFrames, EndWithWhatTheDeviceHasWhenTheyAreCancelled) {
  const auto frame = makeFrame(true);
  std::vector<DeviceScene::Done> dones;
  TraceCounters all;
  Answers answers;
  for (int i = 0; i < kTiles; i++) dones.push_back(answers.next([&](const TraceCounters& c) { all += c; }));
  answers.hold([&] {
    for (const DeviceScene::Done& done : dones) device_->spawn(*frame, kWhole, done);
    frame->cancel();
  });
  answers.wait();
  EXPECT_LE(all.submissions, 4u) << "three that the device has, and one that is being answered";
  EXPECT_LT(all.raysSpawned, kAll / 2);
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
  device.spawn(*urgent, kWhole, answers.next([](const TraceCounters&) {}));
  for (uint64_t i = 0; i < kTiles; i++)
    device.spawn(*frame, kWhole, answers.next([&](const TraceCounters& c) { batches += c.submissions; }));
  answers.wait();
  EXPECT_EQ(batches, kTiles);
}

}  // namespace
}  // namespace gxy::vulkan_test

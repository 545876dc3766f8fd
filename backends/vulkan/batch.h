// SPDX-License-Identifier: Apache-2.0
// Batch: packets of a frame that go through a partition together, on one lane.
#pragma once
#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "backends/vulkan/device_time.h"
#include "backends/vulkan/lane.h"
#include "backends/vulkan/vulkan_scene.h"

namespace gxy::vulkan {

inline size_t pixelsOf(const SpawnTile& t) { return size_t(t.x1 - t.x0) * size_t(t.y1 - t.y0); }

/// A request to a scene: a packet to trace, a tile to spawn, or rays of a sampling that begin.
struct DeviceTask {
  enum class Kind { Spawn, Begin, Primaries, Secondaries };
  const VulkanScene* scene;
  /// The part that rays are traced in. For spawning: rays that start in it are traced at once.
  const PartitionOnDevice* part;
  const VulkanFrame* frame;
  Kind kind;
  RayList rays;
  SpawnTile tile{};
  DeviceScene::Done done;
  bool urgent = false;  ///< whether its frame was urgent when its turn came

  size_t size() const { return kind == Kind::Spawn ? pixelsOf(tile) : size_t(rays.size()); }
  /// Most secondaries that each of its rays may make at a time, on the device.
  size_t perHit() const {
    return kind == Kind::Begin || kind == Kind::Secondaries || part->partition < 0
               ? 0
               : scene->secondariesPerHit(*frame);
  }
  /// Whether its rays are primaries.
  bool primary() const { return kind == Kind::Spawn || kind == Kind::Primaries; }
  /// Whether its rays count as created only where the result has them.
  bool spawns() const { return kind == Kind::Spawn || kind == Kind::Begin; }
  /// Whether both may go in one batch.
  bool isLike(const DeviceTask& o) const {
    return scene == o.scene && part == o.part && frame == o.frame && kind == o.kind;
  }
};

/// Answers requests: all their rays have ended without being traced. `error` says why, if something went
/// wrong.
void endUndone(std::vector<DeviceTask>& requests, const std::string& error);

/// Requests that the device does together. On the device, primaries make secondaries, and secondaries that
/// start in the same partition are traced in the same submission, without the host. Rays that go on in
/// another partition of the rank wait on the device, and the host knows their places (KeptRays). Rays that
/// leave the rank come back to the host. Another submission follows if rays go on behind translucent
/// surfaces, or if the device has not ended the work of a stage (shaders/resumable.glsl). Used by one thread
/// at a time.
class Batch {
 public:
  /// All requests must be like the first one.
  explicit Batch(std::vector<DeviceTask> requests);

  /// Submits the first work on `lane`. Throws Error if the device fails; so does advance().
  void start(std::unique_ptr<Lane> lane);
  /// Waits for what was submitted, tells `time`, and submits what follows. Returns false if all is done.
  bool advance(DeviceTime& time);
  /// Adds host time in which requests had no answer and which no batch has counted yet.
  void addAsked(std::chrono::nanoseconds time) {
    results_[0].counters.nsDeviceAsked += uint64_t(time.count());
  }
  /// Whether its rays record samples.
  bool samples() const { return frame_.sampling != nullptr; }
  /// Gives up the lane, when the batch is over.
  std::unique_ptr<Lane> takeLane() { return std::move(lane_); }
  /// Answers the requests with what has become of their rays.
  void answer();
  /// Answers them with an error instead.
  void fail(const std::string& error) { endUndone(requests_, error); }

 private:
  size_t rays() const;
  void trace(List list, int32_t rays, bool primary);
  void submit(size_t firstStep, bool resumed);
  void take();
  void takeRecords();
  void distribute();

  std::vector<DeviceTask> requests_;
  std::unique_ptr<Lane> lane_;
  std::vector<TraceResult> results_;
  const VulkanScene& scene_;
  const PartitionOnDevice& part_;
  const VulkanFrame& frame_;
  const DeviceTask::Kind kind_;
  const bool primary_, spawns_;  ///< DeviceTask::primary() and spawns()
  const size_t perHit_;
  bool complete_ = true;  ///< the rays have their origins and directions
  std::vector<Step> steps_;
  List given_ = List::Given, here_ = List::Here;
  size_t activePrimaries_ = 0, activeSecondaries_ = 0;
};

}  // namespace gxy::vulkan

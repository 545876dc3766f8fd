// SPDX-License-Identifier: Apache-2.0
// Packets of a frame that go through a partition together, on one lane.
#pragma once
#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "backends/vulkan/device_time.h"
#include "backends/vulkan/lane.h"
#include "backends/vulkan/vulkan_scene.h"

namespace gxy::vulkan {

inline size_t pixelsOf(const Tile& t) { return size_t(t.x1 - t.x0) * size_t(t.y1 - t.y0); }

/// What a scene is asked for: a packet to trace or a tile to spawn.
struct Request {
  enum class Kind { Spawn, Primaries, Secondaries };
  const VulkanScene* scene;
  const PartOnDevice* part;  ///< traces in it; for spawning: where those that start there are traced at once
  const VulkanFrame* frame;
  Kind kind;
  RayList rays;
  Tile tile{};
  DeviceScene::Done done;
  bool urgent = false;  ///< as its frame was when its turn came

  size_t size() const { return kind == Kind::Spawn ? pixelsOf(tile) : size_t(rays.size()); }
  /// Secondaries that each of its rays may make at a time, on the device.
  size_t perHit() const {
    return kind == Kind::Secondaries || part->partition < 0 ? 0 : scene->secondariesPerHit(*frame);
  }
  /// Whether both can be done together.
  bool isLike(const Request& o) const {
    return scene == o.scene && part == o.part && frame == o.frame && kind == o.kind;
  }
};

/// Tells those who asked that all their rays have ended; `error`: why, if something went wrong.
void endUndone(std::vector<Request>& requests, const std::string& error);

/// On the device, primaries make secondaries, and those that start in the same partition are traced in the same submission,
/// without the host. What goes on in another partition of the rank waits on the device, and the host knows which they are
/// (KeptRays); what leaves the rank comes back. Another submission follows where rays go on behind translucent surfaces, and
/// where the device has not ended what a stage had to do (shaders/rays.glsl). One thread at a time.
class Batch {
 public:
  /// All requests like the first.
  explicit Batch(std::vector<Request> requests);

  /// Begins. Throws Error where the device fails, as does advance().
  void start(std::unique_ptr<Lane> lane);
  /// Waits for what was submitted, and goes on; false: all is done. `time`: the device's, which hears of it.
  bool advance(DeviceTime& time);
  /// The host's time in which something was asked of the device, and no batch has counted yet.
  void addAsked(std::chrono::nanoseconds time) {
    results_[0].counters.nsDeviceAsked += uint64_t(time.count());
  }
  /// The lane, when the batch is over.
  std::unique_ptr<Lane> takeLane() { return std::move(lane_); }
  /// Tells those who asked what has become of their rays.
  void answer();
  /// Tells them what went wrong instead.
  void fail(const std::string& error) { endUndone(requests_, error); }

 private:
  size_t rays() const;
  void trace(List list, int32_t rays, bool primary);
  void submit(size_t firstStep, bool resumed);
  void take();
  void distribute();

  std::vector<Request> requests_;
  std::unique_ptr<Lane> lane_;
  std::vector<TraceResult> results_;
  const VulkanScene& scene_;
  const PartOnDevice& part_;
  const VulkanFrame& frame_;
  const Request::Kind kind_;
  const size_t perHit_;
  bool complete_ = true;  ///< rays have their origins and directions
  std::vector<Step> steps_;
  List given_ = List::Given, here_ = List::Here;
  size_t activePrimaries_ = 0, activeSecondaries_ = 0;
};

}  // namespace gxy::vulkan

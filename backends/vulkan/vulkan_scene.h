// SPDX-License-Identifier: Apache-2.0
// A compiled scene on a Vulkan device.
#pragma once
#include <atomic>
#include <map>
#include <memory>
#include <vector>

#include "backends/vulkan/device_time.h"
#include "backends/vulkan/lane.h"
#include "backends/vulkan/scene_upload.h"
#include "backends/vulkan/tracer.h"
#include "core/rays/backend.h"
#include "core/rays/packet_size.h"

namespace gxy::vulkan {

/// What all scenes of a backend share.
struct Context {
  explicit Context(const VulkanOptions& options);
  Device device;
  Pipelines pipelines;
  SharedData shared;
  DeviceTime time;
  const bool countsNodes;             ///< VulkanOptions
  const size_t mostKept;              ///< bytes, for rays that wait on the device (KeptRays)
  std::atomic<size_t> bytesKept = 0;  ///< by these
  Tracer tracer;
  std::atomic<uint64_t> frames = 0;  ///< that were made
};

struct VulkanFrame final : DeviceFrame {
  ~VulkanFrame() override {
    if (time) time->over(number);
  }
  uint64_t number = 0;         ///< from 1
  DeviceTime* time = nullptr;  ///< hears that it is over
  Buffer buffer;
  DescriptorSet set;
  int lights = 0;
  bool depth = false;
  double worldPerRender = 1;
  mutable uint64_t lastTurn = 0;  ///< the Tracer's, under its lock
};

class VulkanScene final : public DeviceScene {
 public:
  VulkanScene(
      std::shared_ptr<Context> context, std::shared_ptr<const CompiledScene> scene, int rank,
      const Advance& advance = [](double) {});

  std::shared_ptr<const DeviceFrame> makeFrame(const CompiledFrame& frame) const override;
  void spawn(const DeviceFrame& frame, const Tile& tile, Done done) const override;
  void trace(const DeviceFrame& frame, int partition, bool primary, RayList rays, Done done) const override;
  size_t bytes() const override { return charge_.bytes(); }
  std::vector<SharedBytes> sharedBytes() const override;

  // What a Batch asks.
  /// Adds what `rays` rays of a list (or ~k: as many as counts[k]) go through in a partition.
  void addSteps(std::vector<Step>& steps, const PartOnDevice& part, const VulkanFrame& frame, List list,
                int32_t rays, bool primary, bool complete) const;
  static Step spawnStep(const PartOnDevice& part, int tiles);
  /// Adds what a lane's stages took.
  static void addTimes(TraceCounters& counters, const Lane& lane);
  size_t secondariesPerHit(const VulkanFrame& frame) const;
  /// Whether the partition is one of this rank's in which anything is seen.
  bool isHere(int partition) const { return parts_.count(partition) > 0; }
  /// Makes room for so many rays that go on in another partition of the rank, but where there is no other, or too much of the
  /// device's memory is taken so: what leaves then comes back to the host.
  void keepRays(std::shared_ptr<KeptRays>& room, size_t rays) const;
  void release(std::shared_ptr<KeptRays> kept) const { kept->release(context_); }
  /// Of frames that are not urgent, while others are (tracer.h).
  PacketSize& batchSize() const { return batchSize_; }
  const std::string& deviceName() const { return context_->device.info().name; }

 private:
  /// Has the stages compiled that the scene will need, as the first rays of a frame would wait for it, and all that wait behind
  /// them. Two are left to the first frame that needs them, as most scenes never do, and both are small: Depth, if the frame wants
  /// depths; and Regenerate, if primaries come from another rank, which is a matter of the camera.
  void compile(const Advance& advance);
  /// Where primaries begin.
  const PartOnDevice& spawningPart() const;
  size_t mostAtOnce(const Request& request) const;
  void ask(std::vector<Request> parts, uint64_t rays, Done done) const;

  std::shared_ptr<Context> context_;
  std::shared_ptr<const CompiledScene> scene_;
  int rank_;
  PartOnDevice anywhere_;              ///< without a partition: for spawning, where there are several
  std::map<int, PartOnDevice> parts_;  ///< by local partition
  Charge charge_;                      ///< of both, but for what they share
  std::vector<Pipeline> pipelines_;
  mutable PacketSize batchSize_;
  std::vector<int> slicedOperators_, isoOperators_, renderedOperators_;
  bool surfacesInVolumes_ = false, isClipped_ = false;
};

}  // namespace gxy::vulkan

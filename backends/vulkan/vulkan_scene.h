// SPDX-License-Identifier: Apache-2.0
// VulkanScene: a compiled scene on a Vulkan device.
#pragma once
#include <atomic>
#include <map>
#include <memory>
#include <vector>

#include "backends/vulkan/device_time.h"
#include "backends/vulkan/lane.h"
#include "backends/vulkan/scene_upload.h"
#include "backends/vulkan/tracer.h"
#include "backends/vulkan/vulkan_sampling.h"
#include "core/rays/backend.h"
#include "core/rays/packet_size.h"

namespace gxy::vulkan {

/// The state that all scenes of a backend share.
struct Context {
  explicit Context(const VulkanOptions& options);
  Device device;
  Pipelines pipelines;
  SharedData shared;
  DeviceTime time;
  const bool countsNodes;             ///< VulkanOptions::countsNodes
  const size_t mostKept;              ///< most bytes of rays that wait on the device (KeptRays)
  std::atomic<size_t> bytesKept = 0;  ///< bytes of these rays now
  Tracer tracer;
  std::atomic<uint64_t> frames = 0;  ///< number of frames that were made
};

struct VulkanFrame final : DeviceFrame {
  ~VulkanFrame() override {
    if (time) time->over(number);
  }
  uint64_t number = 0;         ///< number of the frame on this device, from 1
  DeviceTime* time = nullptr;  ///< is told that the frame is over
  Buffer buffer;
  DescriptorSet set;
  int lights = 0;
  bool depth = false;
  double worldPerRender = 1;
  std::unique_ptr<const VulkanSampling> sampling;  ///< null unless its rays sample
  EnterMemory enter;                               ///< of a sampling
  std::vector<Pipeline> pipelines;                 ///< of a sampling: those that only it needs
  mutable uint64_t lastTurn = 0;                   ///< for the Tracer, guarded by its lock
};

class VulkanScene final : public DeviceScene {
 public:
  VulkanScene(
      std::shared_ptr<Context> context, std::shared_ptr<const CompiledScene> scene, int rank,
      const Advance& advance = [](double) {});

  std::shared_ptr<const DeviceFrame> makeFrame(const CompiledFrame& frame) const override;
  /// Null if the device has no room for the fields. The reason is logged.
  std::shared_ptr<const DeviceFrame> makeSampling(std::shared_ptr<const CompiledSampling> sampling,
                                                  EnterMemory enter) const override;
  void spawnRays(const DeviceFrame& frame, RayList rays, Done done) const override;
  void spawn(const DeviceFrame& frame, const SpawnTile& tile, Done done) const override;
  void trace(const DeviceFrame& frame, int partition, bool primary, RayList rays, Done done) const override;
  size_t bytes() const override { return charge_.bytes(); }
  std::vector<SharedBytes> sharedBytes() const override;

  // The functions below are for Batch.
  /// Adds the steps that the rays of a list go through in a partition. `rays` is their number. If only the
  /// device knows it, `rays` is negative: the bitwise complement of the index of a count, as ~COUNT_SPAWNED.
  void addSteps(std::vector<Step>& steps, const PartitionOnDevice& part, const VulkanFrame& frame, List list,
                int32_t rays, bool primary, bool complete) const;
  static Step beginStep(const PartitionOnDevice& part, int rays);
  static Step spawnStep(const PartitionOnDevice& part, int tiles);
  /// Adds the times of a lane's stages.
  static void addTimes(TraceCounters& counters, const Lane& lane);
  size_t secondariesPerHit(const VulkanFrame& frame) const;
  /// Whether the partition is one of this rank's in which something can be seen.
  bool isHere(int partition) const { return parts_.count(partition) > 0; }
  /// Makes `room` for this many rays that go on in another partition of the rank. It resets `room` if there
  /// is no such partition, or if rays take too much of the device's memory; what leaves then comes back to
  /// the host.
  void keepRays(std::shared_ptr<KeptRays>& room, size_t rays) const;
  void release(std::shared_ptr<KeptRays> kept) const { kept->release(context_); }
  /// The size of batches of frames that are not urgent, while others are (tracer.h).
  PacketSize& batchSize() const { return batchSize_; }
  const std::string& deviceName() const { return context_->device.info().name; }

 private:
  /// Compiles the stages that the scene will need, because the first rays of a frame, and all that wait
  /// behind them, would wait for that. Two small stages, which most scenes never use, are left to the first
  /// frame that needs them: Depth, if the frame wants depths, and Regenerate, if primaries come from another
  /// rank, which depends on the camera.
  void compile(const Advance& advance);
  /// The part in which primaries are spawned.
  const PartitionOnDevice& spawningPart() const;
  size_t mostAtOnce(const DeviceTask& request) const;
  void askInParts(DeviceTask whole, uint64_t rays, Done done) const;
  void ask(std::vector<DeviceTask> parts, uint64_t rays, Done done) const;

  std::shared_ptr<Context> context_;
  std::shared_ptr<const CompiledScene> scene_;
  int rank_;
  PartitionOnDevice anywhere_;              ///< without a partition; for spawning, if there are several parts
  std::map<int, PartitionOnDevice> parts_;  ///< key: local partition
  Charge charge_;                           ///< memory of both, without what they share with other scenes
  std::vector<Pipeline> pipelines_;
  mutable PacketSize batchSize_;
  bool isClipped_ = false;
};

}  // namespace gxy::vulkan

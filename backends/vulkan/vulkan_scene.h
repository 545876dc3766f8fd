// SPDX-License-Identifier: Apache-2.0
// A compiled scene on a Vulkan device.
#pragma once
#include <map>
#include <memory>
#include <vector>

#include "gxy/rays/backend.h"
#include "gxy/vulkan/lane.h"
#include "gxy/vulkan/scene_upload.h"

namespace gxy::vulkan {

/// What all scenes of a backend share.
struct Context {
  explicit Context(const VulkanOptions& options)
      : device(options), pipelines(device), lanes(device, pipelines) {}
  Device device;
  Pipelines pipelines;
  LanePool lanes;
};

class VulkanScene final : public DeviceScene {
 public:
  VulkanScene(std::shared_ptr<Context> context, std::shared_ptr<const CompiledScene> scene, int rank);

  std::shared_ptr<const DeviceFrame> makeFrame(const CompiledFrame& frame) const override;
  void spawn(const DeviceFrame& frame, const Tile& tile, Done done) const override;
  void trace(const DeviceFrame& frame, int partition, bool primary, RayList rays, Done done) const override;
  size_t bytes() const override;

 private:
  class Packet;

  std::shared_ptr<Context> context_;
  std::shared_ptr<const CompiledScene> scene_;
  int rank_;
  PartOnDevice anywhere_;              ///< without a partition: for spawning
  std::map<int, PartOnDevice> parts_;  ///< by local partition
  std::vector<int> slicedOperators_, isoOperators_, renderedOperators_;
  bool surfacesInVolumes_ = false;
};

}  // namespace gxy::vulkan

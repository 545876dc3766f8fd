// SPDX-License-Identifier: Apache-2.0
// The stages of shaders/ as compute pipelines. Each is compiled when a scene first needs it for its
// specialization constants.
#pragma once
#include <array>
#include <compare>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "backends/vulkan/vulkan_device.h"
#include "shaders/layout.h"

namespace gxy::vulkan {

enum class Stage {
  Spawn,
  Begin,
  Regenerate,
  Bound,
  Geometry,
  Slices,
  Isosurfaces,
  Integrate,
  IntegrateVolumes,
  IntegrateMesh,
  Shade,
  Sample,
  Depth,
  Finish,
  Groups,
  Take,
  Last = Take
};

/// The specialization constants of shaders/layout.h that a stage is compiled for, in their order.
struct Special {
  int32_t addressed = 0, sampleKind = -1;
  uint32_t scalars = 0;
  int32_t surfaces = 0;
  uint32_t anyHit = 0;
  uint32_t byCells = 0, limited = 0;
  int32_t mapKind = -1, operators = 0, routes = ROUTE_ON | ROUTE_LEAVES, mapAhead = 0;
  uint32_t roundsRight = 0;
  auto operator<=>(const Special&) const = default;
};

/// A part of a buffer, bound as a storage buffer or, if `texels` is set, as texels of that format.
struct Binding {
  VkDescriptorBufferInfo buffer{};
  VkFormat texels = VK_FORMAT_UNDEFINED;
};

/// A descriptor set, bound in order from binding 0, with a pool of its own.
class DescriptorSet {
 public:
  DescriptorSet() = default;
  DescriptorSet(const Device& device, VkDescriptorSetLayout layout, std::span<const Binding> bindings);
  VkDescriptorSet get() const { return set_; }

 private:
  DescriptorPoolHandle pool_;
  std::vector<BufferViewHandle> views_;
  VkDescriptorSet set_ = VK_NULL_HANDLE;
};

/// Keeps a pipeline compiled while a scene needs it or the device works with it.
using Pipeline = std::shared_ptr<const PipelineHandle>;

/// The cache of compiled pipelines. Thread safe.
class Pipelines {
 public:
  /// At most `most` pipelines that nobody holds stay compiled: the ones that were asked for last.
  explicit Pipelines(const Device& device, size_t most = VulkanOptions().keptPipelines);
  /// Returns the pipeline of a stage, and compiles it if there is none. Constants that the stage does not
  /// read make no difference. Throws Error if the compilation fails.
  Pipeline get(Stage stage, const Special& special);
  /// The stage of each pipeline that is in the cache.
  std::vector<Stage> stages() const;
  VkPipelineLayout layout() const { return layout_.get(); }
  VkDescriptorSetLayout setLayout(int set) const { return sets_[size_t(set)].get(); }

 private:
  void forget();

  const Device& device_;
  const size_t most_;
  std::array<SetLayoutHandle, 3> sets_;
  PipelineLayoutHandle layout_;
  /// A thread that wants a pipeline that another thread compiles waits for that one only.
  struct Compiled {
    std::mutex mutex;
    PipelineHandle pipeline;
    uint64_t wanted = 0;  ///< the number of the last call that asked for it
  };
  mutable std::mutex mutex_;  ///< guards what is below, except what is in a Compiled
  std::map<std::pair<Stage, Special>, std::shared_ptr<Compiled>> made_;
  uint64_t calls_ = 0;
};

}  // namespace gxy::vulkan

// SPDX-License-Identifier: Apache-2.0
// The stages of shaders/ as compute pipelines, each made when a scene first needs it so.
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
  Regenerate,
  Bound,
  Geometry,
  Slices,
  Isosurfaces,
  Integrate,
  IntegrateMany,
  Shade,
  Depth,
  Finish,
  Groups,
  Take,
  Last = Take
};

/// What a stage is compiled for: the specialization constants of shaders/layout.h, in their order.
struct Special {
  int32_t addressed = 0, sampleKind = -1;
  uint32_t scalars = 0;
  int32_t surfaces = 0;
  uint32_t anyHit = 0;
  uint32_t byCells = 0, limited = 0;
  int32_t mapKind = -1, operators = 0, routes = ROUTE_ON | ROUTE_LEAVES, mapAhead = 0;
  auto operator<=>(const Special&) const = default;
};

/// A part of a buffer, bound as a storage buffer or as texels of some format.
struct Binding {
  VkDescriptorBufferInfo buffer{};
  VkFormat texels = VK_FORMAT_UNDEFINED;
};

/// What is bound in order from binding 0; with a pool of its own.
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

/// Holds a pipeline while a scene needs it, or the device works with it.
using Pipeline = std::shared_ptr<const PipelineHandle>;

/// Thread safe.
class Pipelines {
 public:
  /// Of those that nobody holds, the `most` that were wanted last stay compiled.
  explicit Pipelines(const Device& device, size_t most = 24);
  Pipeline get(Stage stage, const Special& special);
  /// The stage of each that was made.
  std::vector<Stage> stages() const;
  VkPipelineLayout layout() const { return layout_.get(); }
  VkDescriptorSetLayout setLayout(int set) const { return sets_[size_t(set)].get(); }

 private:
  void forget();

  const Device& device_;
  const size_t most_;
  std::array<SetLayoutHandle, 3> sets_;
  PipelineLayoutHandle layout_;
  /// Whoever wants one that another thread compiles waits for it, and for no other.
  struct Compiled {
    std::mutex mutex;
    PipelineHandle pipeline;
    uint64_t wanted = 0;  ///< the number of the last call that asked for it
  };
  mutable std::mutex mutex_;  ///< of what is below, but for what is in a Compiled
  std::map<std::pair<Stage, Special>, std::shared_ptr<Compiled>> made_;
  uint64_t calls_ = 0;
};

}  // namespace gxy::vulkan

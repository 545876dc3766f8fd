// SPDX-License-Identifier: Apache-2.0
// Device buffers for one packet of rays at a time, and the commands that work on them.
#pragma once
#include <functional>
#include <initializer_list>
#include <memory>
#include <mutex>
#include <vector>

#include "gxy/rays/ray_list.h"
#include "gxy/vulkan/pipelines.h"
#include "gxy/vulkan/shader_views.h"

namespace gxy::vulkan {

/// BLOCK_RAYS rays as the shaders keep them.
struct RayBlock {
#define GXY_FIELD(type, name, primary, secondary) type name[BLOCK_RAYS];
  GXY_RAY_FIELDS(GXY_FIELD)
#undef GXY_FIELD
};

/// Rays `which` of a list of blocks, as gather() of a RayList gives them.
RayList gather(const RayBlock* blocks, std::span<const int> which);

/// One thread at a time. Two lists of rays take turns: one is traced, and what goes on behind translucent surfaces
/// becomes the other.
class Lane {
 public:
  Lane(const Device& device, Pipelines& pipelines);

  /// Makes room for `rays` rays that make up to `made` secondaries.
  void reserve(size_t rays, size_t made);
  /// Rays [first, first + count) of a list become those to trace.
  void load(const RayList& list, int first, int count);
  /// The rays that went on become those to trace.
  void swapLists() { turn_ = 1 - turn_; }

  /// Begins commands on the rays; what was counted is forgotten.
  void begin(VkDescriptorSet scene, VkDescriptorSet frame, int rays);
  /// Adds a stage. The words go to its push constants behind the number of rays.
  void run(Stage stage, const Special& special, std::initializer_list<int32_t> words = {});
  /// Runs what was added, and waits for it.
  void finish();

  /// Nanoseconds of the device since begin() for a stage; 0 where it has no clock.
  uint64_t nanoseconds(Stage stage) const { return nanoseconds_[size_t(stage)]; }
  /// Since begin(): a COUNT_* of shaders/layout.h.
  uint32_t count(int which) const { return counted_[which]; }
  const RayBlock* leaving() const { return reinterpret_cast<const RayBlock*>(leaving_.mapped()); }
  const RayBlock* made() const { return reinterpret_cast<const RayBlock*>(made_.mapped()); }
  const int32_t* records() const { return reinterpret_cast<const int32_t*>(records_.mapped()); }
  const uint32_t* depths() const { return reinterpret_cast<const uint32_t*>(depths_.mapped()); }

 private:
  const Device& device_;
  Pipelines& pipelines_;
  Commands commands_;
  VkCommandBuffer recording_ = VK_NULL_HANDLE;
  size_t rayCapacity_ = 0, madeCapacity_ = 0;
  Buffer lists_[2], made_, leaving_, records_, depths_, counts_, countsRead_, staging_;
  DescriptorSet sets_[2];
  int turn_ = 0, rays_ = 0;
  bool staged_ = false;  ///< rays wait in staging_ to be copied
  uint32_t counted_[COUNT_WORDS] = {};
  QueryPoolHandle clock_;      ///< read at begin() and behind each stage
  std::vector<Stage> stages_;  ///< that were added
  uint64_t nanoseconds_[size_t(Stage::Finish) + 1] = {};
};

/// Lanes that nobody uses, for the next who needs one. Thread safe.
class LanePool {
 public:
  LanePool(const Device& device, Pipelines& pipelines) : device_(device), pipelines_(pipelines) {}
  using Lease = std::unique_ptr<Lane, std::function<void(Lane*)>>;
  Lease take();

 private:
  const Device& device_;
  Pipelines& pipelines_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<Lane>> idle_;
};

}  // namespace gxy::vulkan

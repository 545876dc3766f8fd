// SPDX-License-Identifier: Apache-2.0
// Device buffers for one batch of rays, and the commands that work on them.
#pragma once
#include <array>
#include <optional>
#include <span>
#include <vector>

#include "backends/vulkan/kept_rays.h"
#include "backends/vulkan/pipelines.h"
#include "backends/vulkan/shader_views.h"
#include "core/rays/backend.h"

namespace gxy::vulkan {

/// BLOCK_RAYS rays as the shaders keep them.
struct RayBlock {
#define GXY_FIELD(type, name, primary, secondary) type name[BLOCK_RAYS];
  GXY_RAY_FIELDS(GXY_FIELD)
#undef GXY_FIELD
#define GXY_FIELD(type, name) type name[BLOCK_RAYS];
  GXY_DEVICE_FIELDS(GXY_FIELD)
#undef GXY_FIELD
};
inline constexpr size_t kRayBytes = sizeof(RayBlock) / BLOCK_RAYS;

/// Rays `which` of a list of blocks, as gather() of a RayList gives them.
RayList gather(const RayBlock* blocks, std::span<const int> which);

/// The lists that are traced. What goes on behind translucent surfaces is put into a second one, which takes turns with the
/// first.
enum class List { Given, GivenOther, Here, HereOther };
inline List otherOf(List list) { return List(int(list) ^ 1); }

/// A stage and what it works on.
struct Step {
  Stage stage;
  Special special;
  List list = List::Given;
  std::array<int32_t, PUSH_WORDS> push{};  ///< but for PUSH_STEP, PUSH_ONE and PUSH_ROUNDS
};

/// The most rays that a list holds on this device: a binding and the workgroups of a dispatch have their limits.
size_t mostRays(const Device& device);

/// Bytes of a list of so many rays.
size_t listBytes(size_t rays);

/// Used by one thread at a time.
class Lane {
 public:
  Lane(const Device& device, Pipelines& pipelines);

  /// Makes room for `rays` given rays, each of which makes up to `perHit` secondaries. Throws Error where these are more than
  /// mostRays() together.
  void reserve(size_t rays, size_t perHit);
  /// Whether it has room for more than so many rays, given and made.
  bool isLargerThan(size_t rays) const;
  /// Makes rays at `at`, ... of the list that is given of a packet.
  void load(const RayList& rays, size_t at, uint32_t packet);
  /// The same of rays at `places` of a list that begins at `list`, as a step that is to be done first.
  Step take(VkDeviceAddress list, std::span<const uint32_t> places, size_t at, uint32_t packet);
  /// Such a step before it has any rays.
  static Step takeStep(const Device& device);

  /// Makes them the tiles that are spawned.
  void load(std::span<const Tile> tiles);

  /// Hands these steps to the device; `resumed`: with what was counted in the submission before, else from zero.
  void submit(VkDescriptorSet scene, VkDescriptorSet frame, std::span<const Step> steps, size_t firstStep,
              bool resumed);
  /// Waits until they are done.
  void wait();

  /// Where rays go that stay on the device; null: none do. Kept for the next batch where none has.
  std::shared_ptr<KeptRays> staying;

  /// Of what has been waited for. Nanoseconds of the device for a stage; its clock when the first began and when the last
  /// ended; 0 where it has none.
  uint64_t nanoseconds(Stage stage) const { return nanoseconds_[size_t(stage)]; }
  uint64_t began() const { return began_; }
  uint64_t ended() const { return ended_; }
  /// A COUNT_* of shaders/layout.h.
  uint32_t count(int which) const { return counted_[which]; }
  /// Of those that stay, only `packet`, `info` and `next`.
  const RayBlock* leaving() const { return reinterpret_cast<const RayBlock*>(leaving_.mapped()); }
  const int32_t* records() const { return reinterpret_cast<const int32_t*>(records_.mapped()); }
  const uint32_t* depths() const { return reinterpret_cast<const uint32_t*>(depths_.mapped()); }

 private:
  size_t roomy(size_t bytes) const;
  void record(const Step& step, size_t number);
  void readClock();

  const Device& device_;
  Pipelines& pipelines_;
  Commands commands_;
  std::optional<Commands> copies_;  ///< of what waits in staging_
  VkCommandBuffer recording_ = VK_NULL_HANDLE;
  Buffer lists_[4], leaving_, records_, depths_, counts_, countsRead_, staging_, places_;
  DescriptorSet sets_[4];  ///< by list
  size_t loaded_ = 0;      ///< rays that wait in staging_ to be copied
  uint32_t counted_[COUNT_WORDS] = {};
  QueryPoolHandle clock_;      ///< read at first, behind each stage, and at last
  uint32_t readings_ = 0;      ///< of it
  std::vector<Stage> stages_;  ///< behind which it was read
  std::vector<Pipeline> bound_;
  uint64_t nanoseconds_[size_t(Stage::Last) + 1] = {}, began_ = 0, ended_ = 0;
};

}  // namespace gxy::vulkan

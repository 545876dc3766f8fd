// SPDX-License-Identifier: Apache-2.0
// Lane: device buffers for one batch of rays, and the commands that work on them. It is no SIMD lane.
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

/// BLOCK_RAYS rays in the form that the shaders use.
struct RayBlock {
#define GXY_FIELD(type, name, primary, secondary) type name[BLOCK_RAYS];
  GXY_RAY_FIELDS(GXY_FIELD)
#undef GXY_FIELD
#define GXY_FIELD(type, name) type name[BLOCK_RAYS];
  GXY_DEVICE_FIELDS(GXY_FIELD)
#undef GXY_FIELD
};
inline constexpr size_t kRayBytes = sizeof(RayBlock) / BLOCK_RAYS;

/// Copies the rays `which` of a list of blocks, as RayList::gather() does.
RayList gather(const RayBlock* blocks, std::span<const int> which);

/// The lists of rays that are traced on the device: Given holds the rays of the batch's tiles or packets,
/// Here the secondaries that they make and that start in the same partition. Rays that go on behind
/// translucent surfaces are put into the other list of the pair (GivenOther, HereOther); the two take turns.
enum class List { Given, GivenOther, Here, HereOther };
inline List otherOf(List list) { return List(int(list) ^ 1); }

/// A stage, and what it works on.
struct Step {
  Stage stage;
  Special special;
  List list = List::Given;
  VkDescriptorSet scene = VK_NULL_HANDLE;  ///< read in place of the submission's scene, if there is one
  std::array<int32_t, PUSH_WORDS> push{};  ///< Lane sets PUSH_STEP, PUSH_ONE, PUSH_ROUNDS and PUSH_STAYING
};

/// The most rays that a list can hold on this device; bindings and the workgroups of a dispatch have limits.
size_t mostRays(const Device& device);

/// Bytes of a list of `rays` rays.
size_t listBytes(size_t rays);

/// Used by one thread at a time.
class Lane {
 public:
  Lane(const Device& device, Pipelines& pipelines);

  /// Makes room for `rays` given rays and up to `perHit` secondaries of each, and for a sample of `sampleWords` words of each
  /// (0: none). Throws Error if these are more
  /// than mostRays() together.
  void reserve(size_t rays, size_t perHit, size_t sampleWords = 0);
  /// Whether it has room for more than `rays` rays, given and made.
  bool isLargerThan(size_t rays) const;
  /// Copies the rays of a packet into the given list, from place `at` on.
  void load(const RayList& rays, size_t at, uint32_t packet);
  /// Does the same for the rays at `places` of a list at address `list` on the device. Returns the step that
  /// does so, which must be the first.
  Step take(VkDeviceAddress list, std::span<const uint32_t> places, size_t at, uint32_t packet);
  /// Such a step without rays, for its pipeline.
  static Step takeStep(const Device& device);

  /// Sets the tiles that are spawned.
  void load(std::span<const SpawnTile> tiles);

  /// Submits the steps from `firstStep` on. `resumed`: counts go on from the submission before; otherwise
  /// from zero.
  void submit(VkDescriptorSet scene, VkDescriptorSet frame, std::span<const Step> steps, size_t firstStep,
              bool resumed);
  /// Waits until they are done, and reads counts and clock.
  void wait();

  /// The list that receives rays that stay on the device; null: none stay. It is kept for the next batch if
  /// no ray has stayed.
  std::shared_ptr<KeptRays> staying;

  /// Device nanoseconds of a stage in the last submission that was waited for; 0 without a clock.
  uint64_t nanoseconds(Stage stage) const { return nanoseconds_[size_t(stage)]; }
  /// The device's clock, in nanoseconds, when the first stage began and when the last ended; 0 without a
  /// clock.
  uint64_t began() const { return began_; }
  uint64_t ended() const { return ended_; }
  /// The count COUNT_* of shaders/layout.h.
  uint32_t count(int which) const { return counted_[which]; }
  /// Rays that leave. A ray that stays on the device has only `packet`, `info` and `next` here.
  const RayBlock* leaving() const { return reinterpret_cast<const RayBlock*>(leaving_.mapped()); }
  const int32_t* records() const { return reinterpret_cast<const int32_t*>(records_.mapped()); }
  const uint32_t* depths() const { return reinterpret_cast<const uint32_t*>(depths_.mapped()); }

 private:
  size_t roomy(size_t bytes) const;
  void record(const Step& step, size_t number, VkDescriptorSet scene);
  void readClock();

  const Device& device_;
  Pipelines& pipelines_;
  Commands commands_;
  std::optional<Commands> copies_;  ///< for copying staging_
  VkCommandBuffer recording_ = VK_NULL_HANDLE;
  VkDescriptorSet boundScene_ = VK_NULL_HANDLE;  ///< while steps are recorded
  Buffer lists_[4], leaving_, records_, depths_, counts_, countsRead_, staging_, places_;
  DescriptorSet sets_[4];  ///< index: List
  size_t loaded_ = 0;      ///< number of rays that wait in staging_ to be copied
  uint32_t counted_[COUNT_WORDS] = {};
  QueryPoolHandle clock_;      ///< timestamps: at the beginning, behind each stage, and at the end
  uint32_t readings_ = 0;      ///< timestamps that were written
  std::vector<Stage> stages_;  ///< the stages with a timestamp behind them
  std::vector<Pipeline> bound_;
  uint64_t nanoseconds_[size_t(Stage::Last) + 1] = {}, began_ = 0, ended_ = 0;
};

}  // namespace gxy::vulkan

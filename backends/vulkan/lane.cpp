// SPDX-License-Identifier: Apache-2.0
#include "gxy/vulkan/lane.h"

#include <algorithm>
#include <bit>
#include <cstring>

namespace gxy::vulkan {

namespace {

constexpr uint32_t kReadings = 64;  // of the clock; stages beyond are not timed

size_t blocksOf(size_t rays) { return (rays + BLOCK_RAYS - 1) / BLOCK_RAYS; }

VkDescriptorBufferInfo whole(const Buffer& buffer) { return {buffer.get(), 0, VK_WHOLE_SIZE}; }

}  // namespace

RayList gather(const RayBlock* blocks, std::span<const int> which) {
  RayList list(int(which.size()));
  list.resize(int(which.size()));
  const RayView& view = list.view();
#define GXY_GATHER(type, name, primary, secondary) \
  if (primary || secondary)                        \
    for (size_t k = 0; k < which.size(); k++)      \
      view.name[k] = blocks[which[k] / BLOCK_RAYS].name[which[k] % BLOCK_RAYS];
  GXY_RAY_FIELDS(GXY_GATHER)
#undef GXY_GATHER
  return list;
}

Lane::Lane(const Device& device, Pipelines& pipelines)
    : device_(device),
      pipelines_(pipelines),
      commands_(device),
      counts_(device, COUNT_WORDS * sizeof(uint32_t), Place::Device, "counts"),
      countsRead_(device, COUNT_WORDS * sizeof(uint32_t), Place::Readback, "counts") {
  if (!device.limits().timestampComputeAndGraphics) return;
  VkQueryPoolCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO;
  info.queryType = VK_QUERY_TYPE_TIMESTAMP;
  info.queryCount = kReadings;
  VkQueryPool clock = VK_NULL_HANDLE;
  check(vkCreateQueryPool(device.get(), &info, nullptr, &clock), "making a clock");
  clock_ = QueryPoolHandle(device.get(), clock);
}

void Lane::reserve(size_t rays, size_t made) {
  if (rays <= rayCapacity_ && made <= madeCapacity_) return;
  rayCapacity_ = std::max(std::bit_ceil(rays), rayCapacity_);
  madeCapacity_ = std::max(std::bit_ceil(made), madeCapacity_);
  const size_t listBytes = blocksOf(rayCapacity_) * sizeof(RayBlock);
  for (DescriptorSet& set : sets_) set = {};
  for (Buffer* b : {&lists_[0], &lists_[1], &made_, &leaving_, &records_, &depths_, &staging_}) *b = {};
  for (Buffer& list : lists_) list = Buffer(device_, listBytes, Place::Device, "rays");
  if (!lists_[0].mapped()) staging_ = Buffer(device_, listBytes, Place::Readback, "rays");
  leaving_ = Buffer(device_, listBytes, Place::Readback, "rays");
  made_ = Buffer(device_, blocksOf(madeCapacity_) * sizeof(RayBlock), Place::Readback, "secondary rays");
  // a ray that meets a surface and ends there gives twice
  records_ =
      Buffer(device_, 2 * rayCapacity_ * RECORD_WORDS * sizeof(int32_t), Place::Readback, "contributions");
  depths_ = Buffer(device_, rayCapacity_ * DEPTH_WORDS * sizeof(uint32_t), Place::Readback, "depths");
  for (int i = 0; i < 2; i++) {
    const VkDescriptorBufferInfo buffers[LANE_BINDINGS] = {
        whole(lists_[i]), whole(lists_[1 - i]), whole(made_),  whole(leaving_),
        whole(records_),  whole(depths_),       whole(counts_)};
    sets_[i] = DescriptorSet(device_, pipelines_.setLayout(LANE_SET), buffers);
  }
}

void Lane::load(const RayList& list, int first, int count) {
  staged_ = lists_[turn_].mapped() == nullptr;
  auto* blocks = reinterpret_cast<RayBlock*>(staged_ ? staging_.mapped() : lists_[turn_].mapped());
  const RayView& view = list.view();
  for (int i = 0; i < count; i += BLOCK_RAYS) {
    RayBlock& block = blocks[i / BLOCK_RAYS];
    const size_t n = 4 * size_t(std::min(BLOCK_RAYS, count - i));
#define GXY_LOAD(type, name, primary, secondary) \
  if (primary || secondary) std::memcpy(block.name, view.name + first + i, n);
    GXY_RAY_FIELDS(GXY_LOAD)
#undef GXY_LOAD
  }
}

void Lane::begin(VkDescriptorSet scene, VkDescriptorSet frame, int rays) {
  rays_ = rays;
  recording_ = commands_.begin();
  const VkDescriptorSet sets[3] = {scene, frame, sets_[turn_].get()};
  vkCmdBindDescriptorSets(recording_, VK_PIPELINE_BIND_POINT_COMPUTE, pipelines_.layout(), 0, 3, sets, 0,
                          nullptr);
  vkCmdFillBuffer(recording_, counts_.get(), 0, VK_WHOLE_SIZE, 0);
  stages_.clear();
  if (clock_) {
    vkCmdResetQueryPool(recording_, clock_.get(), 0, kReadings);
    vkCmdWriteTimestamp(recording_, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, clock_.get(), 0);
  }
  if (staged_) {
    const VkBufferCopy region{0, 0, blocksOf(size_t(rays)) * sizeof(RayBlock)};
    vkCmdCopyBuffer(recording_, staging_.get(), lists_[turn_].get(), 1, &region);
    staged_ = false;
  }
}

void Lane::run(Stage stage, const Special& special, std::initializer_list<int32_t> words) {
  int32_t push[PUSH_WORDS] = {rays_};
  std::copy(words.begin(), words.end(), push + 1);
  push[PUSH_ONE] = 1;
  push[PUSH_ROUNDS] = 8;
  commands_.barrier();
  vkCmdBindPipeline(recording_, VK_PIPELINE_BIND_POINT_COMPUTE, pipelines_.get(stage, special));
  vkCmdPushConstants(recording_, pipelines_.layout(), VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof push, push);
  vkCmdDispatch(recording_, uint32_t(blocksOf(size_t(rays_))), 1, 1);
  if (!clock_ || stages_.size() + 1 >= kReadings) return;
  stages_.push_back(stage);
  vkCmdWriteTimestamp(recording_, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, clock_.get(),
                      uint32_t(stages_.size()));
}

void Lane::finish() {
  commands_.barrier();
  const VkBufferCopy region{0, 0, COUNT_WORDS * sizeof(uint32_t)};
  vkCmdCopyBuffer(recording_, counts_.get(), countsRead_.get(), 1, &region);
  commands_.barrier();
  commands_.submitAndWait();
  std::memcpy(counted_, countsRead_.mapped(), sizeof counted_);
  std::fill(std::begin(nanoseconds_), std::end(nanoseconds_), 0);
  if (stages_.empty()) return;
  uint64_t readings[kReadings];
  const size_t n = stages_.size() + 1;
  check(vkGetQueryPoolResults(device_.get(), clock_.get(), 0, uint32_t(n), n * sizeof(uint64_t), readings,
                              sizeof(uint64_t), VK_QUERY_RESULT_64_BIT),
        "reading the clock");
  for (size_t i = 0; i + 1 < n; i++) {
    const double ticks = double(readings[i + 1] - readings[i]);
    nanoseconds_[size_t(stages_[i])] += uint64_t(ticks * double(device_.limits().timestampPeriod));
  }
}

LanePool::Lease LanePool::take() {
  std::unique_ptr<Lane> lane;
  {
    std::lock_guard lock(mutex_);
    if (!idle_.empty()) {
      lane = std::move(idle_.back());
      idle_.pop_back();
    }
  }
  if (!lane) lane = std::make_unique<Lane>(device_, pipelines_);
  return {lane.release(), [this](Lane* used) {
            std::lock_guard lock(mutex_);
            idle_.emplace_back(used);
          }};
}

}  // namespace gxy::vulkan

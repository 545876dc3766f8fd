// SPDX-License-Identifier: Apache-2.0
#include "backends/vulkan/lane.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include "core/comm/error.h"

namespace gxy::vulkan {

namespace {

constexpr uint32_t kReadings = 128;  // most timestamps; further stages are not timed
// The place of the timestamps, behind the counts.
constexpr size_t kReadingsAt =
    (COUNT_WORDS * sizeof(uint32_t) + sizeof(uint64_t) - 1) / sizeof(uint64_t) * sizeof(uint64_t);

size_t blocksOf(size_t rays) { return (rays + BLOCK_RAYS - 1) / BLOCK_RAYS; }
uint32_t groupsOf(size_t rays) {
  return uint32_t((blocksOf(rays) + GROUP_ROWS - 1) / GROUP_ROWS * GROUP_ROWS);
}

// Samples take less than a list of their rays, so they fit a binding where that does.
static_assert(SAMPLE_WORDS + MOST_SAMPLED_FIELDS + 3 <= kRayBytes / sizeof(int32_t));

// A list is bound as a storage buffer and as texels.
size_t largestList(const Device& device) {
  const VkPhysicalDeviceLimits& limits = device.limits();
  return std::min<size_t>(limits.maxStorageBufferRange, limits.maxTexelBufferElements * sizeof(uint32_t));
}

Binding whole(const Buffer& buffer) { return {{buffer.get(), 0, VK_WHOLE_SIZE}}; }

void putAddress(std::array<int32_t, PUSH_WORDS>& push, int word, VkDeviceAddress address) {
  push[size_t(word)] = int32_t(uint32_t(address));
  push[size_t(word) + 1] = int32_t(uint32_t(address >> 32));
}

}  // namespace

size_t listBytes(size_t rays) { return blocksOf(std::max<size_t>(rays, 1)) * sizeof(RayBlock); }

size_t mostRays(const Device& device) {
  const size_t blocks = largestList(device) / sizeof(RayBlock);
  return std::min(blocks, device.limits().maxComputeWorkGroupCount[0] / GROUP_ROWS * size_t(GROUP_ROWS)) *
         BLOCK_RAYS;
}

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
      countsRead_(device, kReadingsAt + kReadings * sizeof(uint64_t), Place::Readback, "counts") {
  if (device.clockBits() == 0) return;
  VkQueryPoolCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO;
  info.queryType = VK_QUERY_TYPE_TIMESTAMP;
  info.queryCount = kReadings;
  VkQueryPool clock = VK_NULL_HANDLE;
  check(vkCreateQueryPool(device.get(), &info, nullptr, &clock), "making a clock");
  clock_ = QueryPoolHandle(device.get(), clock);
}

// Rounds a size up, so that buffers seldom have to grow.
size_t Lane::roomy(size_t bytes) const {
  return std::min<size_t>(std::bit_ceil(bytes), device_.limits().maxStorageBufferRange);
}

bool Lane::isLargerThan(size_t rays) const { return leaving_.bytes() > roomy(listBytes(rays)); }

void Lane::reserve(size_t rays, size_t perHit, size_t sampleWords) {
  const size_t here = rays * perHit, all = rays + here, most = mostRays(device_);
  if (all > most)
    throw Error("Vulkan: device \"" + device_.info().name + "\" takes lists of up to " +
                std::to_string(most) + " rays, not " + std::to_string(rays) + " with up to " +
                std::to_string(perHit) + " secondary rays each; fewer lights or occlusion rays would do");
  struct Need {
    Buffer& buffer;
    size_t bytes;
    Place place;
    const char* what;
  };
  const size_t given = listBytes(rays);
  const Need needs[] = {
      {lists_[int(List::Given)], given, Place::Device, "rays"},
      {lists_[int(List::GivenOther)], given, Place::Device, "rays"},
      {lists_[int(List::Here)], listBytes(here), Place::Device, "secondary rays"},
      {lists_[int(List::HereOther)], listBytes(here), Place::Device, "secondary rays"},
      {leaving_, listBytes(all), Place::Readback, "rays"},
      // A primary that meets a surface and ends there contributes twice.
      {records_, std::max((rays + all) * RECORD_WORDS, rays * sampleWords) * sizeof(int32_t), Place::Readback,
       "contributions"},
      {depths_, rays * DEPTH_WORDS * sizeof(uint32_t), Place::Readback, "depths"}};
  const auto lacks = [](const Need& n) { return n.buffer.bytes() < n.bytes; };
  if (std::none_of(std::begin(needs), std::end(needs), lacks)) return;
  for (DescriptorSet& set : sets_) set = {};
  staging_ = {};
  for (const Need& n : needs)
    if (lacks(n)) n.buffer = {};
  for (const Need& n : needs)
    if (!n.buffer.get()) n.buffer = Buffer(device_, roomy(n.bytes), n.place, n.what);
  if (!lists_[0].mapped()) {
    staging_ = Buffer(device_, lists_[0].bytes(), Place::Readback, "rays");
    if (!copies_) copies_.emplace(device_, Work::Copies);
  }
  for (int list = 0; list < 4; list++) {
    const Binding buffers[LANE_BINDINGS] = {
        whole(lists_[list]),
        whole(lists_[int(otherOf(List(list)))]),
        whole(lists_[int(List::Here)]),
        whole(leaving_),
        whole(records_),
        whole(depths_),
        whole(counts_),
        {{lists_[list].get(), 0, std::min(lists_[list].bytes(), largestList(device_))}, VK_FORMAT_R32_UINT},
        {{records_.get(), 0, std::min(records_.bytes(), largestList(device_))}, VK_FORMAT_R32_UINT}};
    sets_[list] = DescriptorSet(device_, pipelines_.setLayout(LANE_SET), buffers);
  }
}

void Lane::load(const RayList& rays, size_t at, uint32_t packet) {
  auto* blocks = reinterpret_cast<RayBlock*>((staging_.get() ? staging_ : lists_[0]).mapped());
  const RayView& view = rays.view();
  for (size_t i = 0; i < size_t(rays.size());) {
    RayBlock& block = blocks[(at + i) / BLOCK_RAYS];
    const size_t to = (at + i) % BLOCK_RAYS, n = std::min(BLOCK_RAYS - to, size_t(rays.size()) - i);
#define GXY_LOAD(type, name, primary, secondary) \
  if (primary || secondary) std::memcpy(block.name + to, view.name + i, 4 * n);
    GXY_RAY_FIELDS(GXY_LOAD)
#undef GXY_LOAD
    std::fill_n(block.packet + to, n, packet);
    std::fill_n(block.step + to, n, 0);
    i += n;
  }
  if (staging_.get()) loaded_ = at + size_t(rays.size());
}

Step Lane::takeStep(const Device& device) {
  Step step{Stage::Take, {}};
  step.special.limited = device.endsLoops();
  return step;
}

Step Lane::take(VkDeviceAddress list, std::span<const uint32_t> places, size_t at, uint32_t packet) {
  if (!places_.get() || places_.bytes() < lists_[0].bytes() / kRayBytes * sizeof(uint32_t))
    places_ =
        Buffer(device_, lists_[0].bytes() / kRayBytes * sizeof(uint32_t), Place::Written, "numbers of rays");
  std::memcpy(places_.mapped() + at * sizeof(uint32_t), places.data(), places.size_bytes());
  Step step = takeStep(device_);
  step.push[PUSH_RAYS] = int32_t(places.size());
  putAddress(step.push, PUSH_TAKEN, list);
  putAddress(step.push, PUSH_PLACES, places_.address() + at * sizeof(uint32_t));
  step.push[PUSH_FIRST] = int32_t(at);
  step.push[PUSH_PACKET] = int32_t(packet);
  return step;
}

void Lane::load(std::span<const SpawnTile> tiles) {
  static_assert(sizeof(SpawnTile) == RECORD_WORDS * sizeof(int32_t) && TILE_RAYS == kTile * kTile);
  std::memcpy(records_.mapped(), tiles.data(), tiles.size_bytes());
}

void Lane::record(const Step& step, size_t number, VkDescriptorSet scene) {
  std::array<int32_t, PUSH_WORDS> push = step.push;
  putAddress(push, PUSH_STAYING, staying ? staying->address() : 0);
  push[PUSH_STEP] = int32_t(number);
  push[PUSH_ONE] = 1;
  push[PUSH_ROUNDS] = 8;
  commands_.barrier();
  const VkDescriptorSet read = step.scene ? step.scene : scene;
  if (read != boundScene_)
    vkCmdBindDescriptorSets(recording_, VK_PIPELINE_BIND_POINT_COMPUTE, pipelines_.layout(), SCENE_SET, 1,
                            &read, 0, nullptr);
  boundScene_ = read;
  const VkDescriptorSet set = sets_[int(step.list)].get();
  vkCmdBindDescriptorSets(recording_, VK_PIPELINE_BIND_POINT_COMPUTE, pipelines_.layout(), LANE_SET, 1, &set,
                          0, nullptr);
  bound_.push_back(pipelines_.get(step.stage, step.special));
  vkCmdBindPipeline(recording_, VK_PIPELINE_BIND_POINT_COMPUTE, bound_.back()->get());
  vkCmdPushConstants(recording_, pipelines_.layout(), VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof push,
                     push.data());
  if (step.stage == Stage::Groups)
    vkCmdDispatch(recording_, 1, 1, 1);
  else if (push[PUSH_RAYS] < 0)
    vkCmdDispatchIndirect(recording_, counts_.get(), COUNT_GROUPS * sizeof(uint32_t));
  else
    vkCmdDispatch(recording_, groupsOf(size_t(push[PUSH_RAYS])), 1, 1);
  if (!clock_ || stages_.size() + 2 >= kReadings) return;
  stages_.push_back(step.stage);
  readClock();
}

void Lane::readClock() {
  if (!clock_) return;
  vkCmdWriteTimestamp(recording_, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, clock_.get(), readings_++);
}

void Lane::submit(VkDescriptorSet scene, VkDescriptorSet frame, std::span<const Step> steps, size_t firstStep,
                  bool resumed) {
  recording_ = commands_.begin();
  stages_.clear();
  bound_.clear();
  readings_ = 0;
  if (clock_) vkCmdResetQueryPool(recording_, clock_.get(), 0, kReadings);
  readClock();
  const VkDescriptorSet sets[2] = {scene, frame};
  vkCmdBindDescriptorSets(recording_, VK_PIPELINE_BIND_POINT_COMPUTE, pipelines_.layout(), SCENE_SET, 2, sets,
                          0, nullptr);
  boundScene_ = scene;
  const VkDeviceSize cut = COUNT_CUT * sizeof(uint32_t);
  if (resumed)
    vkCmdFillBuffer(recording_, counts_.get(), cut, sizeof(uint32_t), 0);
  else
    vkCmdFillBuffer(recording_, counts_.get(), 0, VK_WHOLE_SIZE, 0);
  for (size_t i = firstStep; i < steps.size(); i++) record(steps[i], i, scene);
  commands_.barrier();
  const VkBufferCopy region{0, 0, COUNT_WORDS * sizeof(uint32_t)};
  vkCmdCopyBuffer(recording_, counts_.get(), countsRead_.get(), 1, &region);
  readClock();
  // The device copies the timestamps, because Mesa's vkGetQueryPoolResults waits until a software device has
  // nothing left to do.
  if (clock_)
    vkCmdCopyQueryPoolResults(recording_, clock_.get(), 0, readings_, countsRead_.get(), kReadingsAt,
                              sizeof(uint64_t), VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT);
  commands_.barrier();
  uint64_t copied = 0;
  if (loaded_ > 0) {
    const VkBufferCopy rays{0, 0, listBytes(loaded_)};
    vkCmdCopyBuffer(copies_->begin(), staging_.get(), lists_[0].get(), 1, &rays);
    copied = copies_->submit();
    loaded_ = 0;
  }
  commands_.submit(copied);
}

void Lane::wait() {
  commands_.wait();
  std::memcpy(counted_, countsRead_.mapped(), sizeof counted_);
  std::fill(std::begin(nanoseconds_), std::end(nanoseconds_), 0);
  if (readings_ == 0) return;
  uint64_t readings[kReadings];
  // The clock may start again at 0 in between.
  const uint64_t mask = ~uint64_t(0) >> (64 - device_.clockBits());
  std::memcpy(readings, countsRead_.mapped() + kReadingsAt, readings_ * sizeof(uint64_t));
  const auto inNanoseconds = [&](uint64_t ticks) {
    return uint64_t(double(ticks) * double(device_.limits().timestampPeriod));
  };
  for (size_t i = 0; i < stages_.size(); i++)
    nanoseconds_[size_t(stages_[i])] += inNanoseconds((readings[i + 1] - readings[i]) & mask);
  began_ = inNanoseconds(readings[0]);
  ended_ = inNanoseconds(readings[readings_ - 1]);
}

}  // namespace gxy::vulkan

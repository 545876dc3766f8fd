// SPDX-License-Identifier: Apache-2.0
#include "backends/vulkan/vulkan_device.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <optional>

namespace gxy::vulkan {

namespace {

constexpr VkMemoryPropertyFlags kSeen =
    VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
constexpr size_t kStagingBytes = size_t(16) << 20, kBlockBytes = size_t(64) << 20;

std::string mebibytes(size_t bytes) { return std::to_string((bytes + (1 << 20) - 1) >> 20) + " MiB"; }

}  // namespace

Device::Device(const VulkanOptions& options)
    : instance_(options),
      physical_(chooseDevice(instance_, options)),
      info_(infoOf(physical_)),
      software_(info_.kind == VulkanDeviceInfo::Kind::Software && !options.asGpu),
      lostAfter_(options.lostAfter),
      lostInWaits_(options.lostInWaits),
      hidesMemory_(options.hidesMemory) {
  VkPhysicalDeviceDriverProperties driver{};
  driver.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES;
  VkPhysicalDeviceMaintenance3Properties allocations{};
  allocations.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MAINTENANCE_3_PROPERTIES;
  allocations.pNext = &driver;
  VkPhysicalDeviceProperties2 properties{};
  properties.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2;
  properties.pNext = &allocations;
  vkGetPhysicalDeviceProperties2(physical_, &properties);
  limits_ = properties.properties.limits;
  endsLoops_ = software_ && driver.driverID == VK_DRIVER_ID_MESA_LLVMPIPE;
  largestAllocation_ = size_t(allocations.maxMemoryAllocationSize);
  if (options.allocationBytes > 0)
    largestAllocation_ = std::min<size_t>(largestAllocation_, options.allocationBytes);
  // An int is the index of a texel.
  largestBinding_ = std::min<size_t>(limits_.maxTexelBufferElements, INT32_MAX) * sizeof(uint32_t);
  if (options.bindingBytes > 0) largestBinding_ = std::min<size_t>(largestBinding_, options.bindingBytes);
  // Where lanes fetch one after the other, a word of a quad is as cheap as a word by itself. Mesa finds bytes
  // by an int.
  if (endsLoops_)
    largestQuads_ =
        std::min<size_t>(size_t(limits_.maxTexelBufferElements) * 4 * sizeof(uint32_t), INT32_MAX);
  if (options.quadBytes > 0) largestQuads_ = std::min<size_t>(largestQuads_, options.quadBytes);
  largestStorage_ = limits_.maxStorageBufferRange;
  if (options.storageBytes > 0) largestStorage_ = std::min<size_t>(largestStorage_, options.storageBytes);
  vkGetPhysicalDeviceMemoryProperties(physical_, &memory_);
  const uint32_t family = uint32_t(computeFamily(physical_));
  const int copies = copyFamily(physical_);
  queues_[size_t(Work::Stages)].family = family;
  queues_[size_t(Work::Copies)].family = copies < 0 ? family : uint32_t(copies);
  clockBits_ = familiesOf(physical_)[family].timestampValidBits;
  const float priority = 1;
  VkDeviceQueueCreateInfo queues[2]{};
  for (size_t i = 0; i < 2; i++) {
    queues[i].sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO;
    queues[i].queueFamilyIndex = queues_[i].family;
    queues[i].queueCount = 1;
    queues[i].pQueuePriorities = &priority;
  }
  Features features;
  features.v12.bufferDeviceAddress = VK_TRUE;
  features.v12.timelineSemaphore = VK_TRUE;
  features.v10.features.shaderFloat64 = VK_TRUE;
  features.v10.features.shaderInt64 = VK_TRUE;
  VkDeviceCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO;
  info.pNext = &features.v10;
  info.queueCreateInfoCount = copiesBeside() ? 2 : 1;
  info.pQueueCreateInfos = queues;
  VkDevice device = VK_NULL_HANDLE;
  check(vkCreateDevice(physical_, &info, nullptr, &device), "opening device \"" + info_.name + "\"");
  device_.reset(device);
  const VkDeviceSize block = std::min<VkDeviceSize>({kBlockBytes, info_.memory / 16, largestAllocation_});
  LedgerEntry account;
  if (options.ledger) account = options.ledger->enter("device", "vulkan", 0);
  blocks_ = std::make_unique<Memory>(device, block, std::move(account), options.memoryBytes);
  const VkSemaphoreTypeCreateInfo type{VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO, nullptr,
                                       VK_SEMAPHORE_TYPE_TIMELINE, 0};
  const VkSemaphoreCreateInfo semaphore{VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO, &type, 0};
  for (Queue& queue : queues_) {
    vkGetDeviceQueue(device, queue.family, 0, &queue.queue);
    VkSemaphore done = VK_NULL_HANDLE;
    check(vkCreateSemaphore(device, &semaphore, nullptr, &done), "making a semaphore");
    queue.done = SemaphoreHandle(device, done);
  }
}

uint64_t Device::clockRound() const {
  const double round = std::ldexp(double(limits_.timestampPeriod), int(clockBits_));
  return clockBits_ > 0 && round < 0x1p62 ? uint64_t(round) : 0;
}

uint64_t Device::submit(Work work, VkCommandBuffer commands, uint64_t after) const {
  std::lock_guard lock(queueMutex_);
  const Queue &queue = queues_[size_t(work)], &other = queues_[size_t(work) ^ 1];
  const uint64_t number = submitted_ + 1, first = std::max(after, other.waitedFor);
  const VkSemaphore done = queue.done.get(), otherDone = other.done.get();
  const VkPipelineStageFlags all = VK_PIPELINE_STAGE_ALL_COMMANDS_BIT;
  const uint32_t waits = first > 0 ? 1 : 0;
  VkTimelineSemaphoreSubmitInfo timeline{};
  timeline.sType = VK_STRUCTURE_TYPE_TIMELINE_SEMAPHORE_SUBMIT_INFO;
  timeline.waitSemaphoreValueCount = waits;
  timeline.pWaitSemaphoreValues = &first;
  timeline.signalSemaphoreValueCount = 1;
  timeline.pSignalSemaphoreValues = &number;
  VkSubmitInfo info{};
  info.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO;
  info.pNext = &timeline;
  info.waitSemaphoreCount = waits;
  info.pWaitSemaphores = &otherDone;
  info.pWaitDstStageMask = &all;
  info.commandBufferCount = 1;
  info.pCommandBuffers = &commands;
  info.signalSemaphoreCount = 1;
  info.pSignalSemaphores = &done;
  heed(isLost(number) && !lostInWaits_ ? VK_ERROR_DEVICE_LOST
                                       : vkQueueSubmit(queue.queue, 1, &info, VK_NULL_HANDLE),
       "handing work to");
  submitted_ = number;
  return number;
}

void Device::wait(Work work, uint64_t submission) const {
  const Queue& queue = queues_[size_t(work)];
  const VkSemaphore done = queue.done.get();
  VkSemaphoreWaitInfo info{};
  info.sType = VK_STRUCTURE_TYPE_SEMAPHORE_WAIT_INFO;
  info.semaphoreCount = 1;
  info.pSemaphores = &done;
  info.pValues = &submission;
  const VkResult waited = vkWaitSemaphores(device_.get(), &info, UINT64_MAX);
  heed(isLost(submission) ? VK_ERROR_DEVICE_LOST : waited, "waiting for");
  std::lock_guard lock(queueMutex_);
  queue.waitedFor = std::max(queue.waitedFor, submission);
}

void Device::heed(VkResult result, const char* doing) const {
  if (result == VK_ERROR_DEVICE_LOST) lost_ = true;
  check(result, std::string(doing) + " device \"" + info_.name + "\"");
}

uint32_t Device::memoryType(uint32_t allowed, Place place) const {
  constexpr VkMemoryPropertyFlags kLocal = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
  constexpr VkMemoryPropertyFlags kCached = VK_MEMORY_PROPERTY_HOST_CACHED_BIT;
  const VkMemoryPropertyFlags needed = place == Place::Device ? kLocal : kSeen;
  const VkMemoryPropertyFlags wanted = place == Place::Device    ? kSeen
                                       : place == Place::Written ? kLocal
                                                                 : kCached;
  // Device memory that the host sees is preferred if it is about all of the device's memory, not if it is a
  // small window.
  int found = -1, score = -1;
  for (uint32_t i = 0; i < memory_.memoryTypeCount; i++) {
    const VkMemoryType& type = memory_.memoryTypes[i];
    if (!(allowed & (1u << i)) || (type.propertyFlags & needed) != needed) continue;
    const bool big = memory_.memoryHeaps[type.heapIndex].size * 2 >= info_.memory;
    const int mine =
        ((type.propertyFlags & wanted) == wanted ? 1 : 0) + (place == Place::Device && big ? 2 : 0);
    if (mine > score) found = int(i), score = mine;
  }
  if (found < 0) throw Error("Vulkan: device \"" + info_.name + "\" has no memory of a kind that is needed");
  return uint32_t(found);
}

Error Device::noRoom(size_t bytes, size_t heap, const std::string& what) const {
  return Error("Vulkan: device \"" + info_.name + "\" has no " + mebibytes(bytes) + " left for " + what +
               ": it has " + mebibytes(heap) + ", of which this rank holds " + mebibytes(bytes_) +
               "; more ranks with devices of their own, or the embree backend, would do");
}

VkDeviceSize Device::heapOf(uint32_t type) const {
  return memory_.memoryHeaps[memory_.memoryTypes[type].heapIndex].size;
}

BufferHandle Device::makeBuffer(size_t bytes, const std::string& what) const {
  VkBufferCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO;
  info.size = bytes;
  info.usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT |
               VK_BUFFER_USAGE_TRANSFER_DST_BIT | VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT |
               VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT;
  const uint32_t families[2] = {queueFamily(Work::Stages), queueFamily(Work::Copies)};
  if (copiesBeside()) {
    info.sharingMode = VK_SHARING_MODE_CONCURRENT;
    info.queueFamilyIndexCount = 2;
    info.pQueueFamilyIndices = families;
  }
  VkBuffer buffer = VK_NULL_HANDLE;
  check(vkCreateBuffer(device_.get(), &info, nullptr, &buffer), "making a buffer for " + what);
  return {device_.get(), buffer};
}

void Device::expectPossible(const VkMemoryRequirements& needs, uint32_t type, const std::string& what) const {
  if (needs.size > heapOf(type)) throw noRoom(needs.size, heapOf(type), what);
  if (needs.size > largestAllocation_)
    throw Error("Vulkan: device \"" + info_.name + "\" gives no " + mebibytes(needs.size) + " for " + what +
                " at once, expected up to " + mebibytes(largestAllocation_) +
                " (maxMemoryAllocationSize); cut the data into more partitions");
}

void Device::expectRoom(std::span<const size_t> sizes, const std::string& what) const {
  std::vector<VkDeviceSize> needed;
  uint32_t type = 0;
  size_t sum = 0;
  for (const size_t bytes : sizes) {
    if (bytes > info_.memory) throw noRoom(bytes, info_.memory, what);
    const BufferHandle buffer = makeBuffer(std::max<size_t>(bytes, 16), what);
    VkMemoryRequirements needs;
    vkGetBufferMemoryRequirements(device_.get(), buffer.get(), &needs);
    type = memoryType(needs.memoryTypeBits, Place::Device);  // the same for all, as they differ only in size
    expectPossible(needs, type, what);
    needed.push_back(needs.size);
    sum += bytes;
  }
  if (!blocks_->gives(type, needed)) throw noRoom(sum, heapOf(type), what + " in all");
}

Buffer::Buffer(const Device& device, size_t bytes, Place place, const char* what)
    : device_(&device), bytes_(std::max<size_t>(bytes, 16)) {
  if (place == Place::Device && bytes_ > device.info().memory)
    throw device.noRoom(bytes_, device.info().memory, what);
  buffer_ = device.makeBuffer(bytes_, what);
  const VkBuffer buffer = buffer_.get();
  VkMemoryRequirements needs;
  vkGetBufferMemoryRequirements(device.get(), buffer, &needs);
  const uint32_t type = device.memoryType(needs.memoryTypeBits, place);
  const bool visible = (device.memory_.memoryTypes[type].propertyFlags & kSeen) == kSeen &&
                       !(place == Place::Device && device.hidesMemory_);
  device.expectPossible(needs, type, what);
  memory_ = device.blocks_->take(type, visible, needs.size, needs.alignment);
  if (!memory_.memory()) throw device.noRoom(bytes_, device.heapOf(type), what);
  check(vkBindBufferMemory(device.get(), buffer, memory_.memory(), memory_.offset()), "binding memory");
  if (visible) mapped_ = memory_.mapped();
  device.bytes_ += bytes_;
  counted_ = {reinterpret_cast<void*>(bytes_), Uncount{&device.bytes_}};
}

VkDeviceAddress Buffer::address() const {
  VkBufferDeviceAddressInfo info{};
  info.sType = VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO;
  info.buffer = buffer_.get();
  return vkGetBufferDeviceAddress(device_->get(), &info);
}

Commands::Commands(const Device& device, Work work) : device_(device), work_(work) {
  VkCommandPoolCreateInfo pool{};
  pool.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO;
  pool.flags = VK_COMMAND_POOL_CREATE_TRANSIENT_BIT;
  pool.queueFamilyIndex = device.queueFamily(work);
  VkCommandPool made = VK_NULL_HANDLE;
  check(vkCreateCommandPool(device.get(), &pool, nullptr, &made), "making a command pool");
  pool_ = CommandPoolHandle(device.get(), made);
  VkCommandBufferAllocateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO;
  info.commandPool = made;
  info.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
  info.commandBufferCount = 1;
  check(vkAllocateCommandBuffers(device.get(), &info, &commands_), "making a command buffer");
}

VkCommandBuffer Commands::begin() {
  check(vkResetCommandPool(device_.get(), pool_.get(), 0), "beginning commands");
  VkCommandBufferBeginInfo info{};
  info.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO;
  info.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  check(vkBeginCommandBuffer(commands_, &info), "beginning commands");
  return commands_;
}

void Commands::barrier() {
  constexpr VkAccessFlags kWritten = VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_TRANSFER_WRITE_BIT;
  VkMemoryBarrier barrier{};
  barrier.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER;
  barrier.srcAccessMask = kWritten;
  barrier.dstAccessMask = kWritten | VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_TRANSFER_READ_BIT |
                          VK_ACCESS_HOST_READ_BIT | VK_ACCESS_INDIRECT_COMMAND_READ_BIT;
  constexpr VkPipelineStageFlags kDevice =
      VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_TRANSFER_BIT;
  vkCmdPipelineBarrier(commands_, kDevice,
                       kDevice | VK_PIPELINE_STAGE_DRAW_INDIRECT_BIT | VK_PIPELINE_STAGE_HOST_BIT, 0, 1,
                       &barrier, 0, nullptr, 0, nullptr);
}

uint64_t Commands::submit(uint64_t after) {
  check(vkEndCommandBuffer(commands_), "recording commands");
  submission_ = device_.submit(work_, commands_, after);
  return submission_;
}

void upload(const Device& device, const Buffer& buffer, size_t offset, std::span<const std::byte> bytes,
            const Advance& advance) {
  if (buffer.mapped()) {
    for (size_t at = 0; at < bytes.size(); at += kStagingBytes) {
      advance(double(at) / double(bytes.size()));
      std::memcpy(buffer.mapped() + offset + at, bytes.data() + at,
                  std::min(bytes.size() - at, kStagingBytes));
    }
    return;
  }
  // Two pieces in turn: one is filled while the device copies the other.
  struct Piece {
    Buffer staging;
    Commands commands;
    Piece(const Device& device, size_t size)
        : staging(device, size, Place::Readback, "copies to the device"), commands(device, Work::Copies) {}
    ~Piece() {
      try {
        commands.wait();
      } catch (const Error&) {
        // The device is lost; whoever waits for it next is told.
      }
    }
  };
  const size_t size = std::min(bytes.size(), kStagingBytes);
  std::array<std::optional<Piece>, 2> pieces;
  for (size_t at = 0, turn = 0; at < bytes.size(); at += size, turn ^= 1) {
    advance(double(at) / double(bytes.size()));
    std::optional<Piece>& piece = pieces[turn];
    if (piece) piece->commands.wait();
    if (!piece) piece.emplace(device, size);
    const size_t n = std::min(bytes.size() - at, size);
    std::memcpy(piece->staging.mapped(), bytes.data() + at, n);
    const VkBufferCopy region{0, offset + at, n};
    vkCmdCopyBuffer(piece->commands.begin(), piece->staging.get(), buffer.get(), 1, &region);
    piece->commands.submit();
  }
  for (const std::optional<Piece>& piece : pieces)
    if (piece) piece->commands.wait();
}

}  // namespace gxy::vulkan

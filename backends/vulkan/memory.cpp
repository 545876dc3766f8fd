// SPDX-License-Identifier: Apache-2.0
#include "backends/vulkan/memory.h"

#include <algorithm>
#include <iterator>
#include <utility>
#include <vector>

namespace gxy::vulkan {

struct Memory::Block {
  uint32_t type;
  VkDeviceSize bytes;
  MemoryHandle memory;
  std::byte* mapped;
  std::map<VkDeviceSize, VkDeviceSize> free;  ///< offset, bytes; no two touch
};

Memory::Range::Range(Range&& other) noexcept { *this = std::move(other); }

Memory::Range& Memory::Range::operator=(Range&& other) noexcept {
  std::swap(owner_, other.owner_);
  std::swap(block_, other.block_);
  std::swap(offset_, other.offset_);
  std::swap(bytes_, other.bytes_);
  return *this;
}

Memory::Range::~Range() {
  if (owner_) owner_->giveBack(*this);
}

VkDeviceMemory Memory::Range::memory() const { return block_ ? block_->memory.get() : VK_NULL_HANDLE; }

std::byte* Memory::Range::mapped() const {
  return block_ && block_->mapped ? block_->mapped + offset_ : nullptr;
}

Memory::Memory(VkDevice device, VkDeviceSize blockBytes, LedgerEntry account, VkDeviceSize most)
    : device_(device), blockBytes_(blockBytes), most_(most), account_(std::move(account)) {}

Memory::~Memory() = default;

VkResult Memory::allocate(uint32_t type, VkDeviceSize bytes, VkDeviceMemory& memory,
                          VkDeviceSize besides) const {
  if (most_ > 0 && bytes_ + besides + bytes > most_) return VK_ERROR_OUT_OF_DEVICE_MEMORY;
  const VkMemoryAllocateFlagsInfo flags{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO, nullptr,
                                        VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT, 0};
  const VkMemoryAllocateInfo info{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, &flags, bytes, type};
  const VkResult result = vkAllocateMemory(device_, &info, nullptr, &memory);
  return result == VK_ERROR_OUT_OF_HOST_MEMORY ? VK_ERROR_OUT_OF_DEVICE_MEMORY : result;
}

bool Memory::gives(uint32_t type, std::span<const VkDeviceSize> sizes) const {
  std::lock_guard lock(mutex_);
  std::vector<MemoryHandle> taken;
  VkDeviceSize sum = 0;
  for (const VkDeviceSize bytes : sizes) {
    if (bytes < blockBytes_ / 2) continue;
    VkDeviceMemory memory = VK_NULL_HANDLE;
    const VkResult result = allocate(type, bytes, memory, sum);
    if (result == VK_ERROR_OUT_OF_DEVICE_MEMORY) return false;
    check(result, "allocating memory");
    taken.emplace_back(device_, memory);
    sum += bytes;
  }
  return true;
}

Memory::Range Memory::take(uint32_t type, bool visible, VkDeviceSize bytes, VkDeviceSize alignment) {
  std::lock_guard lock(mutex_);
  const auto cut = [&](Block& block) {
    Range range;
    for (auto hole = block.free.begin(); hole != block.free.end(); ++hole) {
      const auto [begin, size] = *hole;
      const VkDeviceSize at = (begin + alignment - 1) / alignment * alignment;
      if (at + bytes > begin + size) continue;
      block.free.erase(hole);
      if (at > begin) block.free[begin] = at - begin;
      if (at + bytes < begin + size) block.free[at + bytes] = begin + size - (at + bytes);
      range.owner_ = this;
      range.block_ = &block;
      range.offset_ = at;
      range.bytes_ = bytes;
      break;
    }
    return range;
  };
  const bool alone = bytes >= blockBytes_ / 2;
  if (!alone)
    for (Block& block : blocks_)
      if (block.type == type && block.bytes == blockBytes_ && (block.mapped != nullptr) == visible)
        if (Range range = cut(block); range.block_) return range;
  VkDeviceSize size = alone ? bytes : blockBytes_;
  VkDeviceMemory memory = VK_NULL_HANDLE;
  VkResult result = allocate(type, size, memory);
  if (result != VK_SUCCESS && !alone) {  // there may be room for less
    size = bytes;
    result = allocate(type, size, memory);
  }
  if (result == VK_ERROR_OUT_OF_DEVICE_MEMORY) return {};
  check(result, "allocating memory");
  MemoryHandle owned(device_, memory);
  void* mapped = nullptr;
  if (visible) check(vkMapMemory(device_, memory, 0, VK_WHOLE_SIZE, 0, &mapped), "mapping memory");
  Block& block =
      blocks_.emplace_back(Block{type, size, std::move(owned), static_cast<std::byte*>(mapped), {{0, size}}});
  bytes_ += block.bytes;
  account();
  return cut(block);
}

void Memory::giveBack(Range& range) {
  std::lock_guard lock(mutex_);
  Block& block = *range.block_;
  auto hole = block.free.emplace(range.offset_, range.bytes_).first;
  if (const auto next = std::next(hole);
      next != block.free.end() && hole->first + hole->second == next->first) {
    hole->second += next->second;
    block.free.erase(next);
  }
  if (hole != block.free.begin())
    if (const auto before = std::prev(hole); before->first + before->second == hole->first) {
      before->second += hole->second;
      block.free.erase(hole);
    }
  if (block.free.begin()->second < block.bytes) return;
  bytes_ -= block.bytes;
  account();
  blocks_.remove_if([&](const Block& b) { return &b == &block; });
}

void Memory::chargeElsewhere(int64_t bytes) {
  std::lock_guard lock(mutex_);
  elsewhere_ += bytes;
  account();
}

VkDeviceSize Memory::bytes() const {
  std::lock_guard lock(mutex_);
  return bytes_;
}

size_t Memory::blocks() const {
  std::lock_guard lock(mutex_);
  return blocks_.size();
}

}  // namespace gxy::vulkan

// SPDX-License-Identifier: Apache-2.0
// A device's memory in a few large blocks, out of which buffers are cut.
#pragma once
#include <cstddef>
#include <list>
#include <map>
#include <mutex>
#include <span>

#include "backends/vulkan/vulkan_handle.h"
#include "core/space/ledger.h"

namespace gxy::vulkan {

/// Blocks of one device. What is as large as half a block or larger has one of its own. The lowest place that is large enough
/// is taken; a block that is empty is given back, so that nothing is held when nothing is used. Thread safe.
class Memory {
 public:
  struct Block;
  /// A part of a block. Move-only.
  class Range {
   public:
    Range() = default;
    Range(Range&& other) noexcept;
    Range& operator=(Range&& other) noexcept;
    ~Range();
    VkDeviceMemory memory() const;
    VkDeviceSize offset() const { return offset_; }
    /// As the host sees it; null if it does not.
    std::byte* mapped() const;

   private:
    friend class Memory;
    Memory* owner_ = nullptr;
    Block* block_ = nullptr;
    VkDeviceSize offset_ = 0, bytes_ = 0;
  };

  /// `account`: of the blocks' sizes, less what is charged elsewhere; in a ledger or not. `most`: the device gives no more; 0:
  /// as much as it does.
  Memory(VkDevice device, VkDeviceSize blockBytes, LedgerEntry account, VkDeviceSize most);
  ~Memory();
  Memory(const Memory&) = delete;
  Memory& operator=(const Memory&) = delete;

  /// Of a memory type, which the host sees or not. Empty (memory() is null) where the device has no room.
  Range take(uint32_t type, bool visible, VkDeviceSize bytes, VkDeviceSize alignment);
  /// Whether the device gives blocks for all of these at once, besides what it has given; asked by taking them for a moment. What
  /// is smaller than half a block is left out, as it may fit into blocks that there are.
  bool gives(uint32_t type, std::span<const VkDeviceSize> sizes) const;
  /// So many bytes more (or fewer) of what is taken are in others' accounts.
  void chargeElsewhere(int64_t bytes);
  /// Of all blocks.
  VkDeviceSize bytes() const;
  size_t blocks() const;

 private:
  /// `besides`: bytes that are taken and not in a block.
  VkResult allocate(uint32_t type, VkDeviceSize bytes, VkDeviceMemory& memory,
                    VkDeviceSize besides = 0) const;
  void giveBack(Range& range);
  void account() { account_.resize(int64_t(bytes_) - elsewhere_); }

  const VkDevice device_;
  const VkDeviceSize blockBytes_, most_;
  mutable std::mutex mutex_;
  std::list<Block> blocks_;
  VkDeviceSize bytes_ = 0;
  int64_t elsewhere_ = 0;
  LedgerEntry account_;
};

}  // namespace gxy::vulkan

// SPDX-License-Identifier: Apache-2.0
// Memory: a device's memory in a few large blocks. Buffers are cut out of these.
#pragma once
#include <cstddef>
#include <list>
#include <map>
#include <mutex>
#include <span>

#include "backends/vulkan/vulkan_handle.h"
#include "core/space/ledger.h"

namespace gxy::vulkan {

/// The blocks of one device. An allocation of half a block or more has a block of its own. Each allocation
/// takes the lowest place that is large enough. An empty block is given back, so that nothing is held when
/// nothing is used. Thread safe.
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
    /// The range as the host sees it; null if it does not.
    std::byte* mapped() const;

   private:
    friend class Memory;
    Memory* owner_ = nullptr;
    Block* block_ = nullptr;
    VkDeviceSize offset_ = 0, bytes_ = 0;
  };

  /// `account`: holds the blocks' sizes, less what is charged elsewhere; may be in no ledger. `most`: limits
  /// the bytes in all; 0: no limit.
  Memory(VkDevice device, VkDeviceSize blockBytes, LedgerEntry account, VkDeviceSize most);
  ~Memory();
  Memory(const Memory&) = delete;
  Memory& operator=(const Memory&) = delete;

  /// Takes a range of a memory type; `visible`: the host sees it. Returns an empty range (memory() is null)
  /// if the device has no room.
  Range take(uint32_t type, bool visible, VkDeviceSize bytes, VkDeviceSize alignment);
  /// Whether the device can give blocks for all of these sizes at once, besides those it has given. It finds
  /// out by taking them for a moment. Sizes below half a block are left out, as they may fit into existing
  /// blocks.
  bool gives(uint32_t type, std::span<const VkDeviceSize> sizes) const;
  /// Another `bytes` (negative: fewer) of what is taken are in others' accounts.
  void chargeElsewhere(int64_t bytes);
  /// The bytes of all blocks.
  VkDeviceSize bytes() const;
  size_t blocks() const;

 private:
  /// Allocates a block. `besides`: bytes that are taken and are in no block.
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

// SPDX-License-Identifier: Apache-2.0
// A device with its queues, and buffers in its memory.
#pragma once
#include <atomic>
#include <cstddef>
#include <memory>
#include <mutex>
#include <span>

#include "backends/vulkan/memory.h"
#include "backends/vulkan/vulkan_instance.h"
#include "core/comm/advance.h"

namespace gxy::vulkan {

/// Where a buffer lives. Device: the device's own memory, which the host may or may not see; Written: memory that the host sees,
/// the device's own if possible, for little that the host writes and the device reads; Readback: the host's, cached, for what
/// the device writes and the host reads.
enum class Place { Device, Written, Readback };

/// Who does commands: stages, or copies to memory that the host does not see, which where the device has a queue family for
/// nothing else go on beside stages; elsewhere both take turns in one queue.
enum class Work { Stages, Copies };

class Buffer;

/// Thread safe. Buffers, pipelines and whatever else is made of it must not outlive it.
class Device {
 public:
  explicit Device(const VulkanOptions& options);
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  VkDevice get() const { return device_.get(); }
  uint32_t queueFamily(Work work) const { return queues_[size_t(work)].family; }
  /// Whether copies have a queue of their own.
  bool copiesBeside() const { return queueFamily(Work::Copies) != queueFamily(Work::Stages); }
  const VulkanDeviceInfo& info() const { return info_; }
  const VkPhysicalDeviceLimits& limits() const { return limits_; }
  size_t largestBinding() const { return largestBinding_; }  ///< bytes of scene data as texels of a word
  size_t largestQuads() const { return largestQuads_; }      ///< of four words, if more; the rest by address
  size_t largestStorage() const { return largestStorage_; }  ///< bytes of them that are read ahead
  size_t bytes() const { return bytes_; }                    ///< of all buffers
  const Memory& blocks() const { return *blocks_; }
  /// So many bytes more of its blocks are others' to account for.
  void chargeElsewhere(int64_t bytes) const { blocks_->chargeElsewhere(bytes); }

  /// Throws Error where the device does not give buffers of these sizes all at once, in Place::Device; `what` they are for. Small
  /// ones are left out.
  void expectRoom(std::span<const size_t> sizes, const std::string& what) const;

  /// Hands commands to the queue; returns the number with which to wait for them. Those of one kind are done in the order of
  /// numbers; they begin when of the other kind submission `after`, and those that were waited for, are done, and see what these
  /// wrote.
  uint64_t submit(Work work, VkCommandBuffer commands, uint64_t after = 0) const;
  void wait(Work work, uint64_t submission) const;
  /// Whether one of the two has been told that the device was lost.
  bool lost() const { return lost_; }
  /// Bits that its clock has (timestamps); 0: it has none.
  uint32_t clockBits() const { return clockBits_; }
  /// Nanoseconds after which that begins anew; 0: never, as far as 64 bits reach.
  uint64_t clockRound() const;
  /// Loops of an invocation end when they have gone round 65535 times together (shaders/resumable.glsl).
  bool endsLoops() const { return endsLoops_; }
  /// Lanes fetch one after the other, and small batches keep it busy.
  bool isSoftware() const { return software_; }

 private:
  friend class Buffer;
  uint32_t memoryType(uint32_t allowed, Place place) const;
  BufferHandle makeBuffer(size_t bytes, const std::string& what) const;
  VkDeviceSize heapOf(uint32_t type) const;
  Error noRoom(size_t bytes, size_t heap, const std::string& what) const;
  /// Throws Error where no such buffer can be.
  void expectPossible(const VkMemoryRequirements& needs, uint32_t type, const std::string& what) const;

  Instance instance_;
  VkPhysicalDevice physical_;
  VulkanDeviceInfo info_;
  VkPhysicalDeviceLimits limits_{};
  size_t largestBinding_ = 0, largestQuads_ = 0, largestStorage_ = 0, largestAllocation_ = 0;
  VkPhysicalDeviceMemoryProperties memory_{};
  uint32_t clockBits_ = 0;
  DeviceHandle device_;
  bool endsLoops_ = false;
  struct Queue {
    uint32_t family = 0;
    VkQueue queue = VK_NULL_HANDLE;
    SemaphoreHandle done;            ///< the number of the last submission that is done
    mutable uint64_t waitedFor = 0;  ///< the last that was waited for; under queueMutex_
  };
  Queue queues_[2];  ///< by Work
  bool isLost(uint64_t submission) const { return lostAfter_ > 0 && submission > lostAfter_; }
  void heed(VkResult result, const char* doing) const;
  const bool software_;
  const uint64_t lostAfter_;
  const bool lostInWaits_, hidesMemory_;
  mutable std::unique_ptr<Memory> blocks_;
  mutable std::mutex queueMutex_;
  mutable uint64_t submitted_ = 0;
  mutable std::atomic<size_t> bytes_{0};
  mutable std::atomic<bool> lost_{false};
};

/// A buffer in the device's memory. Move-only.
class Buffer {
 public:
  Buffer() = default;
  /// Not initialised. Throws Error naming `what` it is for if there is no room for it.
  Buffer(const Device& device, size_t bytes, Place place, const char* what);
  Buffer(Buffer&&) noexcept = default;
  Buffer& operator=(Buffer&&) noexcept = default;

  VkBuffer get() const { return buffer_.get(); }
  size_t bytes() const { return bytes_; }
  VkDeviceAddress address() const;
  /// The buffer as the host sees it; null if it does not.
  std::byte* mapped() const { return mapped_; }

 private:
  struct Uncount {
    std::atomic<size_t>* sum;
    void operator()(void* bytes) const { *sum -= reinterpret_cast<size_t>(bytes); }
  };
  const Device* device_ = nullptr;
  BufferHandle buffer_;
  Memory::Range memory_;
  std::unique_ptr<void, Uncount> counted_{nullptr, Uncount{nullptr}};
  size_t bytes_ = 0;
  std::byte* mapped_ = nullptr;
};

/// A command buffer with its pool. One thread at a time.
class Commands {
 public:
  explicit Commands(const Device& device, Work work = Work::Stages);
  /// Forgets what was recorded, and begins anew.
  VkCommandBuffer begin();
  /// All that is recorded from here on sees what was written before, by shaders, copies and, when done, the host. Of stages.
  void barrier();
  /// Returns the number of the submission. They begin when submission `after` of the other kind is done.
  uint64_t submit(uint64_t after = 0);
  /// For what was submitted.
  void wait() const { device_.wait(work_, submission_); }

 private:
  const Device& device_;
  const Work work_;
  CommandPoolHandle pool_;
  VkCommandBuffer commands_ = VK_NULL_HANDLE;
  uint64_t submission_ = 0;
};

/// Copies to the beginning of a part of a buffer, whether the host sees it or not. Throws what `advance` throws.
void upload(
    const Device& device, const Buffer& buffer, size_t offset, std::span<const std::byte> bytes,
    const Advance& advance = [](double) {});

}  // namespace gxy::vulkan

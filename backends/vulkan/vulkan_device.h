// SPDX-License-Identifier: Apache-2.0
// A Vulkan device with its queues, and buffers in its memory.
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

/// Where a buffer lives.
/// - Device: in the device's own memory, which the host may or may not see.
/// - Written: in memory that the host sees, the device's own if possible; for little data that the host
///   writes and the device reads.
/// - Readback: in the host's cached memory; for what the device writes and the host reads.
enum class Place { Device, Written, Readback };

/// The kind of work of commands: stages, or copies to memory that the host does not see. If the device has a
/// queue family for copies only, copies run beside stages; otherwise both take turns in one queue.
enum class Work { Stages, Copies };

class Buffer;

/// A logical device. Thread safe. Buffers, pipelines and everything else that is made of it must not outlive
/// it.
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
  /// Largest bytes of scene data to bind as texels of one word.
  size_t largestBinding() const { return largestBinding_; }
  /// The same as texels of four words; larger data is read by address.
  size_t largestQuads() const { return largestQuads_; }
  size_t largestStorage() const { return largestStorage_; }  ///< of tables read ahead from a storage buffer
  size_t bytes() const { return bytes_; }                    ///< bytes of all buffers
  const Memory& blocks() const { return *blocks_; }
  /// Another `bytes` (negative: fewer) of its blocks are accounted for by others.
  void chargeElsewhere(int64_t bytes) const { blocks_->chargeElsewhere(bytes); }

  /// Throws Error if the device cannot give buffers of these sizes, all at once, in Place::Device. `what`
  /// says what they are for. Small ones are left out.
  void expectRoom(std::span<const size_t> sizes, const std::string& what) const;

  /// Submits commands to the queue of `work`. Returns the submission's number, for wait(). Submissions of one
  /// kind are done in the order of their numbers. These commands begin when submission `after` of the other
  /// kind, and all of that kind that were waited for, are done, and they see what those wrote. Throws Error
  /// if the device is lost.
  uint64_t submit(Work work, VkCommandBuffer commands, uint64_t after = 0) const;
  /// Waits until a submission is done. Throws Error if the device is lost.
  void wait(Work work, uint64_t submission) const;
  /// Whether submit() or wait() has found the device lost.
  bool lost() const { return lost_; }
  /// The number of bits of its clock (timestamps); 0: it has none.
  uint32_t clockBits() const { return clockBits_; }
  /// Nanoseconds after which the clock starts again at 0; 0: never, as far as 64 bits reach.
  uint64_t clockRound() const;
  /// Whether the device ends the loops of an invocation when they have gone round 65535 times together
  /// (shaders/resumable.glsl).
  bool endsLoops() const { return endsLoops_; }
  /// Whether it is a software device: its lanes fetch one after the other, and small batches keep it busy.
  bool isSoftware() const { return software_; }
  /// Whether it rounds quotients and roots of floats right, as the processor does with which a software device computes.
  bool roundsRight() const { return software_; }

 private:
  friend class Buffer;
  uint32_t memoryType(uint32_t allowed, Place place) const;
  BufferHandle makeBuffer(size_t bytes, const std::string& what) const;
  VkDeviceSize heapOf(uint32_t type) const;
  Error noRoom(size_t bytes, size_t heap, const std::string& what) const;
  /// Throws Error if no such buffer is possible.
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
    SemaphoreHandle done;            ///< counts up to the number of the last submission that is done
    mutable uint64_t waitedFor = 0;  ///< the last submission that was waited for; guarded by queueMutex_
  };
  Queue queues_[2];  ///< index: Work
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
  /// Makes a buffer of at least 16 bytes, not initialised. Throws Error naming `what` it is for if there is
  /// no room.
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
  /// Discards what was recorded, and begins anew.
  VkCommandBuffer begin();
  /// Everything recorded after the barrier sees what shaders and copies wrote before it. So does the host,
  /// when the commands are done. For stages only.
  void barrier();
  /// Submits what was recorded; it begins when submission `after` of the other kind is done. Returns the
  /// number of the submission.
  uint64_t submit(uint64_t after = 0);
  /// Waits for the last submission.
  void wait() const { device_.wait(work_, submission_); }

 private:
  const Device& device_;
  const Work work_;
  CommandPoolHandle pool_;
  VkCommandBuffer commands_ = VK_NULL_HANDLE;
  uint64_t submission_ = 0;
};

/// Copies `bytes` into a buffer from `offset` on, whether or not the host sees it. Returns when the copy is
/// done. Throws what `advance` throws.
void upload(
    const Device& device, const Buffer& buffer, size_t offset, std::span<const std::byte> bytes,
    const Advance& advance = [](double) {});

}  // namespace gxy::vulkan

// SPDX-License-Identifier: Apache-2.0
// Rays that wait on the device to be traced in another partition of the rank.
#pragma once
#include <atomic>
#include <memory>
#include <utility>

#include "backends/vulkan/vulkan_device.h"
#include "core/rays/ray_list.h"

namespace gxy::vulkan {

/// A list of rays on the device, held until all of them have been taken.
class KeptRays final : public DeviceRays {
 public:
  /// `sum` counts the bytes of all such lists. Throws Error if the device has no room.
  KeptRays(const Device& device, std::atomic<size_t>& sum, size_t bytes)
      : buffer_(device, bytes, Place::Device, "rays that stay"), sum_(sum) {
    sum_ += bytes;
  }
  ~KeptRays() override { sum_ -= buffer_.bytes(); }

  /// From now on it may be destroyed at any time, on any thread. `owner`, which the device and the sum are
  /// part of, lives as long as this.
  void release(std::shared_ptr<const void> owner) { owner_ = std::move(owner); }
  VkDeviceAddress address() const { return buffer_.address(); }
  size_t bytes() const { return buffer_.bytes(); }

 private:
  std::shared_ptr<const void> owner_;  ///< destroyed last
  Buffer buffer_;
  std::atomic<size_t>& sum_;
};

}  // namespace gxy::vulkan

// SPDX-License-Identifier: Apache-2.0
// Rays that wait on the device to be traced in another partition of the rank.
#pragma once
#include <atomic>
#include <memory>
#include <utility>

#include "backends/vulkan/vulkan_device.h"
#include "core/rays/ray_list.h"

namespace gxy::vulkan {

/// A list of rays as the shaders keep them, held until all of them have been taken.
class KeptRays final : public DeviceRays {
 public:
  /// `sum`: of the bytes that are held so. Throws Error where the device has no room.
  KeptRays(const Device& device, std::atomic<size_t>& sum, size_t bytes)
      : buffer_(device, bytes, Place::Device, "rays that stay"), sum_(sum) {
    sum_ += bytes;
  }
  ~KeptRays() override { sum_ -= buffer_.bytes(); }

  /// From now on it may go anywhere: `owner`, of which the device and the sum are part, lives as long.
  void release(std::shared_ptr<const void> owner) { owner_ = std::move(owner); }
  VkDeviceAddress address() const { return buffer_.address(); }
  size_t bytes() const { return buffer_.bytes(); }

 private:
  std::shared_ptr<const void> owner_;  ///< goes last
  Buffer buffer_;
  std::atomic<size_t>& sum_;
};

}  // namespace gxy::vulkan

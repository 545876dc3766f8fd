// SPDX-License-Identifier: Apache-2.0
// The Vulkan loader's instance, and what its devices can do.
#pragma once
#include <string>
#include <vector>

#include "backends/vulkan/vulkan_backend.h"
#include "backends/vulkan/vulkan_handle.h"

namespace gxy::vulkan {

/// An instance without a window system.
class Instance {
 public:
  /// Throws Error if there is no Vulkan 1.2, or no validation layer though it is asked for.
  explicit Instance(const VulkanOptions& options = {});
  ~Instance();
  Instance(const Instance&) = delete;
  Instance& operator=(const Instance&) = delete;

  VkInstance get() const { return instance_.get(); }
  std::vector<VkPhysicalDevice> devices() const;

 private:
  static VkBool32 VKAPI_PTR hear(VkDebugUtilsMessageSeverityFlagBitsEXT severity,
                                 VkDebugUtilsMessageTypeFlagsEXT type,
                                 const VkDebugUtilsMessengerCallbackDataEXT* data, void* instance);

  const std::function<void(const char*)> heard_;
  InstanceHandle instance_;
  VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
};

VulkanDeviceInfo infoOf(VkPhysicalDevice device);

std::vector<VkQueueFamilyProperties> familiesOf(VkPhysicalDevice device);
/// The queue family of stages: one for compute, without graphics if possible; -1 if there is none.
int computeFamily(VkPhysicalDevice device);
/// The queue family that copies and does nothing else; -1 if there is none.
int copyFamily(VkPhysicalDevice device);

/// Returns the index of the device that the options ask for. Throws Error that names the devices there are,
/// or says what they lack.
size_t pick(const std::vector<VulkanDeviceInfo>& infos, const VulkanOptions& options);
/// The same among an instance's devices.
VkPhysicalDevice chooseDevice(const Instance& instance, const VulkanOptions& options);

/// The Vulkan 1.2 features that the backend uses, as a chain to request them or to have them filled in.
struct Features {
  VkPhysicalDeviceVulkan12Features v12{};
  VkPhysicalDeviceFeatures2 v10{};
  Features();
  Features(const Features&) = delete;
  Features& operator=(const Features&) = delete;
};

}  // namespace gxy::vulkan

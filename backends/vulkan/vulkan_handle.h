// SPDX-License-Identifier: Apache-2.0
// Vulkan's objects with owners, and its results as errors.
#pragma once
#include <vulkan/vulkan.h>

#include <memory>
#include <string>
#include <utility>

#include "core/comm/error.h"

namespace gxy::vulkan {

/// Throws Error saying that `what` failed, unless the result is VK_SUCCESS.
void check(VkResult result, const std::string& what);

struct Destroy {
  void operator()(VkInstance instance) const { vkDestroyInstance(instance, nullptr); }
  void operator()(VkDevice device) const { vkDestroyDevice(device, nullptr); }
};
using InstanceHandle = std::unique_ptr<VkInstance_T, Destroy>;
using DeviceHandle = std::unique_ptr<VkDevice_T, Destroy>;

/// Owns an object of a device, which must outlive it.
template <class Object, void (*destroy)(VkDevice, Object, const VkAllocationCallbacks*)>
class Handle {
 public:
  Handle() = default;
  Handle(VkDevice device, Object object) : device_(device), object_(object) {}
  Handle(Handle&& other) noexcept
      : device_(other.device_), object_(std::exchange(other.object_, Object(VK_NULL_HANDLE))) {}
  Handle& operator=(Handle&& other) noexcept {
    std::swap(device_, other.device_);
    std::swap(object_, other.object_);
    return *this;
  }
  ~Handle() {
    if (object_) destroy(device_, object_, nullptr);
  }
  Object get() const { return object_; }
  explicit operator bool() const { return object_ != VK_NULL_HANDLE; }

 private:
  VkDevice device_ = VK_NULL_HANDLE;
  Object object_ = VK_NULL_HANDLE;
};

using BufferHandle = Handle<VkBuffer, vkDestroyBuffer>;
using BufferViewHandle = Handle<VkBufferView, vkDestroyBufferView>;
using MemoryHandle = Handle<VkDeviceMemory, vkFreeMemory>;
using ShaderHandle = Handle<VkShaderModule, vkDestroyShaderModule>;
using PipelineHandle = Handle<VkPipeline, vkDestroyPipeline>;
using PipelineLayoutHandle = Handle<VkPipelineLayout, vkDestroyPipelineLayout>;
using SetLayoutHandle = Handle<VkDescriptorSetLayout, vkDestroyDescriptorSetLayout>;
using DescriptorPoolHandle = Handle<VkDescriptorPool, vkDestroyDescriptorPool>;
using CommandPoolHandle = Handle<VkCommandPool, vkDestroyCommandPool>;
using QueryPoolHandle = Handle<VkQueryPool, vkDestroyQueryPool>;
using SemaphoreHandle = Handle<VkSemaphore, vkDestroySemaphore>;

}  // namespace gxy::vulkan

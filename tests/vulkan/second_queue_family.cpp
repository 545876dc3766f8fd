// SPDX-License-Identifier: Apache-2.0
// A Vulkan layer between the validation layers and the driver of a device with one queue family: shows another one, for copies
// alone, whose work goes to the first one's queue. When it is unloaded it prints for how many command pools.
#include <vulkan/vk_layer.h>
#include <vulkan/vulkan.h>

#include <atomic>
#include <cstdio>
#include <cstring>
#include <map>
#include <mutex>
#include <vector>

namespace {

constexpr uint32_t kSecond = 1;

std::atomic<int> pools = 0;
struct Report {
  ~Report() { std::printf("command pools of a second queue family: %d\n", pools.load()); }
} report;

std::mutex mutex;
struct NextOfInstance {
  VkInstance instance;
  PFN_vkGetInstanceProcAddr next;
};
std::map<void*, NextOfInstance> instances;  // by what the loader dispatches by
std::map<void*, PFN_vkGetDeviceProcAddr> devices;

template <typename Handle>
void* dispatched(Handle handle) {
  return *reinterpret_cast<void**>(handle);
}

template <typename Function, typename Handle>
Function nextOfInstance(Handle handle, const char* name) {
  std::lock_guard lock(mutex);
  const NextOfInstance& i = instances.at(dispatched(handle));
  return reinterpret_cast<Function>(i.next(i.instance, name));
}

template <typename Function>
Function nextOfDevice(VkDevice device, const char* name) {
  std::lock_guard lock(mutex);
  return reinterpret_cast<Function>(devices.at(dispatched(device))(device, name));
}

// What the loader has put into the chain for a layer.
template <typename Link, typename Info>
Link* linkOf(const Info& info, VkStructureType type) {
  auto* link = static_cast<Link*>(const_cast<void*>(info.pNext));
  while (link->sType != type || link->function != VK_LAYER_LINK_INFO)
    link = static_cast<Link*>(const_cast<void*>(link->pNext));
  return link;
}

VKAPI_ATTR VkResult VKAPI_CALL createInstance(const VkInstanceCreateInfo* info,
                                              const VkAllocationCallbacks* allocator, VkInstance* instance) {
  auto* link = linkOf<VkLayerInstanceCreateInfo>(*info, VK_STRUCTURE_TYPE_LOADER_INSTANCE_CREATE_INFO);
  const auto next = link->u.pLayerInfo->pfnNextGetInstanceProcAddr;
  link->u.pLayerInfo = link->u.pLayerInfo->pNext;
  const auto create = reinterpret_cast<PFN_vkCreateInstance>(next(VK_NULL_HANDLE, "vkCreateInstance"));
  const VkResult result = create(info, allocator, instance);
  std::lock_guard lock(mutex);
  if (result == VK_SUCCESS) instances[dispatched(*instance)] = {*instance, next};
  return result;
}

VKAPI_ATTR void VKAPI_CALL queueFamilies(VkPhysicalDevice device, uint32_t* count,
                                         VkQueueFamilyProperties* properties) {
  const auto next = nextOfInstance<PFN_vkGetPhysicalDeviceQueueFamilyProperties>(
      device, "vkGetPhysicalDeviceQueueFamilyProperties");
  uint32_t all = kSecond;
  VkQueueFamilyProperties first{};
  next(device, &all, &first);
  if (properties) {
    *count = *count < kSecond + 1 ? *count : kSecond + 1;
    for (uint32_t i = 0; i < *count; i++) properties[i] = first;
    if (*count > kSecond)
      properties[kSecond] = {VK_QUEUE_TRANSFER_BIT, 1, 0, first.minImageTransferGranularity};
  } else {
    *count = kSecond + 1;
  }
}

VKAPI_ATTR void VKAPI_CALL queueFamilies2(VkPhysicalDevice device, uint32_t* count,
                                          VkQueueFamilyProperties2* properties) {
  std::vector<VkQueueFamilyProperties> found(*count);
  queueFamilies(device, count, properties ? found.data() : nullptr);
  for (uint32_t i = 0; properties && i < *count; i++) properties[i].queueFamilyProperties = found[i];
}

VKAPI_ATTR VkResult VKAPI_CALL createDevice(VkPhysicalDevice physical, const VkDeviceCreateInfo* info,
                                            const VkAllocationCallbacks* allocator, VkDevice* device) {
  auto* link = linkOf<VkLayerDeviceCreateInfo>(*info, VK_STRUCTURE_TYPE_LOADER_DEVICE_CREATE_INFO);
  const auto next = link->u.pLayerInfo->pfnNextGetDeviceProcAddr;
  link->u.pLayerInfo = link->u.pLayerInfo->pNext;
  VkDeviceCreateInfo first = *info;
  first.queueCreateInfoCount = 1;
  const VkResult result =
      nextOfInstance<PFN_vkCreateDevice>(physical, "vkCreateDevice")(physical, &first, allocator, device);
  std::lock_guard lock(mutex);
  if (result == VK_SUCCESS) devices[dispatched(*device)] = next;
  return result;
}

VKAPI_ATTR void VKAPI_CALL getDeviceQueue(VkDevice device, uint32_t, uint32_t index, VkQueue* queue) {
  nextOfDevice<PFN_vkGetDeviceQueue>(device, "vkGetDeviceQueue")(device, 0, index, queue);
}

VKAPI_ATTR VkResult VKAPI_CALL createCommandPool(VkDevice device, const VkCommandPoolCreateInfo* info,
                                                 const VkAllocationCallbacks* allocator,
                                                 VkCommandPool* pool) {
  VkCommandPoolCreateInfo first = *info;
  if (first.queueFamilyIndex == kSecond) pools++;
  first.queueFamilyIndex = 0;
  return nextOfDevice<PFN_vkCreateCommandPool>(device, "vkCreateCommandPool")(device, &first, allocator,
                                                                              pool);
}

VKAPI_ATTR VkResult VKAPI_CALL createBuffer(VkDevice device, const VkBufferCreateInfo* info,
                                            const VkAllocationCallbacks* allocator, VkBuffer* buffer) {
  VkBufferCreateInfo first = *info;
  first.sharingMode = VK_SHARING_MODE_EXCLUSIVE;
  return nextOfDevice<PFN_vkCreateBuffer>(device, "vkCreateBuffer")(device, &first, allocator, buffer);
}

PFN_vkVoidFunction ofDevice(const char* name) {
  const auto is = [&](const char* other) { return std::strcmp(name, other) == 0; };
  if (is("vkGetDeviceQueue")) return reinterpret_cast<PFN_vkVoidFunction>(getDeviceQueue);
  if (is("vkCreateCommandPool")) return reinterpret_cast<PFN_vkVoidFunction>(createCommandPool);
  if (is("vkCreateBuffer")) return reinterpret_cast<PFN_vkVoidFunction>(createBuffer);
  return nullptr;
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL getDeviceProcAddr(VkDevice device, const char* name) {
  if (const auto mine = ofDevice(name)) return mine;
  return nextOfDevice<PFN_vkVoidFunction>(device, name);
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL getInstanceProcAddr(VkInstance instance, const char* name) {
  const auto is = [&](const char* other) { return std::strcmp(name, other) == 0; };
  if (is("vkGetInstanceProcAddr")) return reinterpret_cast<PFN_vkVoidFunction>(getInstanceProcAddr);
  if (is("vkGetDeviceProcAddr")) return reinterpret_cast<PFN_vkVoidFunction>(getDeviceProcAddr);
  if (is("vkCreateInstance")) return reinterpret_cast<PFN_vkVoidFunction>(createInstance);
  if (is("vkCreateDevice")) return reinterpret_cast<PFN_vkVoidFunction>(createDevice);
  if (is("vkGetPhysicalDeviceQueueFamilyProperties"))
    return reinterpret_cast<PFN_vkVoidFunction>(queueFamilies);
  if (is("vkGetPhysicalDeviceQueueFamilyProperties2") || is("vkGetPhysicalDeviceQueueFamilyProperties2KHR"))
    return reinterpret_cast<PFN_vkVoidFunction>(queueFamilies2);
  if (const auto mine = ofDevice(name)) return mine;
  return instance ? nextOfInstance<PFN_vkVoidFunction>(instance, name) : nullptr;
}

}  // namespace

extern "C" VKAPI_ATTR VkResult VKAPI_CALL
vkNegotiateLoaderLayerInterfaceVersion(VkNegotiateLayerInterface* version) {
  version->loaderLayerInterfaceVersion = 2;
  version->pfnGetInstanceProcAddr = getInstanceProcAddr;
  version->pfnGetDeviceProcAddr = getDeviceProcAddr;
  version->pfnGetPhysicalDeviceProcAddr = nullptr;
  return VK_SUCCESS;
}

// SPDX-License-Identifier: Apache-2.0
#include "backends/vulkan/vulkan_instance.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cstring>
#include <filesystem>

#include "shaders/layout.h"

namespace gxy::vulkan {

namespace {

constexpr const char* kValidationLayer = "VK_LAYER_KHRONOS_validation";
// Storage buffers of the three sets together. The bindings that are texels are not counted: tables, samples
// and geometry, each also as quads, a list of rays and one of tiles.
constexpr uint32_t kStorageBuffers = SCENE_BINDINGS + FRAME_BINDINGS + LANE_BINDINGS - 8;

constexpr VkSubgroupFeatureFlags kSubgroupOperations =
    VK_SUBGROUP_FEATURE_BASIC_BIT | VK_SUBGROUP_FEATURE_ARITHMETIC_BIT | VK_SUBGROUP_FEATURE_BALLOT_BIT;

std::string lower(std::string s) {
  for (char& c : s) c = char(std::tolower(static_cast<unsigned char>(c)));
  return s;
}

const char* kindName(VulkanDeviceInfo::Kind kind) {
  switch (kind) {
    case VulkanDeviceInfo::Kind::Discrete:
      return "discrete GPU";
    case VulkanDeviceInfo::Kind::Integrated:
      return "integrated GPU";
    case VulkanDeviceInfo::Kind::Virtual:
      return "virtual GPU";
    case VulkanDeviceInfo::Kind::Software:
      return "software";
    default:
      return "other";
  }
}

std::string listOf(const std::vector<VulkanDeviceInfo>& infos) {
  std::string text;
  for (size_t i = 0; i < infos.size(); i++)
    text +=
        (i ? ", " : "") + std::to_string(i) + " \"" + infos[i].name + "\" (" + kindName(infos[i].kind) + ")";
  return text.empty() ? "none" : text;
}

std::string lacking(const VulkanDeviceInfo& info) {
  std::string text = "\"" + info.name + "\" lacks ";
  for (size_t i = 0; i < info.missing.size(); i++) text += (i ? ", " : "") + info.missing[i];
  return text;
}

}  // namespace

void check(VkResult result, const std::string& what) {
  if (result == VK_SUCCESS) return;
  std::string why = "error " + std::to_string(int(result));
  if (result == VK_ERROR_OUT_OF_DEVICE_MEMORY) why = "the device is out of memory";
  if (result == VK_ERROR_OUT_OF_HOST_MEMORY) why = "out of memory";
  if (result == VK_ERROR_DEVICE_LOST) why = "the device was lost";
  if (result == VK_ERROR_INCOMPATIBLE_DRIVER) why = "no driver is installed";
  if (result == VK_TIMEOUT) why = "it took too long";
  throw Error("Vulkan: " + what + " failed: " + why);
}

Instance::Instance(const VulkanOptions& options) : heard_(options.heard) {
  using Validation = VulkanOptions::Validation;
  const bool validation = options.validation != Validation::None;
  VkApplicationInfo application{};
  application.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO;
  application.pApplicationName = "galaxy";
  application.apiVersion = VK_API_VERSION_1_2;
  VkInstanceCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO;
  info.pApplicationInfo = &application;

  VkDebugUtilsMessengerCreateInfoEXT listen{};
  listen.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT;
  listen.messageSeverity =
      VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
  listen.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT;
  listen.pfnUserCallback = hear;
  listen.pUserData = this;
  const VkValidationFeatureEnableEXT also = options.validation == Validation::GpuAssisted
                                                ? VK_VALIDATION_FEATURE_ENABLE_GPU_ASSISTED_EXT
                                                : VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT;
  VkValidationFeaturesEXT features{};
  features.sType = VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT;
  features.pNext = &listen;
  features.enabledValidationFeatureCount = 1;
  features.pEnabledValidationFeatures = &also;
  const char* extension = VK_EXT_DEBUG_UTILS_EXTENSION_NAME;
  if (validation) {
    info.pNext = &features;
    info.enabledLayerCount = 1;
    info.ppEnabledLayerNames = &kValidationLayer;
    info.enabledExtensionCount = 1;
    info.ppEnabledExtensionNames = &extension;
  }
  VkInstance instance = VK_NULL_HANDLE;
  check(vkCreateInstance(&info, nullptr, &instance),
        validation ? "starting with the validation layer" : "starting");
  instance_.reset(instance);
  if (validation) {
    const auto create = reinterpret_cast<PFN_vkCreateDebugUtilsMessengerEXT>(
        vkGetInstanceProcAddr(instance, "vkCreateDebugUtilsMessengerEXT"));
    check(create(instance, &listen, nullptr, &messenger_), "listening to the validation layer");
  }
}

Instance::~Instance() {
  if (messenger_) {
    const auto destroy = reinterpret_cast<PFN_vkDestroyDebugUtilsMessengerEXT>(
        vkGetInstanceProcAddr(get(), "vkDestroyDebugUtilsMessengerEXT"));
    destroy(get(), messenger_, nullptr);
  }
}

VkBool32 VKAPI_PTR Instance::hear(VkDebugUtilsMessageSeverityFlagBitsEXT, VkDebugUtilsMessageTypeFlagsEXT,
                                  const VkDebugUtilsMessengerCallbackDataEXT* data, void* instance) {
  const auto& heard = static_cast<const Instance*>(instance)->heard_;
  if (heard) heard(data->pMessage);
  return VK_FALSE;
}

std::vector<VkPhysicalDevice> Instance::devices() const {
  uint32_t n = 0;
  check(vkEnumeratePhysicalDevices(get(), &n, nullptr), "listing devices");
  std::vector<VkPhysicalDevice> devices(n);
  if (n > 0) check(vkEnumeratePhysicalDevices(get(), &n, devices.data()), "listing devices");
  return devices;
}

Features::Features() {
  v12.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES;
  v10.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2;
  v10.pNext = &v12;
}

std::vector<VkQueueFamilyProperties> familiesOf(VkPhysicalDevice device) {
  uint32_t n = 0;
  vkGetPhysicalDeviceQueueFamilyProperties(device, &n, nullptr);
  std::vector<VkQueueFamilyProperties> families(n);
  vkGetPhysicalDeviceQueueFamilyProperties(device, &n, families.data());
  return families;
}

int computeFamily(VkPhysicalDevice device) {
  const std::vector<VkQueueFamilyProperties> families = familiesOf(device);
  int any = -1;
  for (size_t i = 0; i < families.size(); i++) {
    if (!(families[i].queueFlags & VK_QUEUE_COMPUTE_BIT)) continue;
    if (!(families[i].queueFlags & VK_QUEUE_GRAPHICS_BIT)) return int(i);
    if (any < 0) any = int(i);
  }
  return any;
}

int copyFamily(VkPhysicalDevice device) {
  const std::vector<VkQueueFamilyProperties> families = familiesOf(device);
  constexpr VkQueueFlags kAlso = VK_QUEUE_SPARSE_BINDING_BIT | VK_QUEUE_PROTECTED_BIT;
  for (size_t i = 0; i < families.size(); i++)
    if ((families[i].queueFlags & ~kAlso) == VK_QUEUE_TRANSFER_BIT) return int(i);
  return -1;
}

VulkanDeviceInfo infoOf(VkPhysicalDevice device) {
  VulkanDeviceInfo info;
  VkPhysicalDeviceDriverProperties driver{};
  driver.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES;
  VkPhysicalDeviceProperties2 properties{};
  properties.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2;
  VkPhysicalDeviceProperties& p = properties.properties;
  vkGetPhysicalDeviceProperties(device, &p);
  info.name = p.deviceName;
  switch (p.deviceType) {
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
      info.kind = VulkanDeviceInfo::Kind::Discrete;
      break;
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
      info.kind = VulkanDeviceInfo::Kind::Integrated;
      break;
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
      info.kind = VulkanDeviceInfo::Kind::Virtual;
      break;
    case VK_PHYSICAL_DEVICE_TYPE_CPU:
      info.kind = VulkanDeviceInfo::Kind::Software;
      break;
    default:
      break;
  }
  VkPhysicalDeviceMemoryProperties memory;
  vkGetPhysicalDeviceMemoryProperties(device, &memory);
  for (uint32_t i = 0; i < memory.memoryHeapCount; i++)
    if (memory.memoryHeaps[i].flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT)
      info.memory = std::max<uint64_t>(info.memory, memory.memoryHeaps[i].size);
  if (p.apiVersion < VK_API_VERSION_1_2) {
    info.missing.push_back("Vulkan 1.2");
    return info;
  }
  VkPhysicalDeviceFloatControlsProperties floats{};
  floats.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FLOAT_CONTROLS_PROPERTIES;
  floats.pNext = &driver;
  VkPhysicalDeviceSubgroupProperties subgroups{};
  subgroups.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES;
  subgroups.pNext = &floats;
  properties.pNext = &subgroups;
  vkGetPhysicalDeviceProperties2(device, &properties);
  info.driver = std::string(driver.driverName) + " " + driver.driverInfo;
  Features has;
  vkGetPhysicalDeviceFeatures2(device, &has.v10);
  if (!has.v12.bufferDeviceAddress) info.missing.push_back("bufferDeviceAddress");
  if (!has.v12.timelineSemaphore) info.missing.push_back("timelineSemaphore");
  if (!has.v10.features.shaderFloat64) info.missing.push_back("shaderFloat64");
  if (!has.v10.features.shaderInt64) info.missing.push_back("shaderInt64");
  if (!floats.shaderSignedZeroInfNanPreserveFloat32)
    info.missing.push_back("shaderSignedZeroInfNanPreserveFloat32");
  if (!(subgroups.supportedStages & VK_SHADER_STAGE_COMPUTE_BIT) ||
      (subgroups.supportedOperations & kSubgroupOperations) != kSubgroupOperations)
    info.missing.push_back("subgroup arithmetic and ballots in compute shaders");
  if (p.limits.maxPerStageDescriptorStorageBuffers < kStorageBuffers)
    info.missing.push_back(std::to_string(kStorageBuffers) + " storage buffers in a shader");
  if (computeFamily(device) < 0) info.missing.push_back("a compute queue");
  return info;
}

size_t pick(const std::vector<VulkanDeviceInfo>& infos, const VulkanOptions& options) {
  const std::string& wanted = options.device;
  size_t index = 0;
  const auto [rest, error] = std::from_chars(wanted.data(), wanted.data() + wanted.size(), index);
  const bool isNumber = error == std::errc() && rest == wanted.data() + wanted.size();
  const auto isMeant = [&](size_t i) {
    return isNumber ? i == index : lower(infos[i].name).find(lower(wanted)) != std::string::npos;
  };
  VulkanDeviceInfo::Kind best = VulkanDeviceInfo::Kind::Other;
  std::vector<size_t> fit;
  std::string unfit;
  for (size_t i = 0; i < infos.size(); i++) {
    if (!isMeant(i)) continue;
    if (!infos[i].missing.empty()) {
      unfit += "; " + lacking(infos[i]);
    } else if (!wanted.empty()) {
      fit.push_back(i);
    } else if (infos[i].kind <= best) {
      if (infos[i].kind < best) fit.clear();
      best = infos[i].kind;
      fit.push_back(i);
    }
  }
  if (!fit.empty()) return fit[size_t(options.rankOnMachine) % fit.size()];
  if (wanted.empty() || !unfit.empty())
    throw Error("there is no Vulkan device" + (wanted.empty() ? "" : " \"" + wanted + "\"") +
                " that can be used" + unfit);
  throw Error("there is no Vulkan device \"" + wanted + "\"; expected one of: " + listOf(infos));
}

VkPhysicalDevice chooseDevice(const Instance& instance, const VulkanOptions& options) {
  const std::vector<VkPhysicalDevice> devices = instance.devices();
  std::vector<VulkanDeviceInfo> infos;
  for (VkPhysicalDevice d : devices) infos.push_back(infoOf(d));
  return devices[pick(infos, options)];
}

}  // namespace gxy::vulkan

namespace gxy {

bool hasDiscreteGpu(const std::vector<VulkanDeviceInfo>& devices) {
  return std::any_of(devices.begin(), devices.end(), [](const VulkanDeviceInfo& d) {
    return d.kind == VulkanDeviceInfo::Kind::Discrete && d.missing.empty();
  });
}

std::string lackingOf(const std::vector<VulkanDeviceInfo>& devices) {
  std::string text;
  for (const VulkanDeviceInfo& d : devices)
    if (d.kind == VulkanDeviceInfo::Kind::Discrete && !d.missing.empty())
      text += (text.empty() ? "" : "; ") + vulkan::lacking(d);
  return text;
}

bool showsGpu(const std::string& folder) {
  const std::filesystem::path dev(folder);
  std::error_code error;  // a folder that does not exist has no entries
  const auto hasNumbered = [&](const std::filesystem::path& in, const std::string& prefix) {
    for (const auto& entry : std::filesystem::directory_iterator(in, error)) {
      const std::string name = entry.path().filename().string();
      if (name.starts_with(prefix) && std::isdigit(static_cast<unsigned char>(name[prefix.size()])))
        return true;
    }
    return false;
  };
  return hasNumbered(dev / "dri", "renderD") || hasNumbered(dev, "nvidia") ||
         std::filesystem::exists(dev / "dxg", error);
}

std::vector<VulkanDeviceInfo> vulkanDevices() {
  std::vector<VulkanDeviceInfo> infos;
  try {
    const vulkan::Instance instance;
    for (VkPhysicalDevice d : instance.devices()) infos.push_back(vulkan::infoOf(d));
  } catch (const Error&) {
    // No loader or no driver means no devices.
  }
  return infos;
}

}  // namespace gxy

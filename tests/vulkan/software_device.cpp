// SPDX-License-Identifier: Apache-2.0
#include "vulkan/software_device.h"

#include <utility>

#include "gxy/comm/error.h"

namespace gxy::vulkan_test {

VulkanOptions softwareDevice() {
  VulkanOptions options;
  options.validation = VulkanOptions::Validation::CoreAndSynchronization;
  const std::vector<VulkanDeviceInfo> devices = vulkanDevices();
  for (size_t i = 0; i < devices.size(); i++)
    if (devices[i].kind == VulkanDeviceInfo::Kind::Software) options.device = std::to_string(i);
  if (options.device.empty()) throw Error("this test needs lavapipe (package mesa-vulkan-drivers)");
  return options;
}

const Backend& softwareVulkan() {
  static const std::unique_ptr<Backend> backend = makeVulkanBackend(softwareDevice());
  return *backend;
}

std::vector<std::string> newMessages() {
  static size_t heard = 0;
  const std::vector<std::string> all = validationMessages(softwareVulkan());
  const size_t first = std::exchange(heard, all.size());
  return {all.begin() + std::ptrdiff_t(first), all.end()};
}

}  // namespace gxy::vulkan_test

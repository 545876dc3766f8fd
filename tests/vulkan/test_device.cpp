// SPDX-License-Identifier: Apache-2.0
#include "vulkan/test_device.h"

#include <utility>

namespace gxy::vulkan_test {

VulkanOptions testDevice() {
  VulkanOptions options;
  options.device = GALAXY_TEST_DEVICE;
  options.validation = VulkanOptions::Validation::CoreAndSynchronization;
  return options;
}

const Backend& testedVulkan() {
  static const std::unique_ptr<Backend> backend = makeVulkanBackend(testDevice());
  return *backend;
}

std::vector<std::string> newMessages() {
  static size_t heard = 0;
  const std::vector<std::string> all = validationMessages(testedVulkan());
  const size_t first = std::exchange(heard, all.size());
  return {all.begin() + std::ptrdiff_t(first), all.end()};
}

}  // namespace gxy::vulkan_test

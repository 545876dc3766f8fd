// SPDX-License-Identifier: Apache-2.0
#include "tests/vulkan/test_device.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>

namespace gxy::vulkan_test {

namespace {

void failTest(const char* message) {
  if (testing::UnitTest::GetInstance()->current_test_info()) {
    ADD_FAILURE() << message;
  } else {  // before or after all tests, where no failure would be counted
    std::fprintf(stderr, "%s\n", message);
    std::fflush(nullptr);
    std::_Exit(1);
  }
}

}  // namespace

VulkanOptions testDevice() {
  // between submissions, too, for which Vulkan has no feature to ask for
  setenv("VK_LAYER_ENABLES", "VALIDATION_CHECK_ENABLE_SYNCHRONIZATION_VALIDATION_QUEUE_SUBMIT", 1);
  VulkanOptions options;
  options.device = GALAXY_TEST_DEVICE;
  options.validation = VulkanOptions::Validation::CoreAndSynchronization;
  options.heard = failTest;
  options.keptPipelines = 100;  // under the layers each takes long to compile
  return options;
}

const Backend& testedVulkan() {
  static const std::unique_ptr<Backend> backend = makeVulkanBackend(testDevice());
  return *backend;
}

const VulkanDeviceInfo& testedInfo() { return deviceOf(testedVulkan()); }

bool isSoftware() { return testedInfo().kind == VulkanDeviceInfo::Kind::Software; }

}  // namespace gxy::vulkan_test

// SPDX-License-Identifier: Apache-2.0
// Run without any Vulkan driver: an error for those who insist, the CPU for the others.
#include <gtest/gtest.h>

#include <string>

#include "backends/registry/backends.h"
#include "backends/vulkan/vulkan_backend.h"
#include "core/comm/error.h"

namespace gxy {
namespace {

TEST(NoVulkanDevice, IsNoErrorToAskFor) {
  EXPECT_TRUE(vulkanDevices().empty());
  EXPECT_EQ(listDevices().back(), "vulkan: no devices");
}

TEST(NoVulkanDevice, IsAnErrorForThoseWhoInsist) {
  for (const bool byName : {false, true}) {
    try {
      byName ? allBackends({}).make("vulkan") : makeVulkanBackend();
      ADD_FAILURE() << byName;
    } catch (const Error& e) {
      EXPECT_NE(std::string(e.what()).find("no driver is installed"), std::string::npos) << e.what();
    }
  }
}

TEST(NoVulkanDevice, LeavesEmbreeToAuto) { EXPECT_EQ(allBackends({}).make("auto")->name(), "embree"); }

}  // namespace
}  // namespace gxy

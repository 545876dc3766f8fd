// SPDX-License-Identifier: Apache-2.0
#include "tests/agreement/same_bits.h"

#include <gtest/gtest.h>

#include "tests/vulkan/difference.h"

namespace gxy::agreement {

void expectVulkanDrawsTheSame(const Picture& first, const TestScene& scene, uint32_t frameNumber) {
  EXPECT_EQ(vulkan_test::difference(first, draw(vulkan_test::testedVulkan(), scene, frameNumber)), "")
      << scene.name << ": Vulkan draws other pixels than Embree";
}

}  // namespace gxy::agreement

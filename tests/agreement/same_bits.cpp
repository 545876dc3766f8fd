// SPDX-License-Identifier: Apache-2.0
#include "same_bits.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <sstream>

#include "gxy/io/image.h"
#include "vulkan/software_device.h"

namespace gxy::agreement {

using vulkan_test::softwareVulkan;

namespace {

void write(const TestScene& scene, const char* what, const Picture& picture, std::vector<float> rgba) {
  writeImage(testing::TempDir() + scene.name + "_" + what + ".png",
             {picture.width, picture.height, std::move(rgba)});
}

}  // namespace

void expectVulkanDrawsTheSame(const Picture& first, const TestScene& scene, uint32_t frameNumber) {
  const Picture second = draw(softwareVulkan(), scene, frameNumber);
  ASSERT_EQ(first.rgba.size(), second.rgba.size());
  size_t different = 0;
  std::ostringstream shown;
  shown.precision(9);
  for (size_t p = 0; p < first.depth.size(); p++) {
    const float *a = &first.rgba[4 * p], *b = &second.rgba[4 * p];
    if (std::memcmp(a, b, 16) == 0 && std::memcmp(&first.depth[p], &second.depth[p], 8) == 0) continue;
    if (different++ >= 4) continue;
    shown << "\n  pixel " << p % size_t(first.width) << ", " << p / size_t(first.width) << ":";
    for (int k = 0; k < 4; k++) shown << ' ' << a[k] << '|' << b[k];
    shown << " depth " << first.depth[p] << '|' << second.depth[p];
  }
  if (different > 0) {
    std::vector<float> difference(first.rgba.size());
    for (size_t i = 0; i < difference.size(); i++)
      difference[i] = i % 4 == 3 ? 1 : 8 * std::abs(first.rgba[i] - second.rgba[i]);
    write(scene, "embree", first, first.rgba);
    write(scene, "vulkan", second, second.rgba);
    write(scene, "vulkan_difference", first, difference);
  }
  EXPECT_EQ(different, 0u) << scene.name << ": Vulkan draws other pixels than Embree" << shown.str();
  for (const std::string& message : vulkan_test::newMessages())
    ADD_FAILURE() << scene.name << ": " << message;
}

}  // namespace gxy::agreement

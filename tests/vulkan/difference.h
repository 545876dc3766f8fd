// SPDX-License-Identifier: Apache-2.0
// Embree's pictures and those in which the tests' device has a part: bit for bit, but of a GPU (support/difference.h).
#pragma once
#include <string>

#include "tests/support/difference.h"
#include "tests/vulkan/test_device.h"

namespace gxy::vulkan_test {

inline std::string difference(const Picture& expected, const Picture& found) {
  return test::difference(expected, found, isSoftware() ? test::Sameness::Bits : test::Sameness::Close);
}

}  // namespace gxy::vulkan_test

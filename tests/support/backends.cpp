// SPDX-License-Identifier: Apache-2.0
#include "tests/support/backends.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "backends/embree/embree_backend.h"
#include "core/comm/error.h"
#ifdef GALAXY_VULKAN
#include "tests/vulkan/test_device.h"
#endif

namespace gxy::test {

namespace {

bool onVulkan() {
  static const bool asked = [] {
    const std::vector<std::string> args = testing::internal::GetArgvs();
    return std::count(args.begin(), args.end(), "--backend=vulkan") > 0;
  }();
  return asked;
}

}  // namespace

const Backend& embree() {
  static const std::unique_ptr<Backend> backend = makeEmbreeBackend();
  return *backend;
}

const Backend& testedBackend() {
  if (!onVulkan()) return embree();
#ifdef GALAXY_VULKAN
  return vulkan_test::testedVulkan();
#else
  throw Error("this test was built without Vulkan");
#endif
}

Sameness testedSameness() {
#ifdef GALAXY_VULKAN
  if (onVulkan() && !vulkan_test::isSoftware()) return Sameness::Close;
#endif
  return Sameness::Bits;
}

glm::ivec2 affordable(glm::ivec2 size) { return onVulkan() ? size / 3 : size; }

}  // namespace gxy::test

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

bool isAsked(const char* option) {
  const std::vector<std::string> args = testing::internal::GetArgvs();
  return std::count(args.begin(), args.end(), option) > 0;
}

bool onVulkan() {
  static const bool asked = isAsked("--backend=vulkan");
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

bool onReference() { return !onVulkan(); }

uint64_t seedOfTheCommit() {
  for (const std::string& arg : testing::internal::GetArgvs())
    if (arg.starts_with("--seed=")) return std::stoull(arg.substr(7));
  return 1;
}

bool allIsAsked() {
  static const bool asked = isAsked("--all");
  return asked;
}

int affordable(int many) { return onVulkan() && !allIsAsked() ? std::max(2, many / 10) : many; }

glm::ivec2 affordable(glm::ivec2 size) { return onVulkan() ? size / 3 : size; }

}  // namespace gxy::test

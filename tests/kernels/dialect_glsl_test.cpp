// SPDX-License-Identifier: Apache-2.0
// One text, the same bits: probe.h in C++ against GLSL on lavapipe.
#include <gtest/gtest.h>

#include <cstring>

#include "dialect_spirv.h"
#include "shaders/layout.h"
#include "tests/kernels/dialect_probe.h"
#include "tests/vulkan/test_device.h"
#include "tests/vulkan/test_shader.h"

namespace gxy {
namespace {

using namespace vulkan;

std::vector<float> probesInGlsl() {
  const Device device(vulkan_test::testDevice());
  const Pipelines pipelines(device);
  std::vector<float> results(size_t(PROBES) * kProbeInputs);
  const Buffer out(device, results.size() * sizeof(float), Place::Readback, "probes");
  const vulkan_test::TestShader shader(device, pipelines, dialect_spirv);
  shader.run(VK_NULL_HANDLE, std::span(&out, 1), kProbeInputs,
             {(kProbeInputs + BLOCK_RAYS - 1) / BLOCK_RAYS, 1});
  std::memcpy(results.data(), out.mapped(), results.size() * sizeof(float));
  return results;
}

TEST(Dialect, GlslHasTheBitsOfCpp) { expectSameProbes(probesInCpp(), probesInGlsl()); }

}  // namespace
}  // namespace gxy

// SPDX-License-Identifier: Apache-2.0
// One text, the same bits: line_probe.h in C++ against GLSL on lavapipe.
#include <gtest/gtest.h>

#include <cstring>

#include "line_dialect_spirv.h"
#include "shaders/layout.h"
#include "tests/lines/line_dialect_probe.h"
#include "tests/vulkan/test_device.h"
#include "tests/vulkan/test_shader.h"

namespace gxy::test {
namespace {

std::vector<float> lineProbesInGlsl(size_t count) {
  const vulkan::Device device(vulkan_test::testDevice());
  const vulkan::Pipelines pipelines(device);
  std::vector<float> results(count);
  const vulkan::Buffer out(device, results.size() * sizeof(float), vulkan::Place::Readback, "probes");
  const vulkan_test::TestShader shader(device, pipelines, line_dialect_spirv);
  shader.run(VK_NULL_HANDLE, std::span(&out, 1), kLineInputs,
             {(kLineInputs + BLOCK_RAYS - 1) / BLOCK_RAYS, 1});
  std::memcpy(results.data(), out.mapped(), results.size() * sizeof(float));
  return results;
}

TEST(LineDialect, GlslHasTheBitsOfCpp) {
  const std::vector<float> cpp = lineProbesInCpp();
  expectSameLineProbes(cpp, lineProbesInGlsl(cpp.size()));
}

}  // namespace
}  // namespace gxy::test

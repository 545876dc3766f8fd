// SPDX-License-Identifier: Apache-2.0
// Shaders read and write inside their buffers only: every access is checked on the device.
#include <gtest/gtest.h>

#include "outside_spirv.h"
#include "shaders/layout.h"
#include "tests/support/frames.h"
#include "tests/vulkan/difference.h"
#include "tests/vulkan/test_device.h"
#include "tests/vulkan/test_shader.h"

namespace gxy::vulkan_test {
namespace {

VulkanOptions checked() {
  VulkanOptions options = testDevice();
  options.validation = VulkanOptions::Validation::GpuAssisted;
  return options;
}

std::unique_ptr<Backend> checkedBackend(uint64_t bindingBytes = 0, uint64_t quadBytes = 0) {
  VulkanOptions options = checked();
  options.bindingBytes = bindingBytes;
  options.quadBytes = quadBytes;
  return makeVulkanBackend(options);
}

// Or finding nothing would say nothing.
TEST(GpuAssistedValidation, FindsAWriteOutsideABuffer) {
  std::vector<std::string> heard;
  VulkanOptions options = checked();
  options.heard = [&](const char* message) { heard.emplace_back(message); };
  const vulkan::Device device(options);
  const vulkan::Pipelines pipelines(device);
  std::vector<vulkan::Buffer> words;
  words.emplace_back(device, 64, vulkan::Place::Device, "a test");
  const TestShader shader(device, pipelines, outside_spirv);
  shader.run(VK_NULL_HANDLE, words, 15, {1, 1});
  EXPECT_EQ(heard, std::vector<std::string>());
  shader.run(VK_NULL_HANDLE, words, 16, {1, 1});
  ASSERT_FALSE(heard.empty());
  EXPECT_NE(heard[0].find("out of bounds"), std::string::npos) << heard[0];
}

void expectNoMessages(const Backend& backend, const test::TestScene& scene) {
  const test::Cut cut = test::kdCut(scene.domain, 4, 2, 5);
  const auto compiled = test::compiledOn(cut, scene, [&](int) -> const Backend& { return backend; });
  const Picture expected = test::wholeOnEmbree(scene);
  EXPECT_EQ(difference(expected, test::render(scene, cut.ranks, compiled)), "");
}

TEST(GpuAssistedValidation, FindsNothingInAVolumeWithSurfacesAndShadows) {
  test::TestScene scene = test::emptyScene("volume", {12, 10});
  test::addSmoothVolume(scene);
  test::addIsosurfaces(scene, 0.5);
  test::addSlices(scene, 1);
  test::addLights(scene);
  test::addOcclusion(scene);
  expectNoMessages(*checkedBackend(), scene);
}

TEST(GpuAssistedValidation, FindsNothingInSeveralVolumes) {
  test::TestScene scene = test::emptyScene("volumes", {12, 10});
  test::addSmoothVolume(scene);
  test::addSecondVolume(scene);
  expectNoMessages(*checkedBackend(), scene);
}

TEST(GpuAssistedValidation, FindsNothingInSlices) {
  test::TestScene scene = test::emptyScene("slices", {12, 10});
  test::addSlices(scene, 1);
  expectNoMessages(*checkedBackend(), scene);
}

TEST(GpuAssistedValidation, FindsNothingInGeometry) {
  test::TestScene scene = test::emptyScene("geometry", {12, 10});
  test::addParticles(scene, 0.6);
  test::addTubes(scene, 1);
  test::addMesh(scene, 1);
  test::addLights(scene);
  expectNoMessages(*checkedBackend(), scene);
}

TEST(GpuAssistedValidation, FindsNothingInDataReadByAddress) {
  test::TestScene scene = test::emptyScene("addressed", {12, 10});
  test::addSmoothVolume(scene);
  test::addParticles(scene, 1);
  expectNoMessages(*checkedBackend(64, 64), scene);
}

TEST(GpuAssistedValidation, FindsNothingInDataReadInQuads) {
  test::TestScene scene = test::emptyScene("quads", {12, 10});
  test::addSmoothVolume(scene);
  test::addParticles(scene, 1);
  expectNoMessages(*checkedBackend(64), scene);
}

}  // namespace
}  // namespace gxy::vulkan_test

// SPDX-License-Identifier: Apache-2.0
// Shaders read and write inside their buffers only: every access is checked on the device.
#include <gtest/gtest.h>

#include "support/frames.h"
#include "vulkan/test_device.h"

namespace gxy::vulkan_test {
namespace {

std::unique_ptr<Backend> checkedBackend(uint64_t bindingBytes = 0) {
  VulkanOptions options = testDevice();
  options.validation = VulkanOptions::Validation::GpuAssisted;
  options.bindingBytes = bindingBytes;
  return makeVulkanBackend(options);
}

void expectNoMessages(const Backend& backend, const test::TestScene& scene) {
  const test::Cut cut = test::kdCut(scene.domain, 4, 2, 5);
  const auto compiled = test::compiledOn(cut, scene, [&](int) -> const Backend& { return backend; });
  const Picture expected = test::wholeOnEmbree(scene);
  EXPECT_EQ(test::difference(expected, test::render(scene, cut.ranks, compiled)), "");
  EXPECT_EQ(validationMessages(backend), std::vector<std::string>());
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
  expectNoMessages(*checkedBackend(64), scene);
}

}  // namespace
}  // namespace gxy::vulkan_test

// SPDX-License-Identifier: Apache-2.0
// One scene gives one picture, bit for bit, whichever backend the ranks use (architecture.md, promise 2), and
// however its data are read. How it is cut, spread and packed is tests/images' on this backend, too.
#include <gtest/gtest.h>

#include <set>
#include <string>

#include "tests/support/backends.h"
#include "tests/support/frames.h"
#include "tests/vulkan/difference.h"
#include "tests/vulkan/test_device.h"

namespace gxy::test {
namespace {

using vulkan_test::testedVulkan;

class VulkanInvariance : public testing::TestWithParam<TestScene> {
 protected:
  const TestScene& scene_ = GetParam();
  const Picture expected_ = wholeOnEmbree(scene_);

  std::string differenceOn(const Cut& cut, const BackendOf& backendOf) {
    return vulkan_test::difference(expected_, render(scene_, cut.ranks, compiledOn(cut, scene_, backendOf)));
  }
};

TEST_P(VulkanInvariance, OfBackendsThatRanksUseTogether) {
  const auto mixed = [&](int rank) -> const Backend& { return rank % 2 ? testedVulkan() : embree(); };
  EXPECT_EQ(differenceOn(lattice(scene_.domain, {2, 2, 1}, 4), mixed), "");
}

// Stages that are not cut short, nothing read ahead, large batches, memory that the host does not see.
TEST_P(VulkanInvariance, OfWhatSoftwareDevicesAndGpusDo) {
  static const std::unique_ptr<Backend> backend = [] {
    VulkanOptions options = vulkan_test::testDevice();
    options.asGpu = options.hidesMemory = true;
    return makeVulkanBackend(options);
  }();
  TestScene scene = scene_;
  // with narrow maps, too, the software device would end loops (rays.glsl)
  if (scene.name == "several volumes" && vulkan_test::isSoftware()) {
    scene.data.pop_back();
    scene.visualization.operators.pop_back();
  }
  const Cut cut = lattice(scene.domain, {2, 1, 1}, 1);
  EXPECT_EQ(vulkan_test::difference(
                wholeOnEmbree(scene),
                render(scene, 1, compiledOn(cut, scene, [](int) -> const Backend& { return *backend; }))),
            "");
}

class VulkanData : public VulkanInvariance {};

TEST_P(VulkanData, MayBeMoreThanABindingHolds) {
  const auto backendOf = [](uint64_t bindingBytes, uint64_t quadBytes, uint64_t storageBytes) {
    VulkanOptions options = vulkan_test::testDevice();
    options.bindingBytes = bindingBytes;
    options.quadBytes = quadBytes;
    options.storageBytes = storageBytes;
    return makeVulkanBackend(options);
  };
  static const std::unique_ptr<Backend> backends[] = {backendOf(64, 64, 64), backendOf(64, 0, 0),
                                                      backendOf(0, 0, 64)};
  // each way of reading with all kinds of data at once, the first with each kind by itself, too
  for (size_t i = 0; i < std::size(backends); i++) {
    if (i > 0 && scene_.name != "everything" && !allIsAsked()) continue;
    EXPECT_EQ(differenceOn(whole(scene_.domain), [&](int) -> const Backend& { return *backends[i]; }), "")
        << i;
  }
}

std::string nameOf(const testing::TestParamInfo<TestScene>& info) {
  std::string name;
  for (char c : info.param.name)
    if (c != ' ') name += c;
  return name;
}

std::vector<TestScene> allScenes() {
  std::vector<TestScene> scenes = scenesOfEachKind();
  scenes.push_back(everything());
  for (TestScene& scene : scenes) scene.camera.dimensions /= 3;  // lavapipe takes its time
  return scenes;
}

// Each kind of data by itself, and all together: the other scenes read none in another way.
std::vector<TestScene> scenesByData() {
  const std::set<std::string> kinds{"smooth volume",       "spiky volume", "isosurfaces", "slices",
                                    "particles",           "tubes",        "mesh",        "several volumes",
                                    "second volume alone", "everything"};
  std::vector<TestScene> scenes = allScenes();
  std::erase_if(scenes, [&](const TestScene& scene) { return !kinds.count(scene.name); });
  return scenes;
}

INSTANTIATE_TEST_SUITE_P(Scenes, VulkanInvariance, testing::ValuesIn(allScenes()), nameOf);
INSTANTIATE_TEST_SUITE_P(Scenes, VulkanData, testing::ValuesIn(scenesByData()), nameOf);

}  // namespace

void PrintTo(const TestScene& scene, std::ostream* out) { *out << scene.name; }

}  // namespace gxy::test

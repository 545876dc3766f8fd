// SPDX-License-Identifier: Apache-2.0
// Where buffers lie in a device's memory, and what scenes share of it.
#include <gtest/gtest.h>

#include "agreement/draw.h"
#include "gxy/embree/embree_backend.h"
#include "gxy/vulkan/lane.h"
#include "support/frames.h"
#include "vulkan/software_device.h"

namespace gxy::vulkan_test {
namespace {

using vulkan::Buffer;
using vulkan::Place;

TEST(DeviceMemory, ManySmallBuffersAreInOneBlockAndNothingIsHeldWithoutThem) {
  const vulkan::Device device(softwareDevice());
  {
    std::vector<Buffer> buffers;
    for (int i = 0; i < 2000; i++) buffers.emplace_back(device, size_t(100 + i), Place::Device, "a test");
    EXPECT_EQ(device.blocks().blocks(), 1u);
    for (size_t i = 0; i < buffers.size(); i += 2) buffers[i] = {};
    for (size_t i = 0; i < buffers.size(); i += 2) buffers[i] = Buffer(device, 100, Place::Device, "a test");
    EXPECT_EQ(device.blocks().blocks(), 1u);
    // none overlaps another: each still holds what was written to it
    for (size_t i = 0; i < buffers.size(); i++)
      std::fill_n(buffers[i].mapped(), buffers[i].bytes(), std::byte(i % 251));
    for (size_t i = 0; i < buffers.size(); i++)
      for (size_t k = 0; k < buffers[i].bytes(); k++)
        ASSERT_EQ(buffers[i].mapped()[k], std::byte(i % 251)) << i;
  }
  EXPECT_EQ(device.blocks().blocks(), 0u);
  EXPECT_EQ(device.blocks().bytes(), 0u);
}

TEST(DeviceMemory, LargeBuffersHaveBlocksOfTheirOwn) {
  const vulkan::Device device(softwareDevice());
  const Buffer large(device, size_t(48) << 20, Place::Device, "a test");
  const Buffer small(device, 1000, Place::Device, "a test");
  EXPECT_EQ(device.blocks().blocks(), 2u);
  EXPECT_LT(device.blocks().bytes(), size_t(48 + 65) << 20);
}

TEST(DeviceMemory, IsInTheLedgerWhileItIsHeld) {
  Ledger ledger;
  VulkanOptions options = softwareDevice();
  options.ledger = &ledger;
  {
    const vulkan::Device device(options);
    const Buffer buffer(device, 1000, Place::Device, "a test");
    EXPECT_EQ(ledger.total("device"), int64_t(device.blocks().bytes()));
    EXPECT_GE(ledger.total("device"), 1000);
  }
  EXPECT_EQ(ledger.total(), 0);
}

agreement::TestScene wavyScene() {
  agreement::TestScene scene = agreement::sceneFrom("wavy", {0, 0, 4}, 24, 24);
  scene.add(agreement::rendered({{0, 0}, {1, 1}}), agreement::wavy());
  return scene;
}

TEST(DeviceMemory, SamplesAreUploadedOnceForAllScenesOfAVolume) {
  const auto backend = makeVulkanBackend(softwareDevice());
  agreement::TestScene scene = wavyScene();
  const auto first = backend->makeScene(scene.compile(), 0);
  scene.visualization.operators[0].isovalues = {0.1};
  const auto second = backend->makeScene(scene.compile(), 0);
  constexpr size_t kSamples = 4 * 28 * 28 * 28;
  EXPECT_GE(first->bytes(), kSamples);
  EXPECT_LT(second->bytes(), kSamples);
  EXPECT_EQ(test::difference(agreement::draw(*makeEmbreeBackend(), scene), agreement::draw(*backend, scene)),
            "");
}

TEST(DeviceMemory, OfALaneIsForTheLargestOfItsBatchesNotForTheProductOfTheirLargestNumbers) {
  const vulkan::Device device(softwareDevice());
  vulkan::Pipelines pipelines(device);
  const auto bytesFor = [&](std::initializer_list<std::pair<size_t, size_t>> batches) {
    vulkan::Lane lane(device, pipelines);
    for (const auto& [rays, perHit] : batches) lane.reserve(rays, perHit);
    return device.bytes();
  };
  constexpr size_t kMany = 32768;
  EXPECT_LE(bytesFor({{kMany, 0}, {1024, 255}, {kMany, 0}, {kMany / 2, 1}}),
            bytesFor({{kMany, 0}}) + bytesFor({{1024, 255}}));
  EXPECT_LT(bytesFor({{1024, 255}}), 6 * 1024 * 256 * vulkan::kRayBytes);
}

TEST(DeviceMemory, MayBeOutOfTheHostsSight) {
  VulkanOptions options = softwareDevice();
  options.hidesMemory = true;
  const auto backend = makeVulkanBackend(options);
  const test::TestScene scene = test::everything({24, 20});
  const test::Cut cut = test::kdCut(scene.domain, 4, 2, 5);
  const auto onIt = test::compiledOn(cut, scene, [&](int) -> const Backend& { return *backend; });
  EXPECT_EQ(
      test::difference(test::render(scene, test::whole(scene.domain)), test::render(scene, cut.ranks, onIt)),
      "");
  EXPECT_EQ(validationMessages(*backend), std::vector<std::string>());
}

}  // namespace
}  // namespace gxy::vulkan_test

// SPDX-License-Identifier: Apache-2.0
// Where buffers lie in a device's memory, and what scenes share of it.
#include <gtest/gtest.h>

#include <cstring>
#include <regex>
#include <span>
#include <vector>

#include "backends/embree/embree_backend.h"
#include "backends/vulkan/lane.h"
#include "backends/vulkan/vulkan_scene.h"
#include "core/comm/error.h"
#include "core/rays/scene_memory.h"
#include "tests/agreement/draw.h"
#include "tests/support/frames.h"
#include "tests/vulkan/difference.h"
#include "tests/vulkan/test_device.h"

namespace gxy::vulkan_test {
namespace {

using vulkan::Buffer;
using vulkan::Place;

TEST(DeviceMemory, ManySmallBuffersAreInOneBlockAndNothingIsHeldWithoutThem) {
  const vulkan::Device device(testDevice());
  {
    std::vector<Buffer> buffers;
    for (int i = 0; i < 2000; i++) buffers.emplace_back(device, size_t(100 + i), Place::Device, "a test");
    EXPECT_EQ(device.blocks().blocks(), 1u);
    for (size_t i = 0; i < buffers.size(); i += 2) buffers[i] = {};
    for (size_t i = 0; i < buffers.size(); i += 2) buffers[i] = Buffer(device, 100, Place::Device, "a test");
    EXPECT_EQ(device.blocks().blocks(), 1u);
    // none overlaps another: each still holds what was written to it, which the host sees of software at least
    ASSERT_TRUE(buffers[0].mapped() || !isSoftware());
    for (size_t i = 0; buffers[0].mapped() && i < buffers.size(); i++)
      std::fill_n(buffers[i].mapped(), buffers[i].bytes(), std::byte(i % 251));
    for (size_t i = 0; buffers[0].mapped() && i < buffers.size(); i++)
      for (size_t k = 0; k < buffers[i].bytes(); k++)
        ASSERT_EQ(buffers[i].mapped()[k], std::byte(i % 251)) << i;
  }
  EXPECT_EQ(device.blocks().blocks(), 0u);
  EXPECT_EQ(device.blocks().bytes(), 0u);
}

TEST(DeviceMemory, LargeBuffersHaveBlocksOfTheirOwn) {
  const vulkan::Device device(testDevice());
  const Buffer large(device, size_t(48) << 20, Place::Device, "a test");
  const Buffer small(device, 1000, Place::Device, "a test");
  EXPECT_EQ(device.blocks().blocks(), 2u);
  EXPECT_LT(device.blocks().bytes(), size_t(48 + 65) << 20);
}

TEST(DeviceMemory, ThatTheDeviceDoesNotGiveIsOneErrorAndWhatFitsIsGiven) {
  VulkanOptions options = testDevice();
  options.memoryBytes = size_t(100) << 20;
  const vulkan::Device device(options);
  Buffer first(device, size_t(80) << 20, Place::Device, "volumes");
  try {
    const Buffer second(device, size_t(40) << 20, Place::Device, "geometry");
    FAIL() << "expected an error";
  } catch (const Error& e) {
    const std::string error = e.what();
    EXPECT_NE(error.find("has no 40 MiB left for geometry"), std::string::npos) << error;
    EXPECT_NE(error.find("of which this rank holds 80 MiB"), std::string::npos) << error;
  }
  EXPECT_EQ(device.bytes(), size_t(80) << 20);
  const Buffer small(device, size_t(1) << 20, Place::Device, "a test");  // no block of the usual size is left
  first = {};
  const Buffer second(device, size_t(40) << 20, Place::Device, "geometry");
}

TEST(DeviceMemory, OfASceneThatDoesNotFitIsFreed) {
  VulkanOptions options = testDevice();
  options.memoryBytes = size_t(64) << 10;
  const auto context = std::make_shared<vulkan::Context>(options);
  const test::TestScene scene = test::everything({24, 20});
  const auto compiled = test::compiledOn(test::whole(scene.domain), scene)[0].compiled;
  EXPECT_THROW(vulkan::VulkanScene(context, compiled, 0), Error);
  EXPECT_EQ(context->device.bytes(), 0u);
  EXPECT_EQ(context->device.blocks().bytes(), 0u);
}

// Two partitions of 33 MiB: each fits, and nothing is taken where both do not.
TEST(DeviceMemory, ThatASceneLacksInAllIsOneErrorBeforeAnythingIsThere) {
  test::TestScene scene = test::emptyScene("large");
  scene.domain = {glm::dvec3(0), {256, 255, 255}};
  const Grid grid{glm::dvec3(0), glm::dvec3(1), {257, 256, 256}};
  scene.data.emplace_back(
      std::make_shared<const test::WholeVolume>(test::sampled(grid, [](glm::dvec3 p) { return p.x; })));
  Vis& vis = scene.visualization.operators.emplace_back();
  vis.type = VisType::Volume;
  vis.volumeRendering = true;
  scene.camera = test::cameraOutside(scene.domain, {8, 8});
  const test::Cut cut = test::lattice(scene.domain, {2, 1, 1}, 1);
  const auto compiled = test::compiledOn(cut, scene)[0].compiled;
  Ledger ledger;
  VulkanOptions options = testDevice();
  options.ledger = &ledger;
  options.memoryBytes = size_t(50) << 20;
  {
    const auto backend = makeVulkanBackend(options);
    try {
      backend->makeScene(compiled, 0);
      FAIL() << "expected an error";
    } catch (const Error& e) {
      const std::string error = e.what();
      EXPECT_TRUE(std::regex_search(error, std::regex("has no 6[5-9] MiB left for the scene's volumes and "
                                                      "geometry in all: it has [0-9]+ MiB, of which this "
                                                      "rank holds 0 MiB;")))
          << error;
    }
    EXPECT_EQ(ledger.peak(), 0);
  }
  options.memoryBytes = size_t(160) << 20;  // small buffers take a block of 64
  const auto backend = makeVulkanBackend(options);
  const auto first = backend->makeScene(compiled, 0);
  const auto second = backend->makeScene(compiled, 0);  // with the same samples, which need no room again
  for (const DeviceScene* made : {first.get(), second.get()}) {
    size_t shared = 0;
    for (const SharedBytes& s : made->sharedBytes()) shared += s.bytes;
    EXPECT_GT(shared, size_t(64) << 20);
  }
}

TEST(DeviceMemory, IsInTheLedgerWhileItIsHeld) {
  Ledger ledger;
  VulkanOptions options = testDevice();
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

/// A large volume, which has a block of its own.
agreement::TestScene largeScene() {
  agreement::TestScene scene = agreement::sceneFrom("large", {0, 0, 4}, 8, 8);
  Grid grid;
  grid.points = {256, 256, 160};
  grid.spacing = {0.01, 0.01, 0.01};
  scene.add(agreement::rendered({{0, 0}, {1, 1}}),
            agreement::makeVolume(grid, [](glm::dvec3 p) { return p.x; }));
  return scene;
}
constexpr int64_t kLarge = 4 * 256 * 256 * 160;

TEST(DeviceMemory, OfSharedSamplesIsInTheLedgerOnceAsLongAsAnySceneShowsThem) {
  Ledger ledger;
  VulkanOptions options = testDevice();
  options.ledger = &ledger;
  const auto backend = makeVulkanBackend(options);
  agreement::TestScene scene = largeScene();
  const int64_t before = ledger.total();
  SceneMemory memory;
  struct Held {
    std::unique_ptr<DeviceScene> scene;
    SceneMemory::Entries entries;  // as those who make scenes do
  };
  const auto hold = [&] {
    const auto compiled = scene.compile();
    Held held{backend->makeScene(compiled, 0), {}};
    held.entries = memory.enter(*compiled, *held.scene,
                                [&](int64_t bytes) { return ledger.enter("user", "scene", bytes); });
    return held;
  };
  Held first = hold();
  const int64_t ofOne = ledger.total();
  EXPECT_GE(ofOne - before, kLarge);
  scene.visualization.operators[0].isovalues = {0.1};
  Held second = hold();
  EXPECT_LT(ledger.total(), ofOne + kLarge / 100);
  first = {};
  EXPECT_GE(ledger.total("user"), kLarge);
  EXPECT_LT(ledger.total("device"), ledger.total() - kLarge);
  second = {};
  EXPECT_EQ(ledger.total(), before);
}

TEST(DeviceMemory, OfSharedSamplesGivesTheSamePicture) {
  const auto backend = makeVulkanBackend(testDevice());
  agreement::TestScene scene = wavyScene();
  const auto first = backend->makeScene(scene.compile(), 0);
  scene.visualization.operators[0].isovalues = {0.1};
  EXPECT_EQ(difference(agreement::draw(*makeEmbreeBackend(), scene), agreement::draw(*backend, scene)), "");
}

TEST(DeviceMemory, OfSharedGeometryGivesTheSamePicture) {
  const auto backend = makeVulkanBackend(testDevice());
  agreement::TestScene scene = agreement::solids("solids", 32);
  const auto compiled = scene.compile();
  const auto first = backend->makeScene(compiled, 0);
  scene.visualization.lighting.Kd = 0.25;
  for (size_t i = 0; i < scene.data.size(); i++) {
    CompiledGeometry primitives;
    for (const auto& [partition, part] : compiled->operators[i].parts) primitives[partition] = part.geometry;
    scene.data[i].primitives = std::make_shared<const CompiledGeometry>(std::move(primitives));
  }
  const auto second = backend->makeScene(scene.compile(), 0);
  const auto sharedBy = [](const DeviceScene& s) {
    std::vector<const void*> all;
    for (const SharedBytes& shared : s.sharedBytes()) all.push_back(shared.what);
    return all;
  };
  EXPECT_EQ(sharedBy(*first), sharedBy(*second));
  EXPECT_FALSE(sharedBy(*first).empty());
  EXPECT_EQ(difference(agreement::draw(*makeEmbreeBackend(), scene), agreement::draw(*backend, scene)), "");
}

TEST(DeviceMemory, OfALaneIsForTheLargestOfItsBatchesNotForTheProductOfTheirLargestNumbers) {
  const vulkan::Device device(testDevice());
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

TEST(DeviceMemory, OutOfTheHostsSightIsFilledWhole) {
  VulkanOptions options = testDevice();
  options.hidesMemory = true;
  const vulkan::Device device(options);
  constexpr size_t kOffset = 12;
  for (size_t words : {1, 1 << 22, 11'000'003}) {  // some, one and three pieces of a copy
    std::vector<uint32_t> sent(words);
    for (size_t i = 0; i < words; i++) sent[i] = uint32_t(i * 2654435761u);
    const auto bytes = std::as_bytes(std::span(sent));
    const Buffer hidden(device, kOffset + bytes.size(), Place::Device, "a test");
    ASSERT_EQ(hidden.mapped(), nullptr);
    vulkan::upload(device, hidden, kOffset, bytes);
    const Buffer read(device, bytes.size(), Place::Readback, "a test");
    vulkan::Commands commands(device);
    const VkBufferCopy region{kOffset, 0, bytes.size()};
    const VkCommandBuffer c = commands.begin();
    commands.barrier();  // the layers do not know what is in sight by timeline semaphores
    vkCmdCopyBuffer(c, hidden.get(), read.get(), 1, &region);
    commands.barrier();
    commands.submit();
    commands.wait();
    EXPECT_EQ(std::memcmp(read.mapped(), sent.data(), bytes.size()), 0) << words;
  }
}

TEST(DeviceMemory, OfAnUploadIsFreedWhenTheDeviceIsLost) {
  constexpr size_t kBytes = size_t(80) << 20;
  const std::vector<std::byte> sent(kBytes);
  for (bool inWaits : {false, true}) {
    VulkanOptions options = testDevice();
    options.hidesMemory = true;
    options.lostAfter = 2;
    options.lostInWaits = inWaits;
    const vulkan::Device device(options);
    {
      const Buffer hidden(device, kBytes, Place::Device, "a test");
      EXPECT_THROW(vulkan::upload(device, hidden, 0, sent), Error);
    }
    EXPECT_EQ(device.bytes(), 0u);
  }
}

TEST(DeviceMemory, MayBeOutOfTheHostsSight) {
  VulkanOptions options = testDevice();
  options.hidesMemory = true;
  const auto backend = makeVulkanBackend(options);
  const test::TestScene scene = test::everything({24, 20});
  const test::Cut cut = test::kdCut(scene.domain, 4, 2, 5);
  const auto onIt = test::compiledOn(cut, scene, [&](int) -> const Backend& { return *backend; });
  EXPECT_EQ(difference(test::wholeOnEmbree(scene), test::render(scene, cut.ranks, onIt)), "");
}

}  // namespace
}  // namespace gxy::vulkan_test

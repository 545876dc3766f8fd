// SPDX-License-Identifier: Apache-2.0
// What a device cannot do in one go, or not at all.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <condition_variable>
#include <mutex>

#include "backends/embree/embree_backend.h"
#include "backends/vulkan/lane.h"
#include "backends/vulkan/scene_upload.h"
#include "core/comm/error.h"
#include "tests/agreement/draw.h"
#include "tests/support/frames.h"
#include "tests/vulkan/difference.h"
#include "tests/vulkan/test_device.h"

namespace gxy::vulkan_test {
namespace {

/// The counters of one tile that is spawned, and with one partition traced, too.
TraceCounters countersOf(const DeviceScene& scene, const CompiledFrame& frame) {
  const auto deviceFrame = scene.makeFrame(frame);
  std::mutex mutex;
  std::condition_variable answered;
  std::optional<TraceResult> result;
  scene.spawn(*deviceFrame, {0, 0, frame.width, frame.height, 0}, [&](TraceResult r) {
    std::lock_guard lock(mutex);
    result = std::move(r);
    answered.notify_one();
  });
  std::unique_lock lock(mutex);
  answered.wait(lock, [&] { return result.has_value(); });
  EXPECT_EQ(result->error, "");
  return result->counters;
}

TEST(IdleTime, IsNotThatBetweenFrames) {
  agreement::TestScene scene = agreement::sceneFrom("wavy", {0, 0, 4}, 8, 8);
  scene.add(agreement::rendered({{0, 0}, {1, 1}}), agreement::wavy());
  const auto compiled = scene.compile();
  const auto device = testedVulkan().makeScene(compiled, 0);
  for (uint32_t frame = 0; frame < 3; frame++) {
    const TraceCounters c = countersOf(*device, compileFrame(*compiled, scene.camera, frame, false));
    EXPECT_EQ(c.submissions, 1u);
    EXPECT_EQ(c.nsDeviceIdle, 0u) << frame;
  }
}

/// The same picture as Embree's; on software in several submissions, as lavapipe ends loops after 65535 rounds.
void expectTheSameInParts(const agreement::TestScene& scene) {
  const auto compiled = scene.compile();
  const auto device = testedVulkan().makeScene(compiled, 0);
  const TraceCounters c = countersOf(*device, compileFrame(*compiled, scene.camera, 0, true));
  if (isSoftware()) {
    EXPECT_GT(c.submissions, 2u) << c.samples << " samples";
  }
  EXPECT_EQ(difference(agreement::draw(*makeEmbreeBackend(), scene), agreement::draw(testedVulkan(), scene)),
            "");
}

/// 100,000 cells along the rays, all of which stay inside.
agreement::TestScene needle() {
  agreement::TestScene scene = agreement::sceneFrom("needle", {0, 0, 5.01}, 4, 4);
  scene.camera.viewdirection = {0, 0, -1};
  scene.camera.aov = 0.3;
  scene.settings.step = 0.5;
  Grid grid;
  grid.points = {2, 2, 100'000};
  grid.spacing = {0.1, 0.1, 1e-4};
  grid.origin = {-0.05, -0.05, -5};
  scene.add(agreement::rendered({{-1, 0.01}, {1, 0.05}}, -1, 1, true),
            agreement::makeVolume(grid, [](glm::dvec3 p) { return 18 * p.x + 0.1 * std::sin(900 * p.z); }));
  return scene;
}

TEST(LongLoops, OfAMarch) { expectTheSameInParts(needle()); }

TEST(LongLoops, OfSeveralVolumes) {
  agreement::TestScene scene = needle();
  const Vis vis = scene.visualization.operators[0];
  scene.add(vis, scene.data[0].volume);
  expectTheSameInParts(scene);
}

// What primaries have made is traced in the same submission, but not before all of them have ended.
TEST(LongLoops, OfPrimariesThatMakeSecondaries) {
  agreement::TestScene scene = needle();
  GeometryBlock block;
  block.points = {{0, 0, -5}};
  Vis vis = agreement::surfaces(VisType::Particles);
  vis.radius0 = vis.radius1 = 0.03;
  scene.add(vis, agreement::makeGeometry(GeometryKind::Particles, std::move(block)));
  scene.visualization.lighting.aoCount = 2;
  expectTheSameInParts(scene);
}

TEST(LongLoops, OfAnIsosurfaceThatPassesBesideTheRays) {
  agreement::TestScene scene = needle();
  Vis& vis = scene.visualization.operators[0];
  vis.volumeRendering = false;
  vis.isovalues = {0.9};
  expectTheSameInParts(scene);
}

TEST(LongLoops, OfCoincidentParticles) {
  agreement::TestScene scene = agreement::sceneFrom("coincident", {0, 0, 4}, 2, 2);
  GeometryBlock block;
  block.points.assign(200'000, {0.1, 0.2, 0.3});
  Vis vis = agreement::surfaces(VisType::Particles);
  vis.radius0 = vis.radius1 = 1;
  scene.add(vis, agreement::makeGeometry(GeometryKind::Particles, std::move(block)));
  expectTheSameInParts(scene);
}

VulkanOptions lostAfter(uint64_t submissions, bool inWaits) {
  VulkanOptions options = testDevice();
  options.lostAfter = submissions;
  options.lostInWaits = inWaits;
  return options;
}

/// Whether scenes are made without submissions, of which tests of lost devices count those of frames: copies to memory that
/// the host does not see are some, too.
bool uploadsTakeNoSubmission() {
  const vulkan::Device device(testDevice());
  const bool mapped = vulkan::Buffer(device, 1000, vulkan::Place::Device, "a test").mapped();
  EXPECT_TRUE(mapped || !isSoftware());
  return mapped;
}

/// Of few stages, as each device that is to be lost compiles its own: surfaces whose rays make secondaries.
test::TestScene litSurfaces() {
  test::TestScene scene = test::emptyScene("lit surfaces", {12, 10});
  test::addParticles(scene, 1);
  test::addMesh(scene, 1);
  test::addLights(scene);
  return scene;
}

TEST(LostDevice, EndsItsFramesWithAnErrorAndNoOthers) {
  if (!uploadsTakeNoSubmission()) GTEST_SKIP() << "the device would be lost while the scene is made";
  const test::TestScene scene = litSurfaces();
  const test::Cut cut = test::kdCut(scene.domain, 4, 2, 5);
  const auto embree = makeEmbreeBackend();
  const Picture expected = test::wholeOnEmbree(scene);
  for (const auto& [submissions, inWaits] : {std::pair{1, false}, {4, false}, {1, true}, {4, true}}) {
    const auto lost = makeVulkanBackend(lostAfter(uint64_t(submissions), inWaits));
    const auto broken =
        test::compiledOn(cut, scene, [&](int rank) -> const Backend& { return rank == 1 ? *lost : *embree; });
    const auto sound = test::compiledOn(cut, scene);
    test::Frames frames(cut.ranks, {});
    frames.add(1, broken);
    frames.add(2, sound);
    FrameRequest request = test::requestOf(scene);
    const FrameId first = frames.start(request), second = frames.start(request);
    request.scene = 2;
    const FrameId other = frames.start(request);
    frames.run();
    EXPECT_EQ(frames.errors(), std::vector<std::string>());
    for (FrameId id : {first, second}) {
      EXPECT_EQ(frames.outcome(id).pictures, 0);
      EXPECT_NE(frames.outcome(id).error.find("the device was lost"), std::string::npos)
          << frames.outcome(id).error;
    }
    EXPECT_EQ(difference(expected, frames.outcome(other).picture), "");
    EXPECT_EQ(frames.renderer(1).kept().credits, 0);
  }
}

/// What `auto` gives on a machine with such a device.
std::unique_ptr<Backend> autoOn(const VulkanOptions& options) {
  BackendRegistry registry;
  registry.add("vulkan", [&](Ledger*) { return makeVulkanBackend(options); });
  registry.add("embree", [](Ledger*) { return makeEmbreeBackend(); });
  return registry.make("auto");
}

TEST(LostDevice, OfAutoLeavesItsScenesToTheNextBackend) {
  if (!uploadsTakeNoSubmission()) GTEST_SKIP() << "the device would be lost while the scene is made";
  const test::TestScene scene = litSurfaces();
  const test::Cut cut = test::kdCut(scene.domain, 4, 2, 5);
  const auto embree = makeEmbreeBackend();
  const Picture expected = test::wholeOnEmbree(scene);
  for (const auto& [submissions, inWaits] : {std::pair{1, false}, {4, true}}) {
    const auto lost = autoOn(lostAfter(uint64_t(submissions), inWaits));
    const auto onIt = [&](int rank) -> const Backend& { return rank == 1 ? *lost : *embree; };
    test::Frames frames(cut.ranks, {});
    const auto first = test::compiledOn(cut, scene, onIt), second = test::compiledOn(cut, scene, onIt);
    frames.add(1, first);
    frames.add(2, second);
    EXPECT_EQ(lost->name(), "vulkan");
    FrameRequest request = test::requestOf(scene);
    const FrameId underWay = frames.start(request);
    frames.run();
    EXPECT_NE(frames.outcome(underWay).error.find("the device was lost"), std::string::npos)
        << frames.outcome(underWay).error;
    EXPECT_EQ(lost->name(), "embree");
    const auto third = test::compiledOn(cut, scene, onIt);
    frames.add(3, third);
    for (request.scene = 1; request.scene <= 3; request.scene++) {
      const FrameId next = frames.start(request);
      frames.run();
      EXPECT_EQ(frames.outcome(next).error, "") << request.scene;
      EXPECT_EQ(difference(expected, frames.outcome(next).picture), "") << request.scene;
    }
    EXPECT_EQ(frames.errors(), std::vector<std::string>());
    EXPECT_EQ(frames.renderer(1).kept().credits, 0);
  }
}

TEST(FullDevice, OfAutoLeavesASceneToTheNextBackend) {
  VulkanOptions options = testDevice();
  options.memoryBytes = size_t(64) << 10;
  const auto full = autoOn(options);
  const test::TestScene scene = test::everything({12, 10});
  const test::Cut cut = test::kdCut(scene.domain, 4, 2, 5);
  const auto onIt = test::compiledOn(cut, scene, [&](int) -> const Backend& { return *full; });
  EXPECT_EQ(difference(test::wholeOnEmbree(scene), test::render(scene, cut.ranks, onIt)), "");
  EXPECT_EQ(full->name(), "vulkan") << "it is there for what fits";
  const auto named = makeVulkanBackend(options);
  EXPECT_THROW(test::compiledOn(cut, scene, [&](int) -> const Backend& { return *named; }), Error);
}

/// Tiles that wait until all are asked for: the first, when it is answered, holds up the thread that waits for the device.
class HeldUp {
 public:
  HeldUp(const DeviceScene& device, const DeviceFrame& first, const SpawnTile& tile) : device_(device) {
    spawn(first, tile);
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return answers_ > 0; });
  }

  void spawn(const DeviceFrame& frame, const SpawnTile& tile) {
    asked_++;
    device_.spawn(frame, tile, [this](TraceResult result) {
      std::unique_lock lock(mutex_);
      answers_++;
      failures_ += !result.error.empty();
      changed_.notify_all();
      changed_.wait(lock, [&] { return allAsked_; });
    });
  }

  /// How many have failed, when all are answered.
  int failures() {
    std::unique_lock lock(mutex_);
    allAsked_ = true;
    changed_.notify_all();
    changed_.wait_for(lock, std::chrono::seconds(60), [&] { return answers_ == asked_; });
    EXPECT_EQ(answers_, asked_);
    return failures_;
  }

 private:
  const DeviceScene& device_;
  std::mutex mutex_;
  std::condition_variable changed_;
  int asked_ = 0, answers_ = 0, failures_ = 0;
  bool allAsked_ = false;
};

// All that the device has at once fails while more waits.
TEST(LostDevice, AnswersWhatWaits) {
  if (!uploadsTakeNoSubmission()) GTEST_SKIP() << "the device would be lost while the scene is made";
  const auto backend = makeVulkanBackend(lostAfter(1, true));
  agreement::TestScene scene = agreement::sceneFrom("lost", {0, 0, 4}, 8, 8);
  scene.add(agreement::rendered({{0, 0}, {1, 1}}), agreement::wavy());
  const auto compiled = scene.compile();
  const auto device = backend->makeScene(compiled, 0);
  constexpr int kFrames = 12;  // which are not done together
  std::vector<std::shared_ptr<const DeviceFrame>> frames;
  for (uint32_t i = 0; i < kFrames; i++)
    frames.push_back(device->makeFrame(compileFrame(*compiled, scene.camera, i, false)));
  HeldUp held(*device, *frames[0], {0, 0, 8, 8, 0});
  for (size_t i = 1; i < kFrames; i++) held.spawn(*frames[i], {0, 0, 8, 8, 0});
  EXPECT_GE(held.failures(), kFrames - 1);
}

/// Balls that fill most of the picture; every hit makes `occlusion` rays.
agreement::TestScene occluded(int size, int occlusion) {
  agreement::TestScene scene = agreement::sceneFrom("occluded", {0, 0, 4}, size, size);
  GeometryBlock block;
  block.points = {{-0.3, 0, 0}, {0.3, 0.1, 0}};
  Vis vis = agreement::surfaces(VisType::Particles);
  vis.radius0 = vis.radius1 = 1;
  scene.add(vis, agreement::makeGeometry(GeometryKind::Particles, std::move(block)));
  scene.visualization.lighting.aoCount = occlusion;
  return scene;
}

/// Pixels that show a surface.
int seen(const Picture& picture) {
  return int(std::count_if(picture.depth.begin(), picture.depth.end(), [](double d) { return d < 1e30; }));
}

// All at once they would be more than the device binds, which the validation layer would tell.
TEST(Batches, AreWithinWhatTheDeviceBinds) {
  const vulkan::Device device(testDevice());
  const agreement::TestScene scene = occluded(128, 128);
  if (!isSoftware() && vulkan::mostRays(device) >= 128u * 128 * 129)
    GTEST_SKIP() << "this GPU binds all of them: " << vulkan::mostRays(device);
  ASSERT_GT(128u * 128 * 129, vulkan::mostRays(device));
  const Picture expected = agreement::draw(*makeEmbreeBackend(), scene);
  EXPECT_GT(seen(expected), 128 * 128 / 2);
  EXPECT_EQ(difference(expected, agreement::draw(testedVulkan(), scene)), "");
}

// A tile of one pixel takes the workgroups of a large one: all at once they would be more than the device dispatches, which the
// validation layer would tell.
TEST(Batches, OfTilesAreWithinWhatTheDeviceDispatches) {
  constexpr int kTiles = 5000;
  const size_t most = vulkan::mostRays(vulkan::Device(testDevice()));
  if (!isSoftware() && most >= size_t(kTiles) * TILE_RAYS)
    GTEST_SKIP() << "this GPU dispatches all of them: " << most;
  ASSERT_GT(size_t(kTiles) * TILE_RAYS, most);
  agreement::TestScene scene = occluded(1, 0);
  scene.settings.raysPerPixel = kTiles;
  const auto compiled = scene.compile();
  const auto device = testedVulkan().makeScene(compiled, 0);
  const auto frame = device->makeFrame(compileFrame(*compiled, scene.camera, 0, false));
  HeldUp held(*device, *frame, {0, 0, 1, 1, 0});
  for (int sample = 1; sample < kTiles; sample++) held.spawn(*frame, {0, 0, 1, 1, sample});
  EXPECT_EQ(held.failures(), 0);
}

TEST(Batches, LargerThanOthersLeaveNoLaneOfTheirSize) {
  Ledger ledger;
  VulkanOptions options = testDevice();
  options.ledger = &ledger;
  const auto backend = makeVulkanBackend(options);
  const int occlusion = isSoftware() ? 600 : 1100;  // a GPU's batches are larger
  agreement::draw(*backend, occluded(32, occlusion));
  EXPECT_GT(ledger.peak(), int64_t(1024 * size_t(1 + occlusion) * vulkan::kRayBytes));
  EXPECT_EQ(ledger.total(), 0);
}

// A needle of cells of which the last alone shows something: lavapipe ends loops of 65535 rounds.
TEST(Partitions, ByHundredsBeforeTheFirstThatIsSeen) {
  test::TestScene s = test::emptyScene("needle");
  s.domain = {{0, 0, 0}, {100, 1, 1}};
  const Grid grid{{0, 0, 0}, {0.25, 1, 1}, {401, 2, 2}};
  s.data.emplace_back(
      std::make_shared<const test::WholeVolume>(test::sampled(grid, [](glm::dvec3 p) { return p.x; })));
  Vis& vis = s.visualization.operators.emplace_back();
  vis.type = VisType::Volume;
  vis.dataset = "field";
  vis.colormap = {{{0, {1, 0, 0}}, {100, {0, 0, 1}}}};
  vis.isovalues = {99.9};
  s.visualization.lighting.aoCount = 2;
  s.camera.viewpoint = {-4, 0.4, 0.45};
  s.camera.viewdirection = {1, 0, 0};
  s.camera.viewup = {0, 1, 0};
  s.camera.aov = 0;
  s.camera.height = 1;
  s.camera.dimensions = {16, 16};
  const Picture expected = test::wholeOnEmbree(s);
  EXPECT_GT(seen(expected), 100);
  for (const int cells : {2, 400}) {
    const test::Cut cut = test::lattice(s.domain, {cells, 1, 1}, 1);
    EXPECT_EQ(
        difference(expected, test::render(s, cut.ranks,
                                          test::compiledOn(
                                              cut, s, [](int) -> const Backend& { return testedVulkan(); }))),
        "")
        << cells;
  }
}

// 1024 rays with as many secondaries each are more than a list holds.
TEST(Batches, OfATileThatIsTooLargeAreSeveral) {
  const agreement::TestScene scene = occluded(32, 1100);
  EXPECT_EQ(difference(agreement::draw(*makeEmbreeBackend(), scene), agreement::draw(testedVulkan(), scene)),
            "");
}

// From as far away as these secondaries start no geometry is met (clip.h).
TEST(HugeSpheres, OfWhichRaysStartAreTheSameOnBothBackends) {
  agreement::TestScene scene = occluded(24, 2);
  scene.visualization.lighting = agreement::lit({agreement::kSun, agreement::kLamp}, true);
  scene.visualization.lighting.aoCount = 2;
  for (double radius : {5e18, 1e19, 1e300}) {
    scene.visualization.operators[0].radius0 = scene.visualization.operators[0].radius1 = radius;
    const Picture expected = agreement::draw(*makeEmbreeBackend(), scene);
    EXPECT_EQ(seen(expected), radius < 1e300 ? 24 * 24 : 0);
    EXPECT_EQ(difference(expected, agreement::draw(testedVulkan(), scene)), "") << radius;
  }
}

TEST(Volumes, AreNumberedInThirtyTwoBits) {
  EXPECT_NO_THROW(vulkan::checkNumbering({1 << 11, 1 << 10, 1 << 10}, 1));
  EXPECT_THROW(vulkan::checkNumbering({1 << 11, 1 << 10, (1 << 10) + 1}, 1), Error);
  EXPECT_NO_THROW(vulkan::checkNumbering({1 << 10, 1 << 10, 1 << 10}, 4));
  EXPECT_THROW(vulkan::checkNumbering({1 << 10, 1 << 10, 1 << 10}, 5), Error);
  // bricks are filled up
  EXPECT_THROW(vulkan::checkNumbering({1025, 1025, 1017}, 4), Error);
  EXPECT_THROW(vulkan::checkNumbering({2, 2, int64_t(1) << 27}, 1), Error);
}

}  // namespace
}  // namespace gxy::vulkan_test

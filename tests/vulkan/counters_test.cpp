// SPDX-License-Identifier: Apache-2.0
// What was done and what was skipped is the same on this backend as on the other (docs/statistics.md).
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <future>

#include "backends/vulkan/vulkan_scene.h"
#include "tests/support/frames.h"
#include "tests/vulkan/difference.h"
#include "tests/vulkan/test_device.h"

namespace gxy::test {
namespace {

Renderer::Counters countersOf(const TestScene& scene, const BackendOf& backendOf) {
  const Cut cut = lattice(scene.domain, {2, 1, 1}, 2);
  Frames frames(cut.ranks, {});
  frames.add(1, compiledOn(cut, scene, backendOf));
  frames.start(requestOf(scene));
  frames.run();
  EXPECT_EQ(frames.errors(), std::vector<std::string>());
  Renderer::Counters sum;
  for (int rank = 0; rank < cut.ranks; rank++) {
    const Renderer::Counters c = frames.renderer(rank).counters();
    sum.trace += c.trace;
    sum.partitionsSkipped += c.partitionsSkipped;
    sum.tilesSkipped += c.tilesSkipped;
  }
  return sum;
}

TEST(VulkanCounters, AreThoseOfEmbree) {
  const std::vector<std::string> names{"spiky volume", "several volumes", "translucent isosurfaces",
                                       "translucent surfaces", "shadows and occlusion"};
  size_t found = 0;
  for (TestScene& s : scenesOfEachKind()) {
    if (std::find(names.begin(), names.end(), s.name) == names.end()) continue;
    SCOPED_TRACE(s.name);
    found++;
    if (s.name ==
        "several volumes") {  // where maps are narrow, too, Mesa's software device does some rays in parts
      s.data.pop_back();
      s.visualization.operators.pop_back();
    }
    const Renderer::Counters expected = countersOf(s, {});
    const Renderer::Counters c =
        countersOf(s, [](int) -> const Backend& { return vulkan_test::testedVulkan(); });
    EXPECT_EQ(c.partitionsSkipped, expected.partitionsSkipped);
    EXPECT_EQ(c.tilesSkipped, expected.tilesSkipped);
    using T = TraceCounters;
    for (const auto counter :
         {&T::raysSpawned, &T::raysTraced, &T::raysShaded, &T::secondariesSpawned, &T::secondariesSkipped,
          &T::raysEndedEarly, &T::samples, &T::macrocells, &T::macrocellsSkipped, &T::segmentsSkipped,
          &T::cells, &T::isoMacrocellsSkipped})
      EXPECT_EQ(c.trace.*counter, expected.trace.*counter);
    for (size_t k = 0; k < kKernels; k++)
      EXPECT_EQ(c.trace.kernelRuns[k] > 0, expected.trace.kernelRuns[k] > 0) << kKernelNames[k];
  }
  EXPECT_EQ(found, names.size());
}

// Rays that go on in another partition of the rank wait on the device, as far as there is room for them; the picture is the same.
TEST(VulkanCounters, OnlyRaysThatLeaveTheRankComeBack) {
  VulkanOptions full = vulkan_test::testDevice();
  full.keptBytes = 1;
  const auto withoutRoom = makeVulkanBackend(full);
  const std::vector<std::string> names{"several volumes", "translucent surfaces", "shadows and occlusion"};
  size_t found = 0;
  for (TestScene& s : scenesOfEachKind()) {
    if (std::find(names.begin(), names.end(), s.name) == names.end()) continue;
    SCOPED_TRACE(s.name);
    found++;
    s.camera.dimensions /= 4;
    const Picture expected = wholeOnEmbree(s);
    for (const int ranks : {1, 2})
      for (const bool room : {true, false}) {
        if (!room && s.name == "several volumes")
          continue;  // whose shaders take longest to compile, for a second device
        SCOPED_TRACE(std::to_string(ranks) + " ranks, " + (room ? "room" : "no room"));
        const Cut cut = lattice(s.domain, {2, 3, 1}, ranks);
        Frames frames(cut.ranks, {});
        frames.add(1, compiledOn(cut, s, [&](int) -> const Backend& {
                     return room ? vulkan_test::testedVulkan() : *withoutRoom;
                   }));
        const FrameId frame = frames.start(requestOf(s));
        frames.run();
        EXPECT_EQ(frames.errors(), std::vector<std::string>());
        EXPECT_EQ(vulkan_test::difference(expected, frames.outcome(frame).picture), "");
        uint64_t read = 0, forwarded = 0;
        for (int rank = 0; rank < ranks; rank++) {
          read += frames.renderer(rank).counters().trace.raysRead;
          forwarded += frames.renderer(rank).counters().raysForwarded;
        }
        EXPECT_EQ(forwarded > 0, ranks > 1);
        if (room)
          EXPECT_EQ(read, forwarded);
        else
          EXPECT_GT(read, forwarded);
      }
  }
  EXPECT_EQ(found, names.size());
}

// Or the last of a device would go behind its last answer, on a thread of its own, perhaps when the process has ended.
TEST(VulkanCounters, RaysThatWaitedAreGoneWhenTheirEndIsTold) {
  TestScene s = emptyScene("two partitions", {kTile, kTile});
  addSmoothVolume(s);
  const auto embreeScenes =
      compiledOn(lattice(s.domain, {2, 1, 1}, 1), s, [](int) -> const Backend& { return embree(); });
  const auto context = std::make_shared<vulkan::Context>(vulkan_test::testDevice());
  const vulkan::VulkanScene device(context, embreeScenes[0].compiled, 0);
  const auto frame = device.makeFrame(compileFrame(*embreeScenes[0].compiled, s.camera, 0, false));
  // What leaves, and how many owned the context when that was told.
  struct Told {
    std::vector<LeavingRays> leaving;
    long owners;
  };
  const auto told = [&](const std::function<void(DeviceScene::Done)>& ask) {
    std::promise<Told> promise;
    ask([&](TraceResult result) {
      EXPECT_EQ(result.error, "");
      promise.set_value({std::move(result.leaving), context.use_count()});
    });
    return promise.get_future().get();
  };
  std::vector<LeavingRays> waiting = told([&](DeviceScene::Done done) {
                                       device.spawn(*frame, {0, 0, kTile, kTile, 0}, std::move(done));
                                     }).leaving;
  int traced = 0;
  while (!waiting.empty()) {
    LeavingRays next = std::move(waiting.back());
    waiting.pop_back();
    EXPECT_NE(next.rays.kept(), nullptr);
    const bool last = waiting.empty();
    Told end = told([&](DeviceScene::Done done) {
      device.trace(*frame, next.partition, next.primary, std::move(next.rays), std::move(done));
    });
    traced++;
    if (last && end.leaving.empty()) {
      EXPECT_EQ(end.owners, 2) << "the test and the scene";
    }
    for (LeavingRays& more : end.leaving) waiting.push_back(std::move(more));
  }
  EXPECT_GT(traced, 1);
}

// A hierarchy over two spheres is one node with two leaves.
TEST(VulkanCounters, NodesAndPrimitivesAreCountedWhereThatIsAskedFor) {
  TestScene s = emptyScene("spheres", {24, 20});
  s.domain = {glm::dvec3(-1), glm::dvec3(1)};
  s.camera = cameraOutside(s.domain, {24, 20});
  auto geometry = std::make_shared<WholeGeometry>();
  geometry->block.points = {{-0.5, -0.7, 0}, {-0.5, 0.7, 0}};
  geometry->block.ids = {0, 1};
  Vis& vis = s.visualization.operators.emplace_back();
  vis.type = VisType::Particles;
  vis.radius0 = vis.radius1 = 0.2;
  s.data.emplace_back(std::move(geometry));
  VulkanOptions options = vulkan_test::testDevice();
  options.countsNodes = true;
  const auto counting = makeVulkanBackend(options);
  const TraceCounters c = countersOf(s, [&](int) -> const Backend& { return *counting; }).trace;
  EXPECT_GT(c.raysShaded, 0u);
  EXPECT_EQ(c.nodes, c.raysTraced);
  EXPECT_GE(c.primitives, c.raysShaded);
  EXPECT_LT(c.primitives, c.nodes) << "rays pass between them";
  EXPECT_EQ(countersOf(s, [](int) -> const Backend& { return vulkan_test::testedVulkan(); }).trace.nodes, 0u);
}

// Of several frames in several partitions (device_time_test.cpp has the sums).
TEST(VulkanCounters, WorkingAndIdleTheDeviceIsNoLongerThanTheFramesTake) {
  const TestScene scene = everything({12, 10});
  const Cut cut = lattice(scene.domain, {2, 2, 1}, 1);
  Frames frames(cut.ranks, {});
  frames.add(1, compiledOn(cut, scene, [](int) -> const Backend& { return vulkan_test::testedVulkan(); }));
  const auto begin = std::chrono::steady_clock::now();
  for (int i = 0; i < 3; i++) frames.start(requestOf(scene));
  frames.run();
  const auto taken =
      std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - begin).count();
  EXPECT_EQ(frames.errors(), std::vector<std::string>());
  const TraceCounters c = frames.renderer(0).counters().trace;
  if (c.nsDevice == 0 && !vulkan_test::isSoftware()) GTEST_SKIP() << "this GPU has no clock";
  EXPECT_GT(c.nsDevice, 0u);
  EXPECT_GE(c.nsDeviceIdle, 0);
  EXPECT_LE(double(c.nsDevice) + double(c.nsDeviceIdle), 1.001 * taken);  // two clocks
  EXPECT_GE(1.001 * double(c.nsDeviceAsked), double(c.nsDevice)) << "it does what it was asked to";
  EXPECT_LE(double(c.nsDeviceAsked), taken);
  EXPECT_GT(c.nsWork(), 0u);
  if (vulkan_test::isSoftware()) {  // where one batch begins when another has ended
    EXPECT_LE(c.nsWork(), c.nsDevice);
  }
}

// Or a server would keep what every scene that it has ever had was drawn with.
TEST(VulkanCounters, PipelinesThatNobodyNeedsAreForgotten) {
  using vulkan::Stage;
  const vulkan::Device device(vulkan_test::testDevice());
  vulkan::Pipelines pipelines(device, 2);
  const vulkan::Pipeline held = pipelines.get(Stage::Take, {});
  for (Stage stage : {Stage::Bound, Stage::Finish, Stage::Groups, Stage::Finish, Stage::Depth})
    pipelines.get(stage, {});
  EXPECT_EQ(pipelines.stages(), (std::vector{Stage::Depth, Stage::Finish, Stage::Take}));
  EXPECT_NE(held->get(), VK_NULL_HANDLE);
  EXPECT_EQ(pipelines.get(Stage::Take, {}), held);
}

// The shader of each stage is compiled for what the scene has, and only where it is needed; and before any frame.
TEST(VulkanCounters, NothingIsCompiledThatASceneDoesNotNeed) {
  using vulkan::Stage;
  const auto stagesOf = [](const TestScene& scene, const Cut& cut) {
    const auto context = std::make_shared<vulkan::Context>(vulkan_test::testDevice());
    const auto compiled = compiledOn(cut, scene)[0].compiled;
    const auto device = std::make_shared<vulkan::VulkanScene>(context, compiled, 0);
    const std::vector<Stage> before = context->pipelines.stages();
    render(scene, 1, {{compiled, device}});
    const std::vector<Stage> all = context->pipelines.stages();
    std::vector<Stage> withoutDepths;
    std::remove_copy(all.begin(), all.end(), std::back_inserter(withoutDepths), Stage::Depth);
    EXPECT_EQ(before, withoutDepths) << scene.name << " in " << cut.partitioning.partitions();
    return all;
  };
  const std::vector<TestScene> scenes = scenesOfEachKind();
  const auto named = [&](const char* name) {
    return *std::find_if(scenes.begin(), scenes.end(), [&](const TestScene& s) { return s.name == name; });
  };
  const TestScene isosurfaces = named("isosurfaces"), volume = named("smooth volume"),
                  all = everything({12, 10});
  EXPECT_EQ(stagesOf(isosurfaces, whole(isosurfaces.domain)),
            (std::vector{Stage::Spawn, Stage::Bound, Stage::Isosurfaces, Stage::Shade, Stage::Depth,
                         Stage::Finish, Stage::Groups}));
  EXPECT_EQ(stagesOf(volume, whole(volume.domain)),
            (std::vector{Stage::Spawn, Stage::Bound, Stage::Integrate, Stage::Finish, Stage::Groups}));
  EXPECT_GT(stagesOf(all, whole(all.domain)).size(), 10u);
  // rays wait on the device between several partitions of the rank
  const auto cut = [](const TestScene& scene) { return lattice(scene.domain, {2, 2, 1}, 1); };
  EXPECT_EQ(stagesOf(isosurfaces, cut(isosurfaces)),
            (std::vector{Stage::Spawn, Stage::Bound, Stage::Isosurfaces, Stage::Shade, Stage::Depth,
                         Stage::Finish, Stage::Groups, Stage::Take}));
  EXPECT_EQ(stagesOf(volume, cut(volume)),
            (std::vector{Stage::Spawn, Stage::Bound, Stage::Integrate, Stage::Finish, Stage::Take}));
  EXPECT_GT(stagesOf(all, cut(all)).size(), 10u);
}

}  // namespace
}  // namespace gxy::test

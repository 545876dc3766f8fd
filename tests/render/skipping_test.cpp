// SPDX-License-Identifier: Apache-2.0
// What a scene does not need is not done, and is counted (docs/statistics.md).
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <deque>
#include <functional>
#include <glm/geometric.hpp>
#include <set>

#include "backends/embree/embree_backend.h"
#include "backends/embree/geometry_tree.h"
#include "core/kernels/single_views.h"
#include "core/rays/scene_memory.h"
#include "core/rays/step_plan.h"
#include "tests/support/backends.h"
#include "tests/support/every_cell.h"
#include "tests/support/frames.h"

// The linker puts this in the place of Embree's.
extern "C" {
void* __real_rtcNewBVH(void* device);
static std::atomic<int> treesMade = 0;
void* __wrap_rtcNewBVH(void* device) {
  treesMade++;
  return __real_rtcNewBVH(device);
}
}

namespace gxy::test {
namespace {

const Box kCube{{-1, -1, -1}, {1, 1, 1}};
constexpr int kPixels = 64, kTiles = 4;  // the picture is a square

// Looks along x at the cube, which reaches beyond the picture: every ray meets both halves of a cut at x = 0.
TestScene alongX() {
  TestScene s = emptyScene("along x");
  s.domain = kCube;
  s.visualization.lighting.sources = {};
  Camera& c = s.camera;
  c.viewpoint = {-4, 0, 0};
  c.viewdirection = {1, 0, 0};
  c.viewup = {0, 1, 0};
  c.aov = 0;
  c.height = 1.8;
  c.dimensions = {kPixels, kPixels};
  return s;
}

// Of macrocells on each axis of the cube.
Vis& addField(TestScene& s, int macrocells, const std::function<double(glm::dvec3)>& f) {
  const int64_t cells = kMacrocellSize * macrocells;
  const Grid grid{kCube.lo, glm::dvec3(2.0 / double(cells)), {cells + 1, cells + 1, cells + 1}};
  s.data.emplace_back(std::make_shared<const WholeVolume>(sampled(grid, f)));
  Vis& vis = s.visualization.operators.emplace_back();
  vis.type = VisType::Volume;
  vis.dataset = "field";
  vis.colormap = {{{-1, {1, 0, 0}}, {1, {0, 0, 1}}}};
  return vis;
}

Vis& addPlane(TestScene& s, double x, double opacity = 1) {
  Vis& vis = addField(s, 2, [](glm::dvec3 p) { return p.x; });
  vis.isovalues = {x};
  vis.opacity = opacity;
  return vis;
}

void addBall(TestScene& s, glm::dvec3 centre, double radius) {
  WholeGeometry g;
  g.block.points = {centre};
  g.block.ids = {0};
  s.data.emplace_back(std::make_shared<const WholeGeometry>(g));
  Vis& vis = s.visualization.operators.emplace_back();
  vis.type = VisType::Particles;
  vis.dataset = "ball";
  vis.radius0 = vis.radius1 = radius;
}

/// So many volumes that are rendered, of four macrocells along x, by which values rise from -1 to 1.
void addRendered(TestScene& s, int volumes, const std::vector<OpacityPoint>& opacity) {
  for (int k = 0; k < volumes; k++) {
    Vis& vis = addField(s, 4, [](glm::dvec3 p) { return p.x; });
    vis.volumeRendering = true;
    vis.opacitymap = {false, opacity};
  }
}

Cut halves() { return lattice(kCube, {2, 1, 1}, 2); }

/// One frame of a scene, or several, and what each rank counted.
struct Counted {
  Counted(const TestScene& scene, const Cut& cut, int pictures = 1)
      : Counted(scene, cut, compiledOn(cut, scene), pictures) {}
  Counted(const TestScene& scene, const Cut& cut, const std::vector<RankScene>& compiled, int pictures = 1)
      : frames(cut.ranks, {}) {
    frames.add(1, compiled);
    for (int i = 0; i < pictures; i++) {
      const FrameId id = frames.start(requestOf(scene));
      frames.run();
      EXPECT_EQ(frames.outcome(id).pictures, 1) << frames.outcome(id).error;
    }
    EXPECT_EQ(frames.errors(), std::vector<std::string>());
    for (int r = 0; r < cut.ranks; r++) all += of(r).trace;
  }
  Renderer::Counters of(int rank) { return frames.renderer(rank).counters(); }

  Frames frames;
  TraceCounters all;
};

TEST(Skipped, CellsAreThoseThatNoIsovaluePassesThrough) {
  TestScene s = alongX();
  addPlane(s, -0.45);  // between two points: in one of 16 layers of cells, in 4 of 8 macrocells
  EXPECT_EQ(compiledOn(whole(kCube), s)[0].compiled->isoCellsSkipped, 4u * (512 - 64));
}

TEST(Skipped, SecondariesOfLightsBehindSurfaces) {
  TestScene s = alongX();
  addPlane(s, 0);
  s.visualization.lighting.shadows = true;
  s.visualization.lighting.sources = {{LightType::Directional, {1, 0, 0}}};
  const TraceCounters front = Counted(s, halves()).all;
  EXPECT_EQ(front.raysShaded, uint64_t(kPixels * kPixels));
  EXPECT_EQ(front.secondariesSpawned, front.raysShaded);
  EXPECT_EQ(front.secondariesSkipped, 0u);
  s.visualization.lighting.sources.push_back({LightType::Directional, {-1, 0, 0}});
  const TraceCounters both = Counted(s, halves()).all;
  EXPECT_EQ(both.secondariesSpawned, both.raysShaded);
  EXPECT_EQ(both.secondariesSkipped, both.raysShaded);
}

TEST(Skipped, SecondariesAndThoseMadeAreAllThatHitsMayMake) {
  for (const TestScene& s : scenesOfEachKind()) {
    const Lighting& l = s.visualization.lighting;
    const auto perHit = uint64_t(l.aoCount) + (l.shadows ? l.sources.size() : 0);
    const TraceCounters c = Counted(s, lattice(s.domain, {2, 1, 1}, 2)).all;
    EXPECT_EQ(c.secondariesSpawned + c.secondariesSkipped, c.raysShaded * perHit) << s.name;
  }
}

TEST(Skipped, WhatIsBehindAnOpaqueSurface) {
  for (const double opacity : {1.0, 0.5}) {
    TestScene s = alongX();
    addPlane(s, 0, opacity);
    const TraceCounters c = Counted(s, whole(kCube)).all;
    EXPECT_EQ(c.raysEndedEarly, opacity == 1 ? uint64_t(kPixels * kPixels) : 0u);
  }
}

std::set<std::string> kernelsRunBy(const TestScene& s) {
  std::set<std::string> names;
  const TraceCounters c = Counted(s, lattice(s.domain, {2, 1, 1}, 2)).all;
  for (size_t k = 0; k < kKernels; k++)
    if (c.kernelRuns[k] > 0) names.insert(kKernelNames[k]);
  return names;
}

TEST(Skipped, KernelsOfWhatASceneDoesNotHave) {
  const std::map<std::string, std::set<std::string>> expected{
      {"smooth volume", {"integrate"}},
      {"isosurfaces", {"isosurfaces", "shade"}},
      {"slices", {"slices", "shade"}},
      {"particles", {"geometry", "shade"}},
      {"several volumes", {"integrate many"}},
      {"clip planes", {"geometry", "isosurfaces", "integrate", "shade"}}};
  size_t found = 0;
  for (const TestScene& s : scenesOfEachKind()) {
    const auto kernels = expected.find(s.name);
    if (kernels == expected.end()) continue;
    found++;
    EXPECT_EQ(kernelsRunBy(s), kernels->second) << s.name;
  }
  EXPECT_EQ(found, expected.size());
}

// The first picture is rank 1's, which is told only what changes a pixel.
TEST(Skipped, MessagesWithoutPixels) {
  TestScene s = alongX();
  addPlane(s, -0.5);
  Counted counted(s, halves());
  EXPECT_GE(counted.of(0).contributionMessages, uint64_t(kTiles));
  EXPECT_EQ(counted.of(0).messagesSkipped, uint64_t(kTiles)) << "of the tiles, when their rays were spawned";
  EXPECT_EQ(counted.of(1).contributionMessages, 0u);
  EXPECT_EQ(counted.of(1).messagesSkipped, 0u);
}

/// Keeps the whole pages of some memory from being read.
class Unreadable {
 public:
  explicit Unreadable(std::span<const std::byte> memory) {
    const auto page = uintptr_t(::sysconf(_SC_PAGESIZE)), at = uintptr_t(memory.data());
    begin_ = (at + page - 1) / page * page;
    size_ = (at + memory.size()) / page * page - begin_;
    protect(PROT_NONE);
  }
  ~Unreadable() { protect(PROT_READ | PROT_WRITE); }
  Unreadable(const Unreadable&) = delete;
  Unreadable& operator=(const Unreadable&) = delete;

 private:
  void protect(int how) const { EXPECT_EQ(::mprotect(reinterpret_cast<void*>(begin_), size_, how), 0); }
  uintptr_t begin_, size_;
};

// The ball brings the rays into the partition.
TEST(Skipped, SamplesOfATransparentMap) {
  for (const int volumes : {1, 2}) {
    SCOPED_TRACE(volumes);
    TestScene s = alongX();
    addRendered(s, volumes, {{-1, 0.1}, {1, 0.1}});
    addBall(s, {0.5, 0, 0}, 0.3);
    EXPECT_GT(Counted(s, whole(kCube)).all.samples, 0u);
    for (int k = 0; k < volumes; k++) s.visualization.operators[size_t(k)].opacitymap.points = {{-1, 0}};
    const auto compiled = compiledOn(whole(kCube), s);
    std::deque<Unreadable> samples;
    for (int k = 0; k < volumes; k++)
      samples.emplace_back(compiled[0].compiled->operators[size_t(k)].parts.at(0).block->samples);
    const TraceCounters c = Counted(s, whole(kCube), compiled).all;
    EXPECT_EQ(c.samples, 0u);
    EXPECT_EQ(c.macrocells + c.macrocellsSkipped, 0u);
    EXPECT_EQ(c.kernelRuns[size_t(Kernel::Integrate)] + c.kernelRuns[size_t(Kernel::IntegrateVolumes)], 0u);
    EXPECT_GT(c.raysShaded, 0u);
  }
}

// Those of one in which there is something see none of it.
TEST(Skipped, VolumesWithATransparentMapBesideOthers) {
  TestScene one = alongX();
  addRendered(one, 1, {{-1, 0.1}, {1, 0.1}});
  TestScene both = one;
  addRendered(both, 1, {{-1, 0}, {1, 0}});
  EXPECT_EQ(kernelsRunBy(both), std::set<std::string>{"integrate"});
  const Cut cut = halves();
  EXPECT_EQ(Counted(both, cut).all.samples, Counted(one, cut).all.samples);
  EXPECT_EQ(difference(render(one, cut), render(both, cut)), "");
}

// Two of the four that each ray meets in each volume.
TEST(Skipped, MacrocellsOfEachVolume) {
  for (const int volumes : {1, 2, 3}) {
    TestScene s = alongX();
    addRendered(s, volumes, {{0.05, 0}, {1, 0.1}});
    const TraceCounters c = Counted(s, whole(kCube)).all;
    EXPECT_EQ(c.macrocellsSkipped, uint64_t(2 * volumes * kPixels * kPixels));
    EXPECT_EQ(c.macrocells, uint64_t(2 * volumes * kPixels * kPixels));
  }
}

TEST(Skipped, RaysAndMessagesOfPartitionsWithNothingToSee) {
  TestScene s = alongX();
  Vis& vis = addField(s, 4, [](glm::dvec3 p) { return p.x; });
  vis.volumeRendering = true;
  vis.opacitymap = {false, {{-0.9, 0.1}, {-0.8, 0}}};  // in the first of four macrocells
  constexpr int kPictures = 4;                         // each rank owns one
  Counted counted(s, lattice(kCube, {4, 1, 1}, 4), kPictures);
  EXPECT_EQ(counted.all.raysSpawned, uint64_t(kPictures * kPixels * kPixels));
  EXPECT_GT(counted.all.samples, 0u);
  for (const int rank : {2, 3}) {
    const Renderer::Counters c = counted.of(rank);
    EXPECT_EQ(c.partitionsSkipped, uint64_t(kPictures));
    EXPECT_EQ(c.tilesSkipped, uint64_t(kPictures * kTiles));
    EXPECT_EQ(c.trace.raysSpawned + c.trace.raysTraced, 0u);
    EXPECT_EQ(c.rayMessages + c.contributionMessages, 0u);
  }
  EXPECT_EQ(counted.of(1).rayMessages, 0u) << "behind it there is nothing";
}

// A row of this picture is a block of the framebuffer.
TEST(Skipped, PixelsThatNothingIsAddedTo) {
  TestScene s = alongX();
  addBall(s, {0, 0, 0}, 0.3);
  const Picture picture = render(s, whole(kCube));
  uint64_t empty = 0;
  for (size_t row = 0; row < kPixels; row++) {
    bool seen = false;
    for (size_t i = kPixels * row; i < kPixels * (row + 1); i++)
      seen = seen || !std::equal(&picture.rgba[4 * i], &picture.rgba[4 * i + 4], picture.rgba.begin());
    empty += seen ? 0 : kPixels;
  }
  EXPECT_GT(empty, 0u);
  EXPECT_LT(empty, uint64_t(kPixels * kPixels));
  EXPECT_EQ(Counted(s, whole(kCube)).of(0).pixelsSkipped, empty);
}

// Ghost layers hold cells of the other half, and its macrocell, in which there is something.
TEST(Skipped, PartitionsThatHaveSomethingInTheirGhostsOnly) {
  const auto seen = [](double isovalue) {
    TestScene s = alongX();
    addPlane(s, isovalue);
    return compiledOn(halves(), s)[0].compiled->visible;
  };
  const double cell = 2.0 / 16;
  EXPECT_EQ(seen(1.5 * cell), (std::vector<uint8_t>{0, 1}));
  EXPECT_EQ(seen(-1.5 * cell), (std::vector<uint8_t>{1, 0}));
  EXPECT_EQ(seen(0.5 * cell), (std::vector<uint8_t>{1, 1})) << "in the cell next to it";
  TestScene s = alongX();
  Vis& vis = addField(s, 4, [](glm::dvec3 p) { return p.x; });
  vis.volumeRendering = true;
  vis.opacitymap = {false, {{-0.9, 0.1}, {-0.8, 0}}};  // in the first macrocell, of 8 cells
  const Cut third = octants(kCube, {kCube.lo.x + 10.5 * 2 / 32, 0, 0}, 2);
  const std::vector<uint8_t> visible = compiledOn(third, s)[0].compiled->visible;
  EXPECT_EQ(visible, (std::vector<uint8_t>{1, 0, 1, 0, 1, 0, 1, 0}));
}

TEST(Skipped, PlansOfIsovaluesOutsideTheRange) {
  TestScene s = alongX();
  addPlane(s, 7);
  const auto alone = compiledOn(halves(), s);
  for (const RankScene& rank : alone) {
    for (const auto& [p, part] : rank.compiled->operators[0].parts) EXPECT_TRUE(part.isoMask.empty());
    EXPECT_EQ(rank.compiled->visible, std::vector<uint8_t>(2, 0));
  }
  EXPECT_EQ(Counted(s, halves(), alone).all.raysSpawned, 0u);
  addBall(s, {0.5, 0, 0}, 0.3);
  TraceCounters c = Counted(s, halves()).all;
  EXPECT_GT(c.raysShaded, 0u);
  EXPECT_EQ(c.runs(Kernel::Isosurfaces), 0u);
  EXPECT_EQ(c.cells + c.isoMacrocellsSkipped, 0u);
}

// A plan that nobody would make shows where it comes from.
TEST(Skipped, PlansOfIsosurfacesThatAnotherSceneHas) {
  TestScene s = alongX();
  addPlane(s, 0.3);
  const auto before = std::make_shared<CompiledScene>(*compiledOn(whole(kCube), s)[0].compiled);
  std::vector<int32_t>& plan = before->operators[0].parts.at(0).isoMask;
  plan.back() ^= 1;
  const auto planOf = [&](const Visualization& visualization) {
    const std::shared_ptr<const CompiledScene> others[] = {before};
    const auto scene =
        compileScene(visualization, {before->operators[0].data}, before->partitioning, s.settings, others);
    return scene->operators[0].parts.at(0).isoMask;
  };
  Visualization edited = s.visualization;
  edited.operators[0].colormap = {{{0, {0, 1, 0}}}};
  EXPECT_EQ(planOf(edited), plan);
  edited.operators[0].isovalues = {0.31};
  EXPECT_NE(planOf(edited), plan);
}

TEST(Skipped, HierarchiesWithoutGeometry) {
  TestScene s = alongX();
  addPlane(s, 0).volumeRendering = true;
  treesMade = 0;
  compiledOn(halves(), s);
  EXPECT_EQ(treesMade, 0);
  addBall(s, {0, 0, 0}, 0.3);
  compiledOn(halves(), s);
  EXPECT_EQ(treesMade, 2) << "one in each half";
}

// SharedGeometry gives scenes the same primitives (scene_builder_test.cpp).
TEST(Skipped, HierarchiesOfPrimitivesThatAnotherSceneHas) {
  TestScene s = alongX();
  addBall(s, {0, 0, 0}, 0.3);
  const std::shared_ptr<const CompiledScene> first = compiledOn(whole(kCube), s)[0].compiled;
  const auto ballOf = [](const CompiledScene& scene) { return scene.operators[0].parts.at(0).geometry; };
  const auto edited = [&](bool sharesPrimitives, const std::function<void(Visualization&)>& edit) {
    Visualization visualization = first->visualization;
    edit(visualization);
    OperatorData data = first->operators[0].data;
    if (sharesPrimitives)
      data.primitives = std::make_shared<const CompiledGeometry>(CompiledGeometry{{0, ballOf(*first)}});
    return compileScene(visualization, {data}, first->partitioning, s.settings);
  };
  const auto lit = edited(true, [](Visualization& v) { v.lighting.Kd = 0.25; });
  const auto thick =
      edited(false, [](Visualization& v) { v.operators[0].radius0 = v.operators[0].radius1 = 0.4; });
  EXPECT_EQ(ballOf(*lit), ballOf(*first));
  EXPECT_NE(ballOf(*thick), ballOf(*first));
  EXPECT_GT(ballOf(*thick)->points[3], ballOf(*first)->points[3]);

  const auto backend = makeEmbreeBackend();
  Ledger ledger;
  SceneMemory memory;
  const auto hold = [&](const std::shared_ptr<const CompiledScene>& scene) {
    std::shared_ptr<const DeviceScene> device = backend->makeScene(scene, 0);
    auto entries =
        memory.enter(*scene, *device, [&](int64_t bytes) { return ledger.enter("ann", "scene", bytes); });
    return std::pair(device, std::move(entries));  // entries go first
  };
  treesMade = 0;
  auto one = hold(first);
  const int64_t ofOne = ledger.total(), shared = int64_t(ballOf(*first)->bytes());
  EXPECT_GT(ofOne, shared);
  {
    const auto two = hold(lit);
    EXPECT_EQ(treesMade, 1);
    EXPECT_LT(ledger.total(), 2 * ofOne - shared) << "what they share is entered once";
    const auto other = hold(thick);
    EXPECT_EQ(treesMade, 2);
    one = {};
    EXPECT_GT(ledger.total(), ofOne) << "of two with hierarchies";
  }
  EXPECT_EQ(ledger.total(), 0);
  hold(lit);
  EXPECT_EQ(treesMade, 3) << "nobody had it any more";
}

// The surface is 0.51 away from the other half, in which there is a ball, outside of the picture.
TEST(Skipped, WaysOfOcclusionRaysBehindTheirRadius) {
  TestScene s = alongX();
  addField(s, 4, [](glm::dvec3 p) { return p.x; }).isovalues = {0.51};
  s.visualization.lighting.aoCount = 4;
  const auto raysOf = [&](double radius) {
    s.visualization.lighting.aoRadius = radius;
    Counted counted(s, halves());
    EXPECT_EQ(counted.all.secondariesSpawned, uint64_t(4 * kPixels * kPixels)) << radius;
    return counted.of(1).raysForwarded;
  };
  EXPECT_EQ(raysOf(5), 0u) << "nothing is there";
  addBall(s, {-0.5, -0.96, -0.96}, 0.03);
  EXPECT_EQ(raysOf(0.5), 0u);
  EXPECT_GT(raysOf(5), 0u);
}

TEST(Skipped, RanksBehindAnOpaqueFront) {
  const auto isRankIdle = [](const TestScene& s) {
    Counted counted(s, halves());
    EXPECT_EQ(counted.of(0).trace.raysSpawned, uint64_t(kPixels * kPixels));
    const bool idle = counted.of(1).trace.raysTraced == 0;
    EXPECT_EQ(counted.of(0).rayMessages == 0, idle);
    EXPECT_EQ(counted.of(0).trace.raysEndedEarly, idle ? uint64_t(kPixels * kPixels) : 0u);
    return idle;
  };
  for (const double opacity : {0.5, 1.0}) {
    TestScene s = alongX();
    addPlane(s, -0.5, opacity).isovalues.push_back(0.5);
    EXPECT_EQ(isRankIdle(s), opacity == 1);
  }
  for (const double extinction : {1.0, 1000.0}) {
    TestScene s = alongX();
    Vis& vis = addField(s, 4, [](glm::dvec3 p) { return p.x; });
    vis.volumeRendering = true;
    vis.opacitymap = {true, {{-1, extinction}, {1, extinction}}};
    EXPECT_EQ(isRankIdle(s), extinction == 1000);
  }
}

/// The same scene, compiled, but for what `edit` makes of it.
std::vector<RankScene> editedOn(const std::vector<RankScene>& compiled,
                                const std::function<void(CompiledScene&)>& edit) {
  std::vector<RankScene> edited;
  for (size_t rank = 0; rank < compiled.size(); rank++) {
    const auto scene = std::make_shared<CompiledScene>(*compiled[rank].compiled);
    edit(*scene);
    edited.push_back({scene, testedBackend().makeScene(scene, int(rank))});
  }
  return edited;
}

// Where macrocells are skipped, segments begin anew at their faces; here they begin there anyway, eight in each.
TEST(SkippingOnAndOff, OfMacrocellsOfVolumesIsTheSamePicture) {
  for (const auto& [method, volumes] : {std::pair{Integrator::Midpoint, 1},
                                        {Integrator::ByCells, 1},
                                        {Integrator::Midpoint, 2},
                                        {Integrator::ByCells, 2}}) {
    TestScene s = alongX();
    addRendered(s, volumes, {{-0.9, 0.1}, {-0.6, 0.05}, {-0.55, 0}, {0.05, 0}, {0.6, 0.1}});
    const int32_t eighth = planOf(1, method);
    const auto planned = [&](bool skips) {
      return editedOn(compiledOn(whole(kCube), s), [&](CompiledScene& scene) {
        for (CompiledOperator& op : scene.operators)
          for (int32_t& plan : op.parts.at(0).plan)
            if (!skips || plan != 0) plan = eighth;
      });
    };
    const auto on = planned(true), off = planned(false);
    const auto skipped = [&](const std::vector<RankScene>& compiled) {
      return Counted(s, whole(kCube), compiled).all.macrocellsSkipped;
    };
    EXPECT_EQ(skipped(on), uint64_t(volumes * kPixels * kPixels));
    EXPECT_EQ(skipped(off), 0u);
    EXPECT_EQ(difference(render(s, 1, on), render(s, 1, off)), "") << volumes;
  }
}

TEST(SkippingOnAndOff, OfCellsOfIsosurfacesIsTheSamePicture) {
  TestScene s = alongX();
  addField(s, 4, [](glm::dvec3 p) { return glm::length(p); }).isovalues = {0.4, 0.7};
  s.visualization.lighting.aoCount = 2;
  const auto on = compiledOn(halves(), s);
  const auto off = editedOn(on, [](CompiledScene& scene) {
    for (auto& [p, part] : scene.operators[0].parts) {
      const Index3& n = part.block->macrocells;
      part.isoMask = everyCell(size_t(n[0] * n[1] * n[2]));
    }
  });
  const TraceCounters some = Counted(s, halves(), on).all, all = Counted(s, halves(), off).all;
  EXPECT_GT(some.isoMacrocellsSkipped, 0u);
  EXPECT_EQ(all.isoMacrocellsSkipped, 0u);
  EXPECT_LT(2 * some.cells, all.cells);
  EXPECT_EQ(difference(render(s, 2, on), render(s, 2, off)), "");
}

// The step is met in one of eight cells along each ray; in those before it there is nothing, behind it all is seen.
TEST(Skipped, SegmentsOfCellsInWhichTheMapShowsNothing) {
  TestScene s = alongX();
  addRendered(s, 1, {{-1, 0}, {0.27, 0}, {0.27, 0.1}, {1, 0.1}});
  const TraceCounters c = Counted(s, whole(kCube)).all;
  const auto rays = uint64_t(kPixels * kPixels);
  EXPECT_EQ(c.macrocellsSkipped, 2 * rays);
  EXPECT_GE(c.segmentsSkipped, 4 * rays);
  EXPECT_LT(c.segmentsSkipped, 8 * rays);
}

// A map that shows so little there that no picture changes skips none of them: 1e-30 of a float that is added to is nothing.
TEST(SkippingOnAndOff, OfSegmentsOfCellsIsTheSamePicture) {
  std::vector<int32_t> plan;
  const auto shownAs = [&](double nothing) {
    TestScene s = alongX();
    addRendered(s, 1, {{-1, nothing}, {0.27, nothing}, {0.27, 0.1}, {1, 0.1}});
    const auto scenes = editedOn(compiledOn(whole(kCube), s), [&](CompiledScene& scene) {
      std::vector<int32_t>& here = scene.operators[0].parts.at(0).plan;
      if (nothing == 0) {
        plan = here;
        for (int32_t& p : plan) p = p == 0 ? 0 : planOf(4, Integrator::ByCells);
      }
      here = plan;
    });
    return std::pair(render(s, 1, scenes), Counted(s, whole(kCube), scenes).all);
  };
  const auto [on, some] = shownAs(0);
  const auto [off, all] = shownAs(1e-30);
  EXPECT_GT(some.segmentsSkipped, 0u);
  EXPECT_EQ(all.segmentsSkipped, 0u);
  EXPECT_EQ(some.samples + some.segmentsSkipped, all.samples);
  EXPECT_EQ(difference(on, off), "");
}

// Which surface it is that keeps light away does not matter, where all are opaque.
TEST(SkippingOnAndOff, OfTheNearestHitsOfSecondariesIsTheSamePicture) {
  for (const bool clipped : {false, true}) {
    TestScene s = emptyScene("solids", affordable({96, 80}));
    addParticles(s, 1);
    addTubes(s, 1);
    addMesh(s, 1);
    if (clipped) addClipPlane(s);
    s.visualization.lighting.shadows = true;
    s.visualization.lighting.aoCount = 16;
    const auto any = compiledOn(whole(s.domain), s);
    const auto nearest = editedOn(any, [](CompiledScene& scene) { scene.opaqueSurfaces = false; });
    EXPECT_EQ(difference(render(s, 1, any), render(s, 1, nearest)), "") << clipped;
  }
}

// Partitions count as seen though nothing is in them. Scenes that have none such are left out.
TEST(SkippingOnAndOff, OfPartitionsIsTheSamePicture) {
  const std::set<std::string> known{"mesh", "particles", "second volume alone", "slices", "tubes"};
  std::set<std::string> skipping;
  for (TestScene& s : scenesOfEachKind()) {
    if (!onReference() && !allIsAsked() && !known.contains(s.name)) continue;
    s.camera.dimensions = affordable(s.camera.dimensions);
    const Cut cut = lattice(s.domain, {5, 4, 3}, 3);
    const auto on = compiledOn(cut, s);
    const std::vector<uint8_t>& visible = on[0].compiled->visible;
    if (std::count(visible.begin(), visible.end(), 0) == 0) continue;
    skipping.insert(s.name);
    const auto off =
        editedOn(on, [](CompiledScene& scene) { std::fill(scene.visible.begin(), scene.visible.end(), 1); });
    EXPECT_EQ(difference(render(s, cut.ranks, on), render(s, cut.ranks, off)), "") << s.name;
  }
  for (const std::string& name : known) EXPECT_TRUE(skipping.contains(name)) << name;
}

}  // namespace
}  // namespace gxy::test

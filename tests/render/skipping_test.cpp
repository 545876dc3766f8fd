// SPDX-License-Identifier: Apache-2.0
// What a scene does not need is not done, and is counted (docs/statistics.md).
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "support/frames.h"

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

// 17 points on each axis of a box: 16 cells, 2 macrocells.
Vis& addField(TestScene& s, const Box& box, const std::function<double(glm::dvec3)>& f) {
  const Grid grid{box.lo, (box.hi - box.lo) / 16.0, {17, 17, 17}};
  s.data.emplace_back(std::make_shared<const WholeVolume>(sampled(grid, f)));
  Vis& vis = s.visualization.operators.emplace_back();
  vis.type = VisType::Volume;
  vis.dataset = "field";
  vis.colormap = {{{-1, {1, 0, 0}}, {1, {0, 0, 1}}}};
  return vis;
}

Vis& addPlane(TestScene& s, double x, double opacity = 1) {
  Vis& vis = addField(s, kCube, [](glm::dvec3 p) { return p.x; });
  vis.isovalues = {x};
  vis.opacity = opacity;
  return vis;
}

Cut halves() { return lattice(kCube, {2, 1, 1}, 2); }

/// One frame of a scene, or several, and what each rank counted.
struct Counted {
  Counted(const TestScene& scene, const Cut& cut, int pictures = 1)
      : compiled(compiledOn(cut, scene)), frames(cut.ranks, {}) {
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

  std::vector<RankScene> compiled;
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

}  // namespace
}  // namespace gxy::test

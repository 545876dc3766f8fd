// SPDX-License-Identifier: Apache-2.0
// Partitions of one cell, and of less than a cell: every kind of Vis, the same bits as in one piece.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/backends.h"
#include "tests/support/frames.h"

namespace gxy::test {
namespace {

/// All kinds of Vis on a volume of n cells over the domain; with samples of cells, over the upper three quarters of it.
TestScene coarse(std::array<int, 3> n, bool ofCells = false) {
  TestScene scene = emptyScene("coarse", affordable({40, 36}));
  const Box d = scene.domain;
  Grid grid;
  grid.rim = ofCells;
  for (int a = 0; a < 3; a++) {
    const double lo = ofCells ? 0.75 * d.lo[a] + 0.25 * d.hi[a] : d.lo[a];
    grid.points[size_t(a)] = n[size_t(a)] + (ofCells ? 2 : 1);
    grid.spacing[a] = (d.hi[a] - lo) / n[size_t(a)];
    grid.origin[a] = ofCells ? lo - 0.5 * grid.spacing[a] : lo;
  }
  auto volume = std::make_shared<const WholeVolume>(
      sampled(grid, [](glm::dvec3 p) { return 0.5 + 0.4 * std::sin(2.3 * p.x + 1.7 * p.y - 3.1 * p.z); }));
  Vis vis;
  vis.volumeRendering = true;
  vis.opacitymap = {false, {{0, 0}, {0.4, 0.1}, {0.45, 0.8}, {0.5, 0}, {1, 0.3}}};
  vis.isovalues = {0.3, 0.65};
  vis.slices = {{{0.3, 1, 0.5}, 0.2}, {{1, 0, 0}, 0.1}};
  vis.opacity = 0.5;
  vis.dataset = "data";
  scene.visualization.operators.push_back(vis);
  scene.data.emplace_back(volume);
  addParticles(scene, 0.6);
  addTubes(scene, 0.7);
  addMesh(scene, 0.5);
  addLights(scene);
  addOcclusion(scene);
  return scene;
}

TEST(SmallPartitions, OneCellEach) {
  const TestScene scene = coarse({4, 3, 5});
  const Picture expected = wholeOnTested(scene);
  const int counts[] = {1, 5, 8};
  for (int ranks : counts) {
    if (!onReference() && !allIsAsked() && ranks != counts[seedOfTheCommit() % 3]) continue;
    EXPECT_EQ(difference(expected, render(scene, lattice(scene.domain, {4, 3, 5}, ranks)), Sameness::Bits),
              "")
        << ranks;
  }
}

TEST(SmallPartitions, LessThanACellEach) {
  const TestScene scene = coarse({1, 2, 1});
  const Picture expected = wholeOnTested(scene);
  EXPECT_EQ(difference(expected, render(scene, lattice(scene.domain, {3, 3, 3}, 4)), Sameness::Bits), "");
  EXPECT_EQ(difference(expected, render(scene, kdCut(scene.domain, 20, 6, 3)), Sameness::Bits), "");
}

TEST(SmallPartitions, OneCellEachOfALargerGridAlongOneAxis) {
  const TestScene scene = coarse({24, 2, 2});
  const Picture expected = wholeOnTested(scene);
  EXPECT_EQ(difference(expected, render(scene, lattice(scene.domain, {24, 1, 1}, 6)), Sameness::Bits), "");
}

TEST(SmallPartitions, SamplesOfCells) {
  const TestScene scene = coarse({4, 3, 5}, true);
  const Picture expected = wholeOnTested(scene);
  EXPECT_EQ(difference(expected, render(scene, lattice(scene.domain, {4, 3, 5}, 3)), Sameness::Bits), "");
  EXPECT_EQ(difference(expected, render(scene, kdCut(scene.domain, 20, 6, 3)), Sameness::Bits), "");
}

}  // namespace
}  // namespace gxy::test

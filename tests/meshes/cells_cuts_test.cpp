// SPDX-License-Identifier: Apache-2.0
// A mesh of any cells gives one picture, bit for bit, however it is cut into partitions and on however many ranks.
#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "tests/meshes/cells.h"
#include "tests/meshes/mesh_cuts.h"

namespace gxy::test {
namespace {

TestScene cutCells(Cells cells, double far, Vis vis = haze(2), int size = 24, uint32_t n = 6) {
  return cutScene(cubeOfCells(cells, n, far, waves), std::move(vis), size);
}

TEST(CellCuts, BentCells) {
  for (const Cells cells : kOtherCells) {
    expectSameBits(cutCells(cells, 0.25), arbitraryCuts(1), nameOf(cells));
    expectSameBits(cutCells(cells, 0.15, spikes()), arbitraryCuts(11), nameOf(cells) + ", spiky");
  }
}

TEST(CellCuts, RaysThroughPointsEdgesAndSides) {
  for (const Cells cells : kOtherCells) {
    TestScene scene = cutCells(cells, 0, haze(2), 25, 5);
    std::vector<Cut> cuts = arbitraryCuts(21);
    cuts.push_back(lattice(kDomain, {5, 5, 5}, 2));
    for (const glm::dvec3 towards : {glm::dvec3(0, 0, -1), glm::dvec3(1, 0, 0), glm::dvec3(1, 1, 0),
                                     glm::dvec3(1, 1, 1), glm::dvec3(3, 1, -2)}) {
      orthographic(scene, towards, 25.0 / 10);
      expectSameBits(scene, cuts, nameOf(cells) + " towards " + std::to_string(towards.x));
    }
  }
}

TEST(CellCuts, PartitionsSmallerThanACell) {
  for (const Cells cells : kOtherCells)
    expectSameBits(cutCells(cells, 0.2, haze(2), 24, 2),
                   {lattice(kDomain, {9, 9, 9}, 4), kdCut(kDomain, 64, 8, 6)}, nameOf(cells));
}

TEST(CellCuts, SurfacesShadowsAndOcclusion) {
  for (const Cells cells : kOtherCells) {
    TestScene scene = cutCells(cells, 0.2, surfacesInHaze(), 20);
    addLights(scene);
    addOcclusion(scene);
    expectSameBits(scene, arbitraryCuts(31), nameOf(cells));
  }
}

TEST(CellCuts, TheEyeInsideAndClipPlanes) {
  TestScene scene = cutCells(Cells::All, 0.2);
  scene.camera.viewpoint = {0.123, -0.31, 0.217};  // also a corner of partitions
  scene.camera.viewdirection = {-0.4, 0.5, -1};
  scene.camera.aov = 80;
  expectSameBits(scene, arbitraryCuts(41), "inside");
  scene = cutCells(Cells::Hexahedra, 0.2);
  scene.visualization.operators[0].clipPlanes = {{{1, 0.2, -0.3}, -0.2}, {{0, -1, 0}, -0.5}};
  expectSameBits(scene, arbitraryCuts(51), "clipped");
}

TEST(CellCuts, PointsWithoutData) {
  const auto none = [](glm::dvec3 p) { return glm::length(p - glm::dvec3(0.3, 0.2, 0.4)) < 0.5; };
  for (const Cells cells : kOtherCells)
    expectSameBits(cutScene(withGaps(cubeOfCells(cells, 6, 0.15, waves), none)), arbitraryCuts(61),
                   nameOf(cells));
}

}  // namespace
}  // namespace gxy::test

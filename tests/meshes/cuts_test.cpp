// SPDX-License-Identifier: Apache-2.0
// An unstructured volume gives one picture, bit for bit, however it is cut into partitions and on however many ranks.
#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "tests/meshes/mesh_cuts.h"

namespace gxy::test {
namespace {

TEST(MeshCuts, MovedCells) {
  expectSameBits(cutScene(cubeMesh(8, 0.17, waves)), arbitraryCuts(1), "smooth");
  expectSameBits(cutScene(cubeMesh(8, 0.17, waves), spikes()), arbitraryCuts(11), "spiky");
}

TEST(MeshCuts, PartitionsThatMeetAtPointsEdgesAndFacesOfCells) {
  const TestScene scene = cutScene(cubeMesh(8, 0, waves));
  expectSameBits(scene,
                 {lattice(kDomain, {8, 8, 8}, 2), lattice(kDomain, {2, 4, 8}, 3),
                  octants(kDomain, {0.25, 0.25, 0.25}, 4), octants(kDomain, {0.25, 0.3, 0.25}, 4),
                  octants(kDomain, {0.1, 0.1, 0.1}, 2)},
                 "on planes of points");
}

TEST(MeshCuts, RaysThroughPointsEdgesAndFaces) {
  TestScene scene = cutScene(cubeMesh(8, 0, waves), haze(2), 27);
  std::vector<Cut> cuts = arbitraryCuts(21);
  cuts.push_back(lattice(kDomain, {8, 8, 8}, 2));
  cuts.push_back(octants(kDomain, {0.25, 0.25, 0.25}, 4));
  for (const glm::dvec3 towards : {glm::dvec3(0, 0, -1), glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0),
                                   glm::dvec3(1, 1, 0), glm::dvec3(1, 1, 1), glm::dvec3(3, 1, -2)}) {
    orthographic(scene, towards, 27.0 / 8);
    expectSameBits(scene, cuts, "towards " + std::to_string(towards.x) + " " + std::to_string(towards.y));
  }
}

TEST(MeshCuts, PartitionsSmallerThanACell) {
  expectSameBits(cutScene(oneCell(), haze(2, 0, 1)),
                 {lattice(kDomain, {4, 4, 4}, 4), lattice(kDomain, {7, 5, 3}, 3), kdCut(kDomain, 60, 4, 5)},
                 "one cell");
  expectSameBits(cutScene(cubeMesh(2, 0.15, waves)),
                 {lattice(kDomain, {9, 9, 9}, 4), kdCut(kDomain, 64, 8, 6)}, "few cells");
}

TEST(MeshCuts, InvertedCells) {
  expectSameBits(cutScene(invertedHere(cubeMesh(8, 0.17, waves), 4)), arbitraryCuts(41), "inverted");
}

TEST(MeshCuts, ConcaveOutlinesHolesAndIslands) {
  expectSameBits(cutScene(nestedShells(10, waves)), arbitraryCuts(71), "shells");
  TestScene scene = cutScene(comb(9, waves));
  expectSameBits(scene, arbitraryCuts(81), "comb");
  orthographic(scene, {-1, 0, 0}, 2.2);
  expectSameBits(scene, arbitraryCuts(91), "comb across");
  expectSameBits(cutScene(withHoleAt(cubeMesh(5, 0.15, waves), {0.1, 0, 0.1})), arbitraryCuts(101), "hole");
}

TEST(MeshCuts, CellsOfAllSizes) {
  expectSameBits(cutScene(shrinking(8, waves)), arbitraryCuts(131), "shrinking");
}

TEST(MeshCuts, PointsWithoutDataAndHiddenValues) {
  const auto none = [](glm::dvec3 p) { return glm::length(p - glm::dvec3(0.3, 0.2, 0.4)) < 0.5; };
  expectSameBits(cutScene(withGaps(cubeMesh(8, 0.15, waves), none)), arbitraryCuts(141), "no data");
  expectSameBits(cutScene(cubeMesh(8, 0.15, [](glm::dvec3 p) { return glm::length(p); }),
                          rendered({{0.7, 0}, {0.71, 20}, {0.74, 20}, {0.75, 0}}, 0, 1, true)),
                 arbitraryCuts(151), "shell");
}

TEST(MeshCuts, TheEyeInsideAndClipPlanes) {
  TestScene scene = cutScene(cubeMesh(8, 0.15, waves));
  scene.camera.viewpoint = {0.123, -0.31, 0.217};  // also a corner of partitions
  scene.camera.viewdirection = {-0.4, 0.5, -1};
  scene.camera.aov = 80;
  expectSameBits(scene, arbitraryCuts(161), "inside");
  scene = cutScene(cubeMesh(8, 0.15, waves));
  scene.visualization.operators[0].clipPlanes = {{{1, 0.2, -0.3}, -0.2}, {{0, -1, 0}, -0.5}};
  expectSameBits(scene, arbitraryCuts(171), "clipped");
}

TEST(MeshCuts, SurfacesShadowsAndOcclusion) {
  TestScene scene = cutScene(cubeMesh(7, 0.15, waves));
  WholeGeometry balls;
  balls.block.points = {{-0.3, -0.2, 0.4}, {0.6, 0.5, 0.2}, {0.7, -0.6, 0.9}};
  balls.block.values = {-0.5f, 0.1f, 0.8f};
  balls.block.ids = {0, 1, 2};
  scene.data.emplace_back(std::make_shared<const WholeGeometry>(balls));
  Vis spheres = agreement::surfaces(VisType::Particles, -1, 1);
  spheres.dataset = "balls";
  spheres.radius0 = 0.3;
  spheres.opacity = 0.7;
  scene.visualization.operators.push_back(spheres);
  expectSameBits(scene, arbitraryCuts(181), "surfaces");
  addLights(scene);
  addOcclusion(scene);
  expectSameBits(scene, arbitraryCuts(191), "lit");
}

TEST(MeshCuts, OffsetsAndScales) {
  for (const auto& [factor, shift] : {std::pair(1e-30, glm::dvec3(0)), std::pair(1e30, glm::dvec3(0)),
                                      std::pair(1.0, glm::dvec3(1e6, -2e6, 3e6))}) {
    TestScene scene = cutScene(
        placed(cubeMesh(6, 0.15, waves), [f = factor, s = shift](glm::dvec3 p) { return f * p + s; }));
    scene.domain = {shift - factor, shift + factor};
    scene.camera.viewpoint = shift + factor * glm::dvec3(1.9, 1.4, 3.1);
    for (OpacityPoint& p : scene.visualization.operators[0].opacitymap.points) p.opacity /= factor;
    const Cut kd = kdCut(scene.domain, 12, 4, 7);
    expectSameBits(scene, {kd, lattice(scene.domain, {3, 3, 3}, 2)}, "scaled by " + std::to_string(factor));
  }
}

TEST(MeshCuts, PacketsAndSchedules) {
  const TestScene scene = cutScene(cubeMesh(6, 0.15, waves), haze(2), 12);
  const Picture expected = wholeOnEmbree(scene);
  const Cut cut = kdCut(kDomain, 12, 4, 3);
  const auto compiled = compiledOn(cut, scene);
  for (uint64_t seed = 1; seed <= 10; seed++) {
    FrameRun run;
    run.seed = seed;
    run.options.packetRays = 16;
    run.options.raysInFlight = seed % 2 ? 1 : 1 << 20;
    ASSERT_EQ(difference(expected, render(scene, cut.ranks, compiled, run), Sameness::Bits), "") << seed;
  }
}

}  // namespace
}  // namespace gxy::test

// SPDX-License-Identifier: Apache-2.0
// Isosurfaces and slices of an unstructured volume give one picture, bit for bit, however it is cut into partitions and on however many
// ranks.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "tests/meshes/cells.h"
#include "tests/meshes/mesh_cuts.h"

namespace gxy::test {
namespace {

/// Those of surfacesInHaze() without the haze: what a volume shows where cells overlap depends on the cuts.
Vis surfacesAlone() {
  Vis vis = surfacesInHaze();
  vis.volumeRendering = false;
  return vis;
}

TEST(MeshSurfaceCuts, MovedCells) {
  expectSameBits(cutScene(cubeMesh(8, 0.17, waves), surfacesIn({0.2, -0.3})), arbitraryCuts(1), "opaque");
  expectSameBits(
      cutScene(cubeMesh(8, 0.17, waves), surfacesIn({}, {{{1, 0.3, 0.2}, 0.1}, {{0, 0, -2}, 0.7}})),
      arbitraryCuts(11), "slices");
  expectSameBits(cutScene(cubeMesh(8, 0.17, waves), surfacesInHaze()), arbitraryCuts(21), "all");
}

TEST(MeshSurfaceCuts, PartitionsThatMeetAtPointsEdgesAndFacesOfCells) {
  const std::vector<Cut> cuts{lattice(kDomain, {8, 8, 8}, 2), lattice(kDomain, {2, 4, 8}, 3),
                              octants(kDomain, {0.25, 0.25, 0.25}, 4),
                              octants(kDomain, {0.25, 0.3, 0.25}, 4)};
  expectSameBits(cutScene(cubeMesh(8, 0, waves), surfacesInHaze()), cuts, "on planes of points");
  // the surfaces themselves lie in the borders of partitions
  const Vis borders =
      surfacesIn({0.25}, {{{1, 0, 0}, 0.25}, {{0, 1, 0}, 0.25}, {{0, 0, -1}, -0.25}, {{0, 1, 0}, 0.3}}, 0.5);
  expectSameBits(cutScene(cubeMesh(8, 0, waves), borders), cuts, "slices in borders");
  for (const auto axis : {0, 1, 2})
    expectSameBits(
        cutScene(cubeMesh(8, 0, [axis](glm::dvec3 p) { return p[axis]; }), surfacesIn({0.25}, {}, 0.5)), cuts,
        "an isosurface in borders");
}

TEST(MeshSurfaceCuts, RaysThroughPointsEdgesAndFaces) {
  const auto steps = [](glm::dvec3 p) { return std::round(4 * waves(p)) / 4; };
  TestScene scene = cutScene(cubeMesh(8, 0, steps),
                             surfacesIn({0.25, -0.25}, {{{1, 0, 0}, 0.25}, {{1, -1, 0}, 0}}, 0.5), 27);
  std::vector<Cut> cuts = arbitraryCuts(31);
  cuts.push_back(lattice(kDomain, {8, 8, 8}, 2));
  cuts.push_back(octants(kDomain, {0.25, 0.25, 0.25}, 4));
  for (const glm::dvec3 towards : {glm::dvec3(0, 0, -1), glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0),
                                   glm::dvec3(1, 1, 0), glm::dvec3(1, 1, 1), glm::dvec3(3, 1, -2)}) {
    orthographic(scene, towards, 27.0 / 8);
    expectSameBits(scene, cuts, "towards " + std::to_string(towards.x) + " " + std::to_string(towards.y));
  }
}

// Also where no ray meets the surface, and of cells of all kinds.
TEST(MeshSurfaceCuts, GradientsAtPointsHaveTheSameBits) {
  const Vis vis = surfacesIn({0.2});
  for (const MeshPiece& piece : {cubeMesh(6, 0.17, waves), cubeOfCells(Cells::All, 4, 0.15, waves)}) {
    const WholeMesh whole{piece};
    const Partitioning one = Partitioning::single(kDomain);
    const auto alone = cut(whole, one, 1);
    const PointGradients expected = *gradientsOf(alone, vis, one).at(0);
    const auto& points = alone.at(0)->blocks.at(0).points;
    for (const Cut& parts : arbitraryCuts(41)) {
      const auto meshes = cut(whole, parts.partitioning, parts.ranks);
      const auto gradients = gradientsOf(meshes, vis, parts.partitioning);
      size_t compared = 0;
      for (size_t r = 0; r < meshes.size(); r++)
        for (const auto& [partition, block] : meshes[r]->blocks)
          for (size_t p = 0; p < block.points.size(); p++, compared++) {
            const auto at = size_t(std::find(points.begin(), points.end(), block.points[p]) - points.begin());
            ASSERT_LT(at, points.size());
            for (size_t a = 0; a < 3; a++)
              ASSERT_EQ(gradients[r]->at(partition)[3 * p + a], expected.at(0)[3 * at + a])
                  << parts.name << ", partition " << partition << ", point " << p;
          }
      EXPECT_GT(compared, points.size());
    }
  }
}

TEST(MeshSurfaceCuts, PartitionsSmallerThanACell) {
  expectSameBits(cutScene(oneCell(), surfacesIn({0.2, 0.5}, {{{1, 0.5, 0.25}, -0.9}}, 0.5)),
                 {lattice(kDomain, {4, 4, 4}, 4), lattice(kDomain, {7, 5, 3}, 3), kdCut(kDomain, 60, 4, 5)},
                 "one cell");
  expectSameBits(cutScene(cubeMesh(2, 0.15, waves), surfacesInHaze()),
                 {lattice(kDomain, {9, 9, 9}, 4), kdCut(kDomain, 64, 8, 6)}, "few cells");
}

TEST(MeshSurfaceCuts, TangledCells) {
  for (const double far : {0.8, 1.5})
    expectSameBits(
        cutScene(placed(cubeMesh(10, far, waves), [](glm::dvec3 p) { return 0.8 * p; }), surfacesAlone()),
        arbitraryCuts(41), "tangled by " + std::to_string(far));
}

TEST(MeshSurfaceCuts, InvertedFlatAndCrowdedCells) {
  expectSameBits(cutScene(invertedHere(cubeMesh(8, 0.17, waves), 4), surfacesAlone()), arbitraryCuts(51),
                 "inverted");
  expectSameBits(cutScene(withFlatCells(cubeMesh(6, 0.15, waves), 60, 5), surfacesAlone()), arbitraryCuts(61),
                 "flat");
  expectSameBits(cutScene(together(cubeMesh(5, 0.15, waves),
                                   placed(cubeMesh(4, 0.15, waves), [](glm::dvec3 p) { return 0.7 * p; })),
                          surfacesAlone()),
                 arbitraryCuts(71), "one mesh in another");
}

TEST(MeshSurfaceCuts, SliversAndCellsOfAllSizes) {
  TestScene scene = cutScene(slivers(5, waves), surfacesAlone());
  expectSameBits(scene, arbitraryCuts(81), "slivers");
  orthographic(scene, {0, 0, -1}, 2.2);
  expectSameBits(scene, arbitraryCuts(91), "slivers, along them");
  expectSameBits(cutScene(shrinking(8, waves), surfacesAlone()), arbitraryCuts(101), "shrinking");
}

TEST(MeshSurfaceCuts, HolesAndPointsWithoutData) {
  expectSameBits(cutScene(nestedShells(10, waves), surfacesInHaze()), arbitraryCuts(111), "shells");
  const auto none = [](glm::dvec3 p) { return glm::length(p - glm::dvec3(0.3, 0.2, 0.4)) < 0.5; };
  expectSameBits(cutScene(withGaps(cubeMesh(8, 0.15, waves), none), surfacesInHaze()), arbitraryCuts(121),
                 "no data");
}

TEST(MeshSurfaceCuts, TheEyeInsideAndClipPlanes) {
  TestScene scene = cutScene(cubeMesh(8, 0.15, waves), surfacesInHaze());
  scene.camera.viewpoint = {0.123, -0.31, 0.217};  // also a corner of partitions
  scene.camera.viewdirection = {-0.4, 0.5, -1};
  scene.camera.aov = 80;
  expectSameBits(scene, arbitraryCuts(131), "inside");
  scene = cutScene(cubeMesh(8, 0.15, waves), surfacesInHaze());
  scene.visualization.operators[0].clipPlanes = {{{1, 0.2, -0.3}, -0.2}, {{0, -1, 0}, -0.5}};
  expectSameBits(scene, arbitraryCuts(141), "clipped");
}

TEST(MeshSurfaceCuts, ShadowsOcclusionAndParticles) {
  for (const double opacity : {1.0, 0.6}) {
    TestScene scene = cutScene(cubeMesh(7, 0.15, waves), surfacesIn({0.2}, {{{0, 1, 0}, -0.7}}, opacity));
    WholeGeometry balls;
    balls.block.points = {{-0.3, -0.2, 0.4}, {0.6, 0.5, 0.2}, {0.7, -0.6, 0.9}};
    balls.block.values = {-0.5f, 0.1f, 0.8f};
    balls.block.ids = {0, 1, 2};
    scene.data.emplace_back(std::make_shared<const WholeGeometry>(balls));
    Vis spheres = agreement::surfaces(VisType::Particles, -1, 1);
    spheres.dataset = "balls";
    spheres.radius0 = 0.3;
    spheres.opacity = opacity;
    scene.visualization.operators.push_back(spheres);
    addLights(scene);
    addOcclusion(scene);
    expectSameBits(scene, arbitraryCuts(151), "lit");
  }
}

TEST(MeshSurfaceCuts, OffsetsAndScales) {
  for (const auto& [factor, shift] : {std::pair(1e-30, glm::dvec3(0)), std::pair(1e30, glm::dvec3(0)),
                                      std::pair(1.0, glm::dvec3(1e6, -2e6, 3e6))}) {
    Plane plane{{1, 0.3, 0.2}, 0};
    plane.offset = 0.1 * factor + glm::dot(plane.normal, shift);
    TestScene scene = cutScene(
        placed(cubeMesh(6, 0.15, waves), [f = factor, s = shift](glm::dvec3 p) { return f * p + s; }),
        surfacesIn({0.2, -0.3}, {plane}, 0.5));
    scene.domain = {shift - factor, shift + factor};
    scene.camera.viewpoint = shift + factor * glm::dvec3(1.9, 1.4, 3.1);
    const Cut kd = kdCut(scene.domain, 12, 4, 7);
    expectSameBits(scene, {kd, lattice(scene.domain, {3, 3, 3}, 2)}, "scaled by " + std::to_string(factor));
  }
}

TEST(MeshSurfaceCuts, PacketsAndSchedules) {
  const TestScene scene = cutScene(cubeMesh(6, 0.15, waves), surfacesInHaze(), 12);
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

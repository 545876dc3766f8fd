// SPDX-License-Identifier: Apache-2.0
// Scenes of one unstructured volume that is cut into partitions, and their pictures.
#pragma once
#include <gtest/gtest.h>

#include "tests/meshes/mesh_scenes.h"
#include "tests/support/frames.h"

namespace gxy::test {

inline const Box kDomain{glm::dvec3(-1), glm::dvec3(1)};

/// A scene whose only operator is a mesh in kDomain, seen from outside.
inline TestScene cutScene(MeshPiece piece, Vis vis = haze(2), int size = 24) {
  TestScene scene = emptyScene("cut mesh", {size, size});
  scene.domain = kDomain;
  vis.dataset = "data";
  scene.visualization.operators = {std::move(vis)};
  scene.data = {std::make_shared<const WholeMesh>(WholeMesh{std::move(piece)})};
  scene.camera = cameraOutside(kDomain, {size, size});
  return scene;
}

/// Looks at the origin with parallel rays.
inline void orthographic(TestScene& scene, glm::dvec3 towards, double height) {
  scene.camera.viewpoint = -4.0 * towards;
  scene.camera.viewdirection = towards;
  scene.camera.viewup = towards.x == 0 && towards.z == 0 ? glm::dvec3(0, 0, 1) : glm::dvec3(0, 1, 0);
  scene.camera.aov = 0;
  scene.camera.height = height;
}

/// In 2 to 64 partitions on 1 to 8 ranks, at places that have nothing to do with the cells.
inline std::vector<Cut> arbitraryCuts(uint64_t seed) {
  std::vector<Cut> cuts;
  cuts.push_back(kdCut(kDomain, 2, 1, seed));
  cuts.push_back(kdCut(kDomain, 3, 2, seed + 1));
  cuts.push_back(kdCut(kDomain, 7, 4, seed + 2));
  cuts.push_back(kdCut(kDomain, 20, 8, seed + 3));
  cuts.push_back(kdCut(kDomain, 64, 4, seed + 4));
  cuts.push_back(lattice(kDomain, {4, 4, 4}, 2));
  cuts.push_back(octants(kDomain, {0.123, -0.31, 0.217}, 4));
  return cuts;
}

/// Expects something to be seen, and the bits of the picture of one partition on all cuts.
inline void expectSameBits(const TestScene& scene, const std::vector<Cut>& cuts, const std::string& what) {
  const Picture expected = wholeOnEmbree(scene);
  size_t seen = 0;
  for (size_t i = 0; i < expected.rgba.size(); i += 4)
    seen += expected.rgba[i] != expected.rgba[0] || expected.rgba[i + 2] != expected.rgba[2];
  EXPECT_GT(seen, expected.rgba.size() / 100) << what << ": nothing to see";
  for (const Cut& cut : cuts)
    EXPECT_EQ(difference(expected, render(scene, cut), Sameness::Bits), "") << what << ", " << cut.name;
}

}  // namespace gxy::test

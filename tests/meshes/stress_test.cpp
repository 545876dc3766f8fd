// SPDX-License-Identifier: Apache-2.0
// Unstructured volumes of hard shapes: backend against reference.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "tests/meshes/mesh_scenes.h"

namespace gxy::test {
namespace {

using agreement::embree;
using agreement::TestScene;

/// Through a smooth map and a spiky one.
void expectBoth(const std::string& name, const MeshPiece& piece, int size = 36) {
  expectAgreement(embree(), meshScene(name + "_smooth", haze(2), piece, size), kFirstAlone);
  expectAgreement(embree(), meshScene(name + "_spiky", spikes(), piece, size), kFirstAlone, -1, 20);
}

TEST(MeshStress, AMeshOfOneCell) {
  for (const Vis& vis : {haze(2, 0, 1), rendered({{0.2, 0}, {0.2, 3}, {0.5, 3}, {0.5, 0}}, 0, 1, true)})
    expectAgreement(embree(), meshScene("mesh_one_cell", vis, oneCell()));
}

TEST(MeshStress, InvertedCells) { expectBoth("mesh_inverted", invertedHere(cubeMesh(8, 0.15, waves), 3)); }

TEST(MeshStress, CellsWithoutVolume) {
  expectBoth("mesh_flat_cells", withFlatCells(cubeMesh(8, 0.15, waves), 60, 5));
}

TEST(MeshStress, PointsWithoutData) {
  const auto none = [](glm::dvec3 p) {
    return glm::length(p - glm::dvec3(0.3, 0.2, 0.4)) < 0.4 || p.x < -0.8;
  };
  expectBoth("mesh_no_data", withGaps(cubeMesh(10, 0.15, waves), none));
  TestScene nothing = meshScene("mesh_no_data_at_all", haze(),
                                withGaps(cubeMesh(3, 0.15, waves), [](glm::dvec3) { return true; }), 16);
  expectAgreement(embree(), nothing, kFirstAlone, 0, 0);
}

TEST(MeshStress, Islands) {
  MeshPiece piece = placed(cubeMesh(3, 0.15, waves), [](glm::dvec3 p) { return 0.3 * p - 0.6; });
  for (const glm::dvec3 at :
       {glm::dvec3(0.5, -0.4, 0.2), glm::dvec3(0, 0.6, 0.3), glm::dvec3(0.6, 0.6, -0.6)})
    piece = together(std::move(piece),
                     placed(cubeMesh(3, 0.15, waves, 7), [&](glm::dvec3 p) { return 0.25 * p + at; }));
  expectBoth("mesh_islands", piece);
  // two that touch at a point, at an edge, at a face that is cut in another way
  for (const glm::dvec3 at : {glm::dvec3(1, 1, 1), glm::dvec3(1, 1, 0), glm::dvec3(1, 0.25, 0)}) {
    const MeshPiece one = placed(cubeMesh(3, 0, waves), [](glm::dvec3 p) { return 0.5 * p - 0.25; });
    const MeshPiece other = placed(cubeMesh(4, 0, waves), [&](glm::dvec3 p) { return 0.5 * p - 0.25 + at; });
    expectBoth("mesh_touching", together(one, other), 28);
  }
}

TEST(MeshStress, AHoleOfOneCell) {
  expectBoth("mesh_hole",
             withHoleAt(withHoleAt(cubeMesh(6, 0.15, waves), {0.1, 0.2, 0.1}), {-0.5, 0.4, 0.5}));
}

TEST(MeshStress, ACombSeenEndOn) {
  TestScene scene = meshScene("mesh_comb", haze(2), comb(15, waves), 32);
  scene.camera.viewpoint = {4, 0.13, 0.21};
  scene.camera.viewdirection = {-1, 0.02, 0.01};
  expectAgreement(embree(), scene, kFirstAlone);
  scene.camera.viewpoint = {4, 0.1, 0.2};  // exactly across
  scene.camera.viewdirection = {-1, 0, 0};
  scene.camera.aov = 0;
  scene.camera.height = 2.2;
  expectAgreement(embree(), scene, kFirstAlone);
}

TEST(MeshStress, NestedShells) { expectBoth("mesh_shells", nestedShells(14, waves)); }

TEST(MeshStress, Slivers) {
  expectBoth("mesh_slivers", slivers(5, waves));
  // from end to end in one of them
  TestScene scene = meshScene("mesh_sliver_end_on", haze(2), slivers(5, waves), 32);
  scene.camera.viewpoint = {4, -0.2 + 1e-7, 0.3};
  scene.camera.viewdirection = {-1, 0, 0};
  expectAgreement(embree(), scene, kFirstAlone);
}

TEST(MeshStress, NeedlesOfAllDirections) {
  const MeshPiece piece = placed(cubeMesh(6, 0.15, waves),
                                 [](glm::dvec3 p) { return glm::dvec3(p.x, 1e-4 * p.y + 0.2 * p.x, p.z); });
  expectAgreement(embree(), meshScene("mesh_needles", haze(1e4), piece), kFirstAlone);
}

TEST(MeshStress, CellsAMillionTimesSmallerThanOthers) {
  const MeshPiece piece = shrinking(8, waves);
  expectBoth("mesh_shrinking", piece);
  TestScene near = meshScene("mesh_shrinking_near", rendered({{-1, 0}, {1, 2e6}}, -1, 1, true), piece, 32);
  near.camera.viewpoint = glm::dvec3(-1) - 4e-5 * glm::dvec3(2.1, 1.4, 3.3);
  near.camera.viewdirection = glm::dvec3(2.1, 1.4, 3.3);
  expectAgreement(embree(), near, kFirstAlone);
}

TEST(MeshStress, AnyScaleAndPlace) {
  for (const double factor : {1e-30, 1e30})
    expectAgreement(embree(),
                    agreement::moved(meshScene("mesh_scaled", haze(2), cubeMesh(6, 0.15, waves), 32), factor,
                                     glm::dvec3(0)),
                    kFirstAlone);
  expectAgreement(
      embree(),
      agreement::moved(meshScene("mesh_moved", haze(2), cubeMesh(6, 0.15, waves), 32), 1, {1e6, -2e6, 3e6}),
      kFirstAlone);
}

TEST(MeshStress, TheEyeFarAwayAndWide) {
  TestScene far = meshScene("mesh_far", haze(2), cubeMesh(6, 0.15, waves), 32);
  far.camera.viewpoint *= 1e5;
  far.camera.aov = 0.0004;
  expectAgreement(embree(), far, kFirstAlone);
  TestScene wide = meshScene("mesh_wide", haze(2), cubeMesh(6, 0.15, waves), 32);
  wide.camera.viewpoint = {0.1, 0.2, 1.05};
  wide.camera.aov = 179;
  expectAgreement(embree(), wide, kFirstAlone);
}

TEST(MeshStress, ConstantFields) {
  const auto flat = [](glm::dvec3 p) { return p.x < 0.1 ? 0.3 : 0.7; };
  for (const Vis& vis :
       {haze(2, 0, 1), rendered({{0, 0}, {0.25, 0}, {0.25, 3}, {0.75, 3}, {0.75, 1}}, 0, 1, true)})
    expectAgreement(embree(), meshScene("mesh_constant", vis, cubeMesh(6, 0.15, flat), 32), kFirstAlone);
}

TEST(MeshStress, ValuesOfAnySize) {
  for (const double size : {1e-20, 1e20}) {
    const Vis vis = rendered({{-size, 0}, {size, 2}}, -size, size, true);
    expectAgreement(
        embree(),
        meshScene("mesh_values", vis, cubeMesh(6, 0.15, [&](glm::dvec3 p) { return size * waves(p); }), 32),
        kFirstAlone);
  }
}

// Cells that overlap have no picture to agree with; but that of each pixel is one.
TEST(MeshStress, TangledMeshesHavePictures) {
  for (const double far : {0.8, 1.5}) {
    TestScene scene = meshScene("mesh_tangled", haze(2), cubeMesh(12, far, waves), 40);
    const Picture picture = agreement::draw(embree(), scene);
    for (const float x : picture.rgba) {
      EXPECT_GE(x, -1e-6f);
      EXPECT_LE(x, 1 + 1e-6f);
    }
  }
}

}  // namespace
}  // namespace gxy::test

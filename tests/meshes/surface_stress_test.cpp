// SPDX-License-Identifier: Apache-2.0
// Isosurfaces and slices of unstructured volumes of hard shapes: backend against reference.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "tests/meshes/mesh_scenes.h"

namespace gxy::test {
namespace {

using agreement::embree;
using agreement::TestScene;

const std::vector<Plane> kTwoPlanes{{{1, 0.3, 0.2}, 0.1}, {{0.1, -1, 0.3}, 0.2}};

/// Opaque isosurfaces, and translucent ones with slices.
void expectSurfaces(const std::string& name, const MeshPiece& piece, int seen = 20) {
  constexpr int size = 32;
  expectAgreement(embree(), meshScene(name + "_opaque", surfacesIn({0.2, -0.3}), piece, size), kFirstAlone,
                  -1, seen);
  expectAgreement(embree(), meshScene(name, surfacesIn({0.2, -0.3}, kTwoPlanes, 0.5), piece, size),
                  kFirstAlone, -1, seen);
}

/// Without slices that are seen edge-on, from the directions of rays that run through points, along edges and in faces of cells. The normal and the way of a ray between two
/// cells are a matter of rounding, so more of them are flips.
void expectAcross(const std::string& name, const Vis& vis, const MeshPiece& piece, int seen = 40) {
  for (const glm::dvec3 towards : {glm::dvec3(0, 0, -1), glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0),
                                   glm::dvec3(1, 1, 0), glm::dvec3(1, 1, 1), glm::dvec3(3, 1, -2)}) {
    TestScene scene = meshScene(name, vis, piece, 27);
    std::erase_if(scene.visualization.operators[0].slices,
                  [&](const Plane& plane) { return glm::dot(plane.normal, towards) == 0; });
    scene.camera.viewpoint = -4.0 * towards;
    scene.camera.viewdirection = towards;
    if (towards.x == 0 && towards.z == 0) scene.camera.viewup = {0, 0, 1};
    scene.camera.aov = 0;
    scene.camera.height = 27.0 / 8;
    expectAgreement(embree(), scene, kFirstAlone, 27, seen);
  }
}

TEST(MeshSurfaceStress, RaysThroughPointsEdgesAndFaces) {
  expectAcross("mesh_iso_ties", surfacesIn({0.2, -0.3}, {}, 0.5), cubeMesh(8, 0, waves));
}

// Values in steps of a quarter, so the isovalue is that of many points, and there are plateaus at it.
TEST(MeshSurfaceStress, IsovaluesOfVerticesAndPlateaus) {
  const auto steps = [](glm::dvec3 p) { return std::round(4 * waves(p)) / 4; };
  const Vis vis = surfacesIn({0.25, -0.25}, {}, 0.5);
  expectAgreement(embree(), meshScene("mesh_iso_steps", vis, cubeMesh(10, 0.15, steps)));
  expectAcross("mesh_iso_steps_across", vis, cubeMesh(8, 0, steps));
  const auto valley = [](glm::dvec3 p) { return std::abs(p.x) - 0.25; };
  expectAcross("mesh_iso_valley", surfacesIn({-0.25}, {}, 0.5), cubeMesh(8, 0, valley), 0);
}

TEST(MeshSurfaceStress, SlicesThroughVerticesAndAlongFaces) {
  const std::vector<Plane> through{
      {{1, 0, 0}, 0.25}, {{0, -2, 0}, 1}, {{1, -1, 0}, 0}, {{1, 1, 1}, 0.25}, {{0, 1, -1}, 0.5}};
  for (const Plane& plane : through)
    expectAgreement(embree(),
                    meshScene("mesh_slice_through", surfacesIn({}, {plane}), cubeMesh(8, 0, waves), 32),
                    kFirstAlone);
  expectAcross("mesh_slices_across", surfacesIn({}, {through[0], through[2], through[3]}, 0.5),
               cubeMesh(8, 0, waves));
}

TEST(MeshSurfaceStress, OneCell) {
  const Plane plane{{1, 0.5, 0.25}, -0.9};
  expectAgreement(embree(),
                  meshScene("mesh_iso_one_cell", surfacesIn({0.2, 0.5}, {plane}, 0.5), oneCell(), 32));
  expectAgreement(embree(), meshScene("mesh_iso_of_its_points", surfacesIn({0, 1}), oneCell(), 32),
                  kFirstAlone, 0, 0);
}

TEST(MeshSurfaceStress, InvertedAndFlatCells) {
  expectSurfaces("mesh_iso_inverted", invertedHere(cubeMesh(8, 0.15, waves), 3));
  expectSurfaces("mesh_iso_flat_cells", withFlatCells(cubeMesh(8, 0.15, waves), 60, 5));
}

TEST(MeshSurfaceStress, PointsWithoutData) {
  expectSurfaces("mesh_iso_no_data", withGaps(cubeMesh(10, 0.15, waves), [](glm::dvec3 p) {
                   return glm::length(p - glm::dvec3(0.3, 0.2, 0.4)) < 0.4 || p.x < -0.8;
                 }));
}

TEST(MeshSurfaceStress, HolesIslandsAndShells) {
  expectSurfaces("mesh_iso_hole",
                 withHoleAt(withHoleAt(cubeMesh(6, 0.15, waves), {0.1, 0.2, 0.1}), {-0.5, 0.4, 0.5}));
  expectSurfaces("mesh_iso_shells", nestedShells(12, waves));
  const MeshPiece one = placed(cubeMesh(3, 0, waves), [](glm::dvec3 p) { return 0.5 * p - 0.25; });
  expectSurfaces("mesh_iso_touching", together(one, placed(cubeMesh(4, 0, waves), [](glm::dvec3 p) {
                                                 return 0.5 * p - 0.25 + glm::dvec3(1, 0.25, 0);
                                               })));
}

TEST(MeshSurfaceStress, Slivers) {
  expectSurfaces("mesh_iso_slivers", slivers(5, waves));
  // in the middle of the thin layer
  expectAgreement(
      embree(),
      meshScene("mesh_slice_slivers", surfacesIn({}, {{{0, 0, 1}, -0.2 + 2e-7}}), slivers(5, waves), 32),
      kFirstAlone);
}

TEST(MeshSurfaceStress, NeedlesAndCellsOfAllSizes) {
  expectSurfaces("mesh_iso_needles",
                 placed(cubeMesh(6, 0.15, waves),
                        [](glm::dvec3 p) { return glm::dvec3(p.x, 1e-4 * p.y + 0.7 * p.x, p.z); }),
                 8);
  expectSurfaces("mesh_iso_shrinking", shrinking(8, waves));
}

TEST(MeshSurfaceStress, AnyScaleAndPlace) {
  const TestScene still =
      meshScene("mesh_iso_moved", surfacesIn({0.2, -0.3}, kTwoPlanes, 0.5), cubeMesh(6, 0.15, waves), 32);
  for (const double factor : {1e-30, 1e30})
    expectAgreement(embree(), agreement::moved(still, factor, glm::dvec3(0)), kFirstAlone);
  expectAgreement(embree(), agreement::moved(still, 1, {1e6, -2e6, 3e6}), kFirstAlone);
}

TEST(MeshSurfaceStress, ValuesOfAnySize) {
  for (const double size : {1e-20, 1e20}) {
    Vis vis = surfacesIn({0.2 * size, -0.3 * size}, kTwoPlanes, 0.5);
    vis.colormap.points = {{-size, {0.1, 0.2, 0.9}}, {size, {0.9, 0.1, 0.1}}};
    expectAgreement(embree(),
                    meshScene("mesh_iso_values", vis,
                              cubeMesh(6, 0.15, [&](glm::dvec3 p) { return size * waves(p); }), 32),
                    kFirstAlone);
  }
}

TEST(MeshSurfaceStress, TheEyeFarAwayAndWide) {
  TestScene far =
      meshScene("mesh_iso_far", surfacesIn({0.2, -0.3}, kTwoPlanes, 0.5), cubeMesh(6, 0.15, waves), 32);
  far.camera.viewpoint *= 1e5;
  far.camera.aov = 0.0004;
  expectAgreement(embree(), far, kFirstAlone);
  TestScene wide =
      meshScene("mesh_iso_wide", surfacesIn({0.2}, kTwoPlanes, 0.5), cubeMesh(6, 0.15, waves), 32);
  wide.camera.viewpoint = {0.1, 0.2, 1.05};
  wide.camera.aov = 170;
  expectAgreement(embree(), wide, kFirstAlone);
}

// Every ray that starts outside leaves what is above the isovalue as often as it enters it: alpha has one of these values.
TEST(MeshSurfaceStress, ClosedSurfacesHaveEvenlyManySheets) {
  const auto inside = [](glm::dvec3 p) {
    return std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) == 1 ? -1 : std::round(2 * waves(p)) / 2;
  };
  for (const double far : {0.0, 0.15}) {
    TestScene scene = meshScene("mesh_iso_closed", surfacesIn({0}, {}, 0.5), cubeMesh(8, far, inside), 54);
    scene.settings.background = glm::dvec4(0);
    for (const glm::dvec3 towards : {glm::dvec3(0, 0, -1), glm::dvec3(1, 1, 1), glm::dvec3(3, 1, -2)}) {
      scene.camera.viewpoint = -4.0 * towards;
      scene.camera.viewdirection = towards;
      scene.camera.aov = 0;
      scene.camera.height = 27.0 / 8;
      const Picture picture = agreement::draw(embree(), scene);
      int through = 0;
      for (size_t i = 3; i < picture.rgba.size(); i += 4) {
        const double sheets = -std::log2(1 - double(picture.rgba[i]));
        if (sheets > 9) continue;  // the ray may end before it has met all
        EXPECT_NEAR(std::remainder(sheets, 2), 0, 0.01) << "pixel " << i / 4 << ": " << sheets;
        through += sheets > 1;
      }
      EXPECT_GT(through, 200);
    }
  }
}

TEST(MeshSurfaceStress, TangledMeshesHavePictures) {
  for (const double far : {0.8, 1.5}) {
    const Picture picture =
        agreement::draw(embree(), meshScene("mesh_iso_tangled", surfacesInHaze(), cubeMesh(12, far, waves)));
    for (const float x : picture.rgba) {
      EXPECT_GE(x, -1e-6f);
      EXPECT_LE(x, 1 + 1e-6f);
    }
  }
}

}  // namespace
}  // namespace gxy::test

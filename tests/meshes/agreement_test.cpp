// SPDX-License-Identifier: Apache-2.0
// Unstructured volumes: backend against reference.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "core/comm/error.h"
#include "tests/agreement/draw.h"
#include "tests/meshes/mesh_scenes.h"

namespace gxy::test {
namespace {

using agreement::drawnByBoth;
using agreement::embree;
using agreement::TestScene;

TestScene wavyScene(const std::string& name, Vis vis, int size = 40) {
  return meshScene(name, std::move(vis), cubeMesh(10, 0.15, waves), size);
}

TEST(MeshAgreement, SmoothMap) { expectAgreement(embree(), wavyScene("mesh_smooth", haze())); }

TEST(MeshAgreement, SpikyMap) { expectAgreement(embree(), wavyScene("mesh_spiky", spikes())); }

TEST(MeshAgreement, SteppedMap) {
  expectAgreement(
      embree(),
      wavyScene("mesh_stepped",
                rendered({{-0.2, 0}, {-0.2, 2}, {0.1, 2}, {0.1, 0.1}, {0.4, 0.1}, {0.4, 6}}, -1, 1, true)));
}

TEST(MeshAgreement, OpaqueSteps) {
  expectAgreement(embree(), wavyScene("mesh_opaque", rendered({{0.3, 0}, {0.3, 1}, {0.6, 1}}, -1, 1)),
                  kFirstAlone);
}

TEST(MeshAgreement, OpacitiesOfTypicalLengths) {
  expectAgreement(embree(), wavyScene("mesh_opacities", rendered({{-1, 0}, {1, 0.6}}, -1, 1)), kFirstAlone);
  expectAgreement(embree(), wavyScene("mesh_nearly_opaque", rendered({{-1, 0.9}, {1, 0.999}}, -1, 1)),
                  kFirstAlone);
  expectAgreement(embree(), wavyScene("mesh_nearly_transparent", rendered({{-1, 0.001}, {1, 0.01}}, -1, 1)),
                  kFirstAlone);
}

TEST(MeshAgreement, ReferenceLengthAndDataRange) {
  Vis vis = rendered({{0, 0}, {1, 0.5}}, 0, 1);
  vis.referenceLength = 0.3;
  vis.dataRange = {{-0.7, 0.9}};
  expectAgreement(embree(), wavyScene("mesh_reference_length", vis), kFirstAlone);
}

TEST(MeshAgreement, AnyTolerance) {
  for (const double tolerance : {1.0 / 64, 1.0 / 4096, 1.0 / 16384}) {
    for (const Vis& vis : {haze(), spikes()}) {
      TestScene scene = wavyScene("mesh_tolerance", vis, 32);
      scene.settings.tolerance = tolerance;
      agreement::CompareOptions options = kFirstAlone;
      options.tolerance = tolerance;
      expectAgreement(embree(), scene, options);
    }
  }
}

// By Beer and Lambert's law, whatever the cells are.
TEST(MeshAgreement, UniformSlab) {
  for (const double sigma : {1e-3, 0.1, 3.0, 20.0}) {
    TestScene scene = meshScene("mesh_slab", rendered({{0, sigma}, {1, sigma}}, 0, 1, true),
                                cubeMesh(6, 0.17, [](glm::dvec3) { return 0.5; }), 32);
    scene.camera.viewpoint = {0.01, 0.02, 4};
    scene.camera.viewdirection = {0, 0, -1};
    scene.camera.aov = 0;
    scene.camera.height = 1.9;
    scene.settings.background = glm::dvec4(0);
    const Picture picture = agreement::draw(embree(), scene);
    const double expected = -std::expm1(-2 * sigma), bound = std::max(1e-6, 1e-4 * expected);
    for (size_t i = 3; i < picture.rgba.size(); i += 4)
      ASSERT_NEAR(picture.rgba[i], expected, bound) << sigma;
  }
}

TEST(MeshAgreement, ClipPlanes) {
  Vis vis = haze(3);
  vis.clipPlanes = {{{1, 0.2, -0.3}, -0.2}, {{0, -1, 0}, -0.5}};
  expectAgreement(embree(), wavyScene("mesh_clipped", vis));
  vis.clipPlanes = {{{0, 0, -2}, 0.5}};  // a plane of points of a mesh that is not moved
  expectAgreement(embree(), meshScene("mesh_clipped_at_points", vis, cubeMesh(8, 0, waves)), kFirstAlone);
}

TEST(MeshAgreement, TheEyeInACellOnAFaceAndOnAVertex) {
  const auto from = [](const char* name, MeshPiece piece, glm::dvec3 eye) {
    TestScene scene = meshScene(name, haze(), std::move(piece), 32);
    scene.camera.viewpoint = eye;
    scene.camera.viewdirection = glm::dvec3(0.3, -0.2, 0.1) - eye;
    scene.camera.aov = 90;
    return scene;
  };
  const MeshPiece moved = cubeMesh(8, 0.15, waves), still = cubeMesh(8, 0, waves);
  expectAgreement(embree(), from("mesh_eye_in_cell", moved, {0.13, 0.21, 0.47}));
  expectAgreement(embree(), from("mesh_eye_on_moved_vertex", moved, moved.points[9 * 9 * 4 + 9 * 3 + 5]),
                  kFirstAlone);
  expectAgreement(embree(), from("mesh_eye_on_vertex", still, {0.25, 0.5, 0.5}), kFirstAlone);
  expectAgreement(embree(), from("mesh_eye_on_edge", still, {0.375, 0.5, 0.5}), kFirstAlone);
  expectAgreement(embree(), from("mesh_eye_on_face", still, {0.3, 0.4, 0.5}), kFirstAlone);
  expectAgreement(embree(), from("mesh_eye_on_border", still, {0.3, 0.4, 1}), kFirstAlone);
  expectAgreement(embree(), from("mesh_eye_on_border_vertex", still, {0.25, 0.5, 1}), kFirstAlone);
  expectAgreement(embree(), from("mesh_eye_on_corner", still, {1, 1, 1}), kFirstAlone);
}

// The middle of each pixel is a multiple of an eighth: rays run through points, along edges and in faces.
TEST(MeshAgreement, RaysThroughPointsEdgesAndFaces) {
  for (const glm::dvec3 towards :
       {glm::dvec3(0, 0, -1), glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0), glm::dvec3(1, 1, 0),
        glm::dvec3(0, 1, -1), glm::dvec3(1, 1, 1), glm::dvec3(-1, 1, 2), glm::dvec3(3, 1, -2)}) {
    for (const Vis& vis : {haze(), spikes()}) {
      TestScene scene = meshScene("mesh_ties", vis, cubeMesh(8, 0, waves), 27);
      scene.camera.viewpoint = -4.0 * towards;
      scene.camera.viewdirection = towards;
      if (towards.x == 0 && towards.z == 0) scene.camera.viewup = {0, 0, 1};
      scene.camera.aov = 0;
      scene.camera.height = 27.0 / 8;
      expectAgreement(embree(), scene, kFirstAlone, -1, 80);
    }
  }
}

// Chords are full where rays run exactly through points and edges: each misses or doubles no cell.
TEST(MeshAgreement, ChordsOfRaysThroughPointsEdgesAndFacesAreWhole) {
  for (const uint32_t n : {4u, 8u}) {
    TestScene scene = meshScene("mesh_tie_chords", rendered({{0, 1.5}, {1, 1.5}}, 0, 1, true),
                                cubeMesh(n, 0, [](glm::dvec3) { return 0.5; }), 15);
    scene.settings.background = glm::dvec4(0);
    for (const glm::dvec3 towards : {glm::dvec3(0, 0, -1), glm::dvec3(1, 0, 0), glm::dvec3(0, -1, 0)}) {
      scene.camera.viewpoint = -4.0 * towards;
      scene.camera.viewdirection = towards;
      scene.camera.viewup = towards.y != 0 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
      scene.camera.aov = 0;
      scene.camera.height = 15.0 / 8;
      const Picture picture = agreement::draw(embree(), scene);
      for (size_t i = 3; i < picture.rgba.size(); i += 4)
        ASSERT_NEAR(picture.rgba[i], -std::expm1(-3.0), 1e-5) << n << ", pixel " << i / 4;
    }
  }
}

TEST(MeshAgreement, SurfacesInsideAMesh) {
  for (const double opacity : {1.0, 0.5}) {
    TestScene scene = wavyScene("mesh_surfaces", haze());
    GeometryBlock balls;
    balls.points = {{-0.3, -0.2, 0.4}, {0.6, 0.5, 0.2}, {0.9, -0.9, 0.9}};
    balls.values = {-0.5f, 0.1f, 0.8f};
    Vis spheres = agreement::surfaces(VisType::Particles, -1, 1);
    spheres.radius0 = 0.3;
    spheres.opacity = opacity;
    scene.add(spheres, agreement::makeGeometry(GeometryKind::Particles, balls));
    GeometryBlock plate;
    plate.points = {{-1.5, -1.2, -0.5}, {1.5, -1.2, 0.2}, {0, 1.5, -0.3}};
    plate.triangles = {{0, 1, 2}};
    Vis triangles = agreement::surfaces(VisType::Triangles, -1, 1);
    triangles.opacity = opacity;
    scene.add(triangles, agreement::makeGeometry(GeometryKind::Triangles, plate));
    agreement::CompareOptions options = kFirstAlone;
    options.vulkan = opacity < 1;
    expectAgreement(embree(), scene, options);
  }
}

TEST(MeshAgreement, IsosurfacesAndSlicesOfAVolumeInsideAMesh) {
  TestScene scene = wavyScene("mesh_isosurfaces", haze(0.8));
  Vis vis = agreement::surfaces(VisType::Volume, -1, 1);
  vis.isovalues = {0.2};
  vis.slices = {{{1, 0.3, 0.2}, 0.1}};
  vis.opacity = 0.6;
  scene.add(vis, agreement::makeVolume(agreement::cube(12, 0.8), waves));
  expectAgreement(embree(), scene, kFirstAlone);
}

TEST(MeshAgreement, ShadowsAndOcclusionOfAMesh) {
  TestScene scene = wavyScene("mesh_shadows", haze(2), 32);
  GeometryBlock ground;
  ground.points = {{-4, -1.05, -4}, {4, -1.05, -4}, {4, -1.05, 4}, {-4, -1.05, 4}};
  ground.triangles = {{0, 1, 2}, {0, 2, 3}};
  scene.add(agreement::surfaces(VisType::Triangles),
            agreement::makeGeometry(GeometryKind::Triangles, ground));
  GeometryBlock balls;  // some start inside the mesh
  balls.points = {{0.4, 0.5, 0.9}, {-0.6, 0.1, 0.3}, {1.2, -0.5, 0.5}};
  balls.values = {-0.5f, 0.1f, 0.8f};
  Vis spheres = agreement::surfaces(VisType::Particles, -1, 1);
  spheres.radius0 = 0.3;
  scene.add(spheres, agreement::makeGeometry(GeometryKind::Particles, balls));
  scene.visualization.lighting = agreement::lit({agreement::kSun, agreement::kLamp}, true);
  expectAgreement(embree(), scene);
  scene.name = "mesh_occlusion";
  scene.visualization.lighting.aoCount = 3;
  scene.visualization.lighting.aoRadius = 0.7;
  expectAgreement(embree(), scene, kFirstAlone);
}

TEST(MeshAgreement, SeveralRaysPerPixelAndADataRangeOfDoubles) {
  TestScene scene = sceneFrom("mesh_doubles", {2.1, 1.4, 3.3}, 32, 32);
  // 101325 and a hundredth, as float cannot hold them
  Vis vis = rendered({{101324.99, 0}, {101325.01, 1.5}}, 101324.99, 101325.01, true);
  scene.add(vis, meshInOnePiece(cubeMesh(8, 0.15, waves), {}, 101325, 0.01));
  scene.settings.raysPerPixel = 3;
  expectAgreement(embree(), scene, kFirstAlone);
}

TEST(MeshAgreement, ComponentsAndMagnitudes) {
  MeshPiece piece = cubeMesh(8, 0.15, waves);
  std::vector<float> three;
  for (size_t i = 0; i < piece.points.size(); i++)
    three.insert(three.end(), {piece.values[i], float(piece.points[i].x), float(0.5 * piece.points[i].y)});
  piece.components = 3, piece.values = three;
  for (const std::optional<int> component :
       {std::optional<int>(0), std::optional<int>(2), std::optional<int>()}) {
    Vis vis = haze(2, component ? -0.6 : 0, 1);
    vis.component = component;
    expectAgreement(embree(), meshScene("mesh_components", vis, piece, 32), kFirstAlone);
  }
}

TEST(MeshAgreement, MapsThatHideMostOfTheRange) {
  // a thin shell, seen in few cells; and one that no cell has
  const MeshPiece ball = cubeMesh(12, 0.15, [](glm::dvec3 p) { return glm::length(p); });
  expectAgreement(
      embree(),
      meshScene("mesh_shell", rendered({{0.7, 0}, {0.71, 20}, {0.74, 20}, {0.75, 0}}, 0, 1, true), ball));
  TestScene hidden = meshScene("mesh_hidden", rendered({{5, 0}, {5.1, 20}, {6, 0}}, 0, 1, true), ball, 24);
  expectAgreement(embree(), hidden, kFirstAlone, 0, 0);
  EXPECT_TRUE(hidden.compile()->rendered.empty());
}

TEST(MeshAgreement, WhatMeshesCannotShowYetIsRefused) {
  TestScene scene = wavyScene("mesh_refused", haze());
  EXPECT_NO_THROW(scene.compile());
  scene.visualization.operators[0].every = 0.1;
  EXPECT_THROW(scene.compile(), Error);
  scene.visualization.operators[0].every = 0;
  scene.add(haze(), agreement::makeVolume(agreement::cube(6), waves));
  EXPECT_THROW(scene.compile(), Error);
}

// A mesh that is not volume rendered takes part in no plan of volumes that are.
TEST(MeshAgreement, SurfacesOfAMeshAreShownInTwoVolumes) {
  for (const bool transparent : {false, true}) {
    TestScene scene =
        wavyScene("mesh_beside_volumes", transparent ? rendered({{-1, 0}, {1, 0}}, -1, 1) : haze());
    Vis& mesh = scene.visualization.operators[0];
    mesh.isovalues = {0.1};
    mesh.volumeRendering = transparent;
    for (int i = 0; i < 2; i++) scene.add(haze(), agreement::makeVolume(agreement::cube(6), waves));
    expectAgreement(embree(), scene, kFirstAlone);
  }
}

TEST(MeshAgreement, SlicesInTheSidesOfAMesh) {
  for (const double at : {-1.0, 1.0}) {
    TestScene scene = meshScene("mesh_side", agreement::surfaces(VisType::Volume, -1, 1),
                                cubeMesh(4, 0, [](glm::dvec3 p) { return p.x + 0.5 * p.y; }), 32);
    scene.visualization.operators[0].slices = {{{0, 0, 1}, at}};
    scene.camera.viewpoint = {0.3, 0.4, 6};
    scene.camera.viewdirection = {-0.3, -0.4, -6};
    scene.settings.background = glm::dvec4(0);
    const Picture picture = agreement::draw(embree(), scene);
    EXPECT_GT(picture.rgba[4 * (16 * 32 + 16) + 3], 0.5f) << at;
  }
}

}  // namespace
}  // namespace gxy::test

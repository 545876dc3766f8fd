// SPDX-License-Identifier: Apache-2.0
// Isosurfaces and slices of unstructured volumes: backends against reference.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "tests/meshes/mesh_scenes.h"

namespace gxy::test {
namespace {

using agreement::embree;
using agreement::TestScene;

TestScene wavySurfaces(const std::string& name, Vis vis, int size = 40) {
  return meshScene(name, std::move(vis), cubeMesh(10, 0.15, waves), size);
}

TEST(MeshSurfaceAgreement, OneIsosurface) {
  expectAgreement(embree(), wavySurfaces("mesh_iso", surfacesIn({0.2})));
  expectAgreement(embree(), wavySurfaces("mesh_iso_few", surfacesIn({0.95})), kFirstAlone, -1, 4);
  expectAgreement(embree(), wavySurfaces("mesh_iso_none", surfacesIn({7})), kFirstAlone, 0, 0);
}

TEST(MeshSurfaceAgreement, SeveralTranslucentIsosurfaces) {
  expectAgreement(embree(), wavySurfaces("mesh_isos", surfacesIn({0.2, -0.4, 0.5, 0.21}, {}, 0.4)));
}

TEST(MeshSurfaceAgreement, Slices) {
  const std::vector<Plane> planes{{{1, 0.3, 0.2}, 0.1}, {{0, 0, -2}, 0.7}, {{-0.1, 1, 0}, 0.4}};
  expectAgreement(embree(), wavySurfaces("mesh_slices", surfacesIn({}, planes)));
  expectAgreement(embree(), wavySurfaces("mesh_slices_translucent", surfacesIn({}, planes, 0.6)),
                  kFirstAlone);
}

TEST(MeshSurfaceAgreement, InAVolumeThatIsRenderedByTheSameOperator) {
  expectAgreement(embree(), wavySurfaces("mesh_all", surfacesInHaze()));
  Vis opaque = surfacesInHaze();
  opaque.opacity = 1;
  expectAgreement(embree(), wavySurfaces("mesh_all_opaque", opaque), kFirstAlone);
  Vis spiky = spikes();
  spiky.isovalues = {-0.25, 0.1};
  spiky.slices = {{{1, 1, 1}, 0.1}};
  spiky.opacity = 0.5;
  expectAgreement(embree(), wavySurfaces("mesh_all_spiky", spiky), kFirstAlone);
}

TEST(MeshSurfaceAgreement, ClipPlanes) {
  Vis vis = surfacesInHaze();
  vis.clipPlanes = {{{1, 0.2, -0.3}, -0.2}, {{0, -1, 0}, -0.5}};
  expectAgreement(embree(), wavySurfaces("mesh_all_clipped", vis));
  Vis alone = surfacesIn({0.2}, {{{0, 0, 1}, 0.3}});
  alone.clipPlanes = {{{0, 0, -2}, -0.35}, {{-1, 0, 0.5}, -0.3}};
  expectAgreement(embree(), wavySurfaces("mesh_iso_clipped", alone), kFirstAlone);
}

TEST(MeshSurfaceAgreement, OneSidedAndTwoSided) {
  for (const bool twoSided : {false, true}) {
    for (const glm::dvec3 eye : {glm::dvec3(2.1, 1.4, 3.3), glm::dvec3(-2.5, 2.2, -2)}) {
      Vis vis = surfacesIn({0.2, -0.3}, {{{1, 0.3, 0.2}, 0.1}, {{-0.1, 1, 0}, 0.4}}, 0.7);
      vis.twoSided = twoSided;
      TestScene scene = wavySurfaces("mesh_sides", vis, 32);
      scene.camera.viewpoint = eye;
      scene.camera.viewdirection = -eye;
      scene.visualization.lighting = agreement::lit({agreement::kSun, agreement::kHeadlight}, false);
      expectAgreement(embree(), scene, kFirstAlone);
    }
  }
}

TEST(MeshSurfaceAgreement, ShadowsAndOcclusion) {
  for (const double opacity : {1.0, 0.6}) {
    TestScene scene = wavySurfaces("mesh_iso_shadows", surfacesIn({0.2}, {{{0, 1, 0}, -0.8}}, opacity), 32);
    scene.visualization.lighting = agreement::lit({agreement::kSun, agreement::kLamp}, true);
    agreement::CompareOptions options = kFirstAlone;
    options.vulkan = opacity == 1;
    expectAgreement(embree(), scene, options);
    scene.name = "mesh_iso_occlusion";
    scene.visualization.lighting.aoCount = 3;
    scene.visualization.lighting.aoRadius = 0.7;
    expectAgreement(embree(), scene, kFirstAlone);
  }
  TestScene scene = wavySurfaces("mesh_all_lit", surfacesInHaze(), 28);
  scene.visualization.lighting = agreement::lit({agreement::kSun, agreement::kNearLamp}, true);
  scene.visualization.lighting.aoCount = 2;
  scene.visualization.lighting.aoRadius = 0.5;
  expectAgreement(embree(), scene, kFirstAlone);
}

TEST(MeshSurfaceAgreement, WithParticlesTrianglesAndAnotherMesh) {
  TestScene scene = sceneFrom("mesh_iso_with", {2.1, 1.4, 3.3}, 36, 36);
  GeometryBlock balls;
  balls.points = {{-0.3, -0.2, 0.4}, {0.6, 0.5, 0.2}, {0.9, -0.9, 0.9}};
  balls.values = {-0.5f, 0.1f, 0.8f};
  Vis spheres = agreement::surfaces(VisType::Particles, -1, 1);
  spheres.radius0 = 0.3;
  spheres.opacity = 0.7;
  scene.add(spheres, agreement::makeGeometry(GeometryKind::Particles, balls));
  scene.add(surfacesInHaze(), meshInOnePiece(cubeMesh(8, 0.15, waves)));
  GeometryBlock plate;
  plate.points = {{-1.5, -1.2, -0.5}, {1.5, -1.2, 0.2}, {0, 1.5, -0.3}};
  plate.triangles = {{0, 1, 2}};
  scene.add(agreement::surfaces(VisType::Triangles, -1, 1),
            agreement::makeGeometry(GeometryKind::Triangles, plate));
  scene.add(surfacesIn({0.1}, {}, 0.8), meshInOnePiece(placed(cubeMesh(6, 0.15, waves), [](glm::dvec3 p) {
              return 0.6 * p + glm::dvec3(0.3, 0.4, 0.6);
            })));
  expectAgreement(embree(), scene);
  scene.name = "mesh_iso_with_lights";
  scene.visualization.lighting = agreement::lit({agreement::kSun, agreement::kLamp}, true);
  scene.visualization.lighting.aoCount = 2;
  scene.visualization.lighting.aoRadius = 0.7;
  expectAgreement(embree(), scene, kFirstAlone);
}

TEST(MeshSurfaceAgreement, OfAVolumeOnAGridBesideThoseOfAMesh) {
  TestScene scene = wavySurfaces("mesh_iso_beside_volume", surfacesIn({0.2}, {{{1, 0, 0}, 0.3}}, 0.6), 36);
  Vis vis = surfacesIn({-0.2}, {{{0.2, 1, 0}, 0.1}}, 0.6);
  scene.add(vis, agreement::makeVolume(agreement::cube(12, 0.8), waves));
  expectAgreement(embree(), scene, kFirstAlone);
}

TEST(MeshSurfaceAgreement, TheEyeOnASurface) {
  const MeshPiece moved = cubeMesh(8, 0.15, waves), still = cubeMesh(8, 0, waves);
  const auto from = [](const char* name, Vis vis, const MeshPiece& piece, glm::dvec3 eye) {
    TestScene scene = meshScene(name, std::move(vis), piece, 28);
    scene.camera.viewpoint = eye;
    scene.camera.viewdirection = glm::dvec3(0.3, -0.2, 0.1) - eye;
    scene.camera.aov = 70;
    return scene;
  };
  const size_t number = 9 * 9 * 4 + 9 * 3 + 5;
  const glm::dvec3 point = moved.points[number];
  // Whether the surface at the eye itself is seen is a matter of rounding, so it is clipped away.
  const auto clipped = [](Vis vis, glm::dvec3 eye) {
    const glm::dvec3 ahead = glm::normalize(glm::dvec3(0.3, -0.2, 0.1) - eye);
    vis.clipPlanes = {{ahead, glm::dot(ahead, eye) + 1e-4}};
    return vis;
  };
  expectAgreement(embree(),
                  from("mesh_eye_on_iso_vertex", clipped(surfacesIn({moved.values[number]}, {}, 0.5), point),
                       moved, point),
                  kFirstAlone);
  expectAgreement(embree(),
                  from("mesh_eye_on_iso_vertex_still",
                       clipped(surfacesIn({still.values[number]}, {}, 0.5), still.points[number]), still,
                       still.points[number]),
                  kFirstAlone);
  const Vis slices = surfacesIn({}, {{{0, 0, 1}, 0.5}, {{1, 0, 0}, 0.25}, {{0, 1, 0}, -0.25}}, 0.5);
  for (const glm::dvec3 eye : {glm::dvec3(0.25, 0.5, 0.5), glm::dvec3(0.3, 0.4, 0.5)})
    expectAgreement(embree(), from("mesh_eye_on_slice", clipped(slices, eye), still, eye), kFirstAlone);
}

TEST(MeshSurfaceAgreement, SeveralRaysPerPixelAndADataRangeOfDoubles) {
  TestScene scene = sceneFrom("mesh_iso_doubles", {2.1, 1.4, 3.3}, 32, 32);
  // 101325 and a hundredth, as float cannot hold them
  Vis vis = surfacesIn({101325.002, 101324.997}, {{{1, 0.3, 0.2}, 0.1}}, 0.7);
  vis.colormap.points = {{101324.99, {0.1, 0.2, 0.9}}, {101325.01, {0.9, 0.1, 0.1}}};
  scene.add(vis, meshInOnePiece(cubeMesh(8, 0.15, waves), {}, 101325, 0.01));
  scene.settings.raysPerPixel = 3;
  expectAgreement(embree(), scene, kFirstAlone);
}

TEST(MeshSurfaceAgreement, ComponentsAndMagnitudes) {
  MeshPiece piece = cubeMesh(8, 0.15, waves);
  std::vector<float> three;
  for (size_t i = 0; i < piece.points.size(); i++)
    three.insert(three.end(), {piece.values[i], float(piece.points[i].x), float(0.5 * piece.points[i].y)});
  piece.components = 3, piece.values = three;
  for (const std::optional<int> component :
       {std::optional<int>(0), std::optional<int>(2), std::optional<int>()}) {
    Vis vis = surfacesIn({0.2, 0.45}, {{{1, 0.3, 0.2}, 0.1}}, 0.7);
    vis.component = component;
    expectAgreement(embree(), meshScene("mesh_iso_components", vis, piece, 32), kFirstAlone);
  }
}

}  // namespace
}  // namespace gxy::test

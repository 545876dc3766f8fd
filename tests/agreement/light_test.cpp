// SPDX-License-Identifier: Apache-2.0
// Light, shadows and ambient occlusion, and everything in one picture: backend against reference.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "backend.h"
#include "compare.h"

namespace gxy::agreement {
namespace {

const glm::dvec3 kEye(2.1, 1.7, 3.3);

std::shared_ptr<const Volume> wavy() {
  static const auto volume = makeVolume(cube(28), waves);
  return volume;
}

GeometryBlock floor() {
  GeometryBlock block;
  block.points = {{-2, -1.05, -2}, {2, -1.05, -2}, {2, -1.05, 2}, {-2, -1.05, 2}};
  block.triangles = {{0, 1, 2}, {0, 2, 3}};
  return block;
}

/// A floor, spheres, tubes, a mesh with normals, an isosurface and a slice.
TestScene solids(const std::string& name, int size = 72) {
  TestScene scene = sceneFrom(name, kEye, size, size);
  scene.add(surfaces(VisType::Triangles), makeGeometry(GeometryKind::Triangles, floor()));
  GeometryBlock balls;
  balls.points = {{-0.7, -0.6, 0.9}, {0.8, -0.7, 0.6}, {0.9, 0.3, -0.4}};
  balls.values = {0.2f, 0.6f, 0.9f};
  Vis spheres = surfaces(VisType::Particles);
  spheres.radius0 = 0.2, spheres.radius1 = 0.4, spheres.value1 = 1;
  scene.add(spheres, makeGeometry(GeometryKind::Particles, balls));
  GeometryBlock line;
  addLine(line, {{-1.2, -0.8, 0.2}, {-0.4, -0.3, 1.2}, {0.3, 0.2, 0.9}, {0.2, 0.8, 1}, {0.9, 0.9, 0.8}},
          {0.1f, 0.9f, 0.3f, 0.5f, 0.8f});
  Vis tubes = surfaces(VisType::PathLines);
  tubes.radius0 = 0.03, tubes.radius1 = 0.15, tubes.value1 = 1;
  scene.add(tubes, makeGeometry(GeometryKind::PathLines, line));
  GeometryBlock mesh = sphereMesh(20, true, true);
  for (glm::dvec3& p : mesh.points) p = p * 0.35 + glm::dvec3(-0.7, 0.7, -0.6);
  scene.add(surfaces(VisType::Triangles), makeGeometry(GeometryKind::Triangles, mesh));
  Vis iso = surfaces(VisType::Volume, -1, 1);
  iso.isovalues = {0.5};
  scene.add(iso, wavy());
  Vis slice = surfaces(VisType::Volume, -1, 1);
  slice.slices = {{{0.2, 0, 1}, -0.8}};
  scene.add(slice, wavy());
  return scene;
}

Lighting lit(std::vector<Light> sources, bool shadows) {
  Lighting lighting;
  lighting.sources = std::move(sources);
  lighting.shadows = shadows;
  lighting.Ka = 0.3, lighting.Kd = 0.6, lighting.Ks = 0.3;
  return lighting;
}

const Light kSun{LightType::Directional, {-0.5, -1, -0.3}};
const Light kLamp{LightType::Point, {1.5, 2, 1}};
const Light kNearLamp{LightType::Point, {0.1, 0.3, 0.4}};
const Light kHeadlight{LightType::Camera, {0.7, 0.9, -0.2}};

TEST(LightAgreement, EveryKindOfLightWithSpecular) {
  TestScene scene = solids("lights");
  scene.visualization.lighting = lit({kSun, kLamp, kHeadlight}, false);
  expectAgreement(embree(), scene);
  scene.name = "camera_light_ahead";
  scene.visualization.lighting = lit({{LightType::Camera, {0.3, -0.2, 2.5}}}, false);
  scene.camera.viewup = {0.3, 1, 0.1};
  expectAgreement(embree(), scene);
  scene.name = "zero_direction";
  scene.visualization.lighting = lit({{LightType::Directional, {0, 0, 0}}}, false);
  expectAgreement(embree(), scene);
}

TEST(LightAgreement, Shadows) {
  TestScene scene = solids("shadows");
  scene.visualization.lighting = lit({kSun}, true);
  expectAgreement(embree(), scene);
  scene.name = "shadows_lamps";
  scene.visualization.lighting = lit({kLamp, kNearLamp, kHeadlight}, true);
  expectAgreement(embree(), scene);
}

TEST(LightAgreement, ShadowsOfTranslucentSurfaces) {
  TestScene scene = solids("shadows_translucent", 56);
  for (Vis& vis : scene.visualization.operators) vis.opacity = 0.6;
  scene.visualization.lighting = lit({kSun, kNearLamp}, true);
  expectAgreement(embree(), scene);
}

TEST(LightAgreement, ShadowsOfOneSidedSurfaces) {
  TestScene scene = solids("shadows_one_sided", 56);
  for (Vis& vis : scene.visualization.operators) vis.twoSided = false, vis.opacity = 0.7;
  scene.visualization.lighting = lit({kSun, kHeadlight}, true);
  expectAgreement(embree(), scene);
}

TEST(LightAgreement, ShadowsOfClippedSurfaces) {
  TestScene scene = solids("shadows_clipped");
  for (size_t i = 1; i < scene.visualization.operators.size(); i++)
    scene.visualization.operators[i].clipPlanes = {{{-0.2, 0, -1}, -0.7}, {{1, 0.2, 0}, -0.6}};
  scene.visualization.lighting = lit({kLamp}, true);
  expectAgreement(embree(), scene);
}

TEST(LightAgreement, VolumesCastSoftShadows) {
  TestScene scene = solids("shadows_volume", 48);
  scene.add(rendered({{-1, 0}, {0, 0}, {1, 0.3}}, -1, 1), wavy());
  scene.visualization.lighting = lit({kSun, kLamp}, true);
  expectAgreement(embree(), scene);
}

TEST(LightAgreement, AmbientOcclusion) {
  TestScene scene = solids("ao");
  scene.visualization.lighting = lit({kSun}, false);
  scene.visualization.lighting.aoCount = 8;
  scene.visualization.lighting.aoRadius = 0.7;
  CompareOptions options;
  options.frameNumber = 5;
  expectAgreement(embree(), scene, options);
}

TEST(LightAgreement, AmbientOcclusionThroughTranslucentSurfacesAndVolumes) {
  TestScene scene = solids("ao_translucent", 40);
  for (Vis& vis : scene.visualization.operators) vis.opacity = 0.6;
  scene.add(rendered({{-1, 0}, {1, 0.1}}, -1, 1), wavy());
  scene.visualization.lighting = lit({}, false);
  scene.visualization.lighting.aoCount = 4;
  expectAgreement(embree(), scene);
}

TEST(LightAgreement, AmbientOcclusionConvergesToTheHemisphere) {
  TestScene scene = solids("ao_converged", 32);
  scene.visualization.lighting = lit({}, false);
  scene.visualization.lighting.Ka = 1;
  scene.visualization.lighting.aoCount = 16;
  std::vector<double> mean(4 * 32 * 32);
  const int frames = 16;
  for (int f = 0; f < frames; f++) {
    const Picture one = draw(embree(), scene, uint32_t(f));
    for (size_t i = 0; i < mean.size(); i++) mean[i] += one.rgba[i] / double(frames);
  }
  reference::ReferenceOptions how;
  how.aoDirections = 256;
  const auto truth = reference::renderReference(scene.forReference(), scene.camera, how);
  double squared = 0;
  int pixels = 0;
  for (size_t i = 0; i < mean.size(); i += 4) {
    if (truth.rgba[i + 3] == 0) continue;
    squared += (mean[i] - truth.rgba[i]) * (mean[i] - truth.rgba[i]);
    pixels++;
  }
  // 256 low-discrepancy directions each: far below the 1 / sqrt(256) / 2 of independent ones.
  EXPECT_LT(std::sqrt(squared / pixels), 0.01);
  EXPECT_GT(pixels, 300);
}

TEST(EverythingAgreement, AllAtOnce) {
  TestScene scene = solids("everything", 56);
  scene.visualization.operators[1].opacity = 0.5;
  scene.visualization.operators[2].opacity = 0.7;
  scene.visualization.operators[4].opacity = 0.6;
  scene.visualization.operators[4].isovalues = {0.5, -0.5};
  scene.visualization.operators[5].clipPlanes = {{{1, 0, 0}, -0.5}};
  scene.add(rendered({{-1, 0}, {0, 0}, {1, 0.2}}, -1, 1), wavy());
  scene.add(rendered({{0.6, 0}, {0.6, 0.2}}), makeVolume(cube(24, 0.8), marschnerLobb));
  scene.visualization.lighting = lit({kSun, kLamp, kHeadlight}, true);
  scene.visualization.lighting.aoCount = 2;
  scene.visualization.lighting.aoRadius = 0.5;
  scene.settings.background = {0.1, 0.2, 0.3, 1};
  scene.settings.raysPerPixel = 2;
  expectAgreement(embree(), scene);
}

}  // namespace
}  // namespace gxy::agreement

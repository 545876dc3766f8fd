// SPDX-License-Identifier: Apache-2.0
// Light, shadows and ambient occlusion, and everything in one picture: backend against reference.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "tests/agreement/backend.h"
#include "tests/agreement/compare.h"

namespace gxy::agreement {
namespace {

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

// A pixel's light is a sum of 32 bits: what it cannot hold is left out, and never turns into darkness.
TEST(LightAgreement, WhatIsTooBrightForAPixelIsAsBrightAsItHolds) {
  TestScene scene = solids("too_bright", 32);
  auto drawn = [&](double weight, bool shadows) {
    scene.visualization.lighting = lit({kSun, kLamp, kHeadlight}, shadows);
    scene.visualization.lighting.Ka = scene.visualization.lighting.Kd = weight;
    scene.visualization.lighting.Ks = 0;
    return drawnByBoth(scene).rgba;
  };
  const LargeVector<float> dim = drawn(0.5, false), bright = drawn(25, false), shadowed = drawn(25, true);
  int full = 0;
  for (size_t i = 0; i < dim.size(); i++) {
    if (i % 4 == 3) continue;
    ASSERT_NEAR(bright[i], std::min(50 * dim[i], 31.f), 1e-3) << i;
    ASSERT_GE(shadowed[i], 0) << i;
    ASSERT_LE(shadowed[i], bright[i]) << i;
    full += bright[i] > 30;
  }
  EXPECT_GT(full, 50);
}

TEST(LightAgreement, Shadows) {
  TestScene scene = solids("shadows");
  scene.visualization.lighting = lit({kSun}, true);
  expectAgreement(embree(), scene);
  scene.name = "shadows_lamps";
  scene.visualization.lighting = lit({kLamp, kNearLamp, kHeadlight}, true);
  expectAgreement(embree(), scene);
  for (const double far : {1e8, 1e12, 1e30, 1e100}) {  // past what a float holds, and its square
    scene.name = "shadows_lamp_far_away";
    scene.visualization.lighting = lit({{LightType::Point, far * glm::dvec3(0.4, 0.7, 0.5)}}, true);
    expectAgreement(embree(), scene);
  }
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

// Found by random scenes: rounding must not choose between two sets of directions where normals are common.
TEST(LightAgreement, AmbientOcclusionOnNormalsInCoordinatePlanes) {
  TestScene scene = sceneFrom("ao_planes", {2.1, 1.7, 3.3}, 48, 48);
  GeometryBlock mesh = sphereMesh(4, false, false);
  const auto ball = uint32_t(mesh.points.size());
  for (const glm::dvec3 p : {glm::dvec3(-1, -0.6, 0), {0.3, -0.6, 1.2}, {0.3, 1, 1.2}, {-1, 1, 0}})
    mesh.points.push_back(p);
  mesh.triangles.push_back({ball, ball + 1, ball + 2});
  mesh.triangles.push_back({ball, ball + 2, ball + 3});
  scene.add(surfaces(VisType::Triangles), makeGeometry(GeometryKind::Triangles, mesh));
  scene.visualization.lighting = lit({}, false);
  scene.visualization.lighting.aoCount = 3;
  expectAgreement(embree(), scene);
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
    const Picture one = drawnByBoth(scene, uint32_t(f));
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
  CompareOptions options;
  options.vulkan = false;
  expectAgreement(embree(), everything(56), options);
  drawnByBoth(everything(16));  // of which a software device draws few pixels a second
}

}  // namespace
}  // namespace gxy::agreement

// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "tests/reference/samples.h"

namespace gxy::reference {
namespace {

/// A floor z = 0 within [-half, half]^2, white: a slice of a constant volume.
struct Stage {
  ReferenceScene scene;

  explicit Stage(double half = 1) {
    Vis floor = plain(VisType::Volume, glm::dvec3(1));
    floor.slices = {{{0, 0, 1}, 0}};
    scene.visualization.operators = {floor};
    scene.visualization.lighting.Ka = 0.25;
    scene.visualization.lighting.Kd = 0.75;
    scene.data = {constant(half)};
  }
  static std::shared_ptr<const Volume> constant(double half) {
    return makeVolume(cube(3, -half, half), [](glm::dvec3) { return 0; });
  }
  void add(const Vis& vis, ReferenceData data) {
    scene.visualization.operators.push_back(vis);
    scene.data.push_back(std::move(data));
  }
  Lighting& lighting() { return scene.visualization.lighting; }
  /// The floor's red at a point, seen from just above it.
  double at(glm::dvec3 point, const ReferenceOptions& options = {}) const {
    const glm::dvec3 from = point + glm::dvec3(0, 0, 1e-3);
    return renderReference(scene, along(from, point - from), options).rgba[0];
  }
};

std::shared_ptr<Geometry> sphere(glm::dvec3 centre) {
  auto geometry = std::make_shared<Geometry>();
  geometry->kind = GeometryKind::Particles;
  geometry->blocks[0].points = {centre};
  return geometry;
}

Vis sphereVis(double radius, double opacity = 1) {
  Vis vis = plain(VisType::Particles, glm::dvec3(1));
  vis.radius0 = radius;
  vis.opacity = opacity;
  return vis;
}

TEST(Light, DirectionalLightFollowsLambert) {
  Stage stage;
  stage.lighting().sources = {{LightType::Directional, {0, 3, -4}}};
  EXPECT_NEAR(stage.at({0.1, 0.2, 0}), 0.25 + 0.75 * 0.8, 1e-12);
  stage.lighting().sources = {{LightType::Directional, {0, 0, 1}}};  // from behind the side that is seen
  EXPECT_NEAR(stage.at({0.1, 0.2, 0}), 0.25, 1e-12);
}

TEST(Light, ZeroDirectionStandsForTheDiagonal) {
  Stage stage;
  stage.lighting().sources = {{LightType::Directional, {0, 0, 0}}};
  const glm::dvec3 below(0.1, 0.2, -1e-3);
  const double lit = renderReference(stage.scene, along(below, {0, 0, 1})).rgba[0];
  EXPECT_NEAR(lit, 0.25 + 0.75 / std::sqrt(3.0), 1e-12);
}

TEST(Light, DiffuseIsSharedAmongLights) {
  Stage stage;
  stage.lighting().sources = {{LightType::Directional, {0, 0, -1}}, {LightType::Point, {0.1, 0.2 + 3, 4}}};
  EXPECT_NEAR(stage.at({0.1, 0.2, 0}), 0.25 + 0.375 * (1 + 0.8), 1e-12);
}

TEST(Light, CameraLightStandsAtItsOffsetFromTheEye) {
  Stage stage;
  // Seen from above with up = +y: right = +x, view = -z.
  stage.lighting().sources = {{LightType::Camera, {0.3, 0, -(0.4 - 1e-3)}}};
  EXPECT_NEAR(stage.at({0, 0, 0}), 0.25 + 0.75 * 0.8, 1e-12);
}

TEST(Light, SpecularIsWhitePhongAboutTheMirrorDirection) {
  Stage stage;
  stage.scene.visualization.operators[0].colormap.points = {{0, glm::dvec3(0)}};
  stage.lighting().Ks = 0.5;
  stage.lighting().shininess = 20;
  stage.lighting().sources = {{LightType::Directional, {0, 3, -4}}};
  EXPECT_NEAR(stage.at({0.1, 0.2, 0}), 0.5 * std::pow(0.8, 20), 1e-12);
}

TEST(Shadow, OfASphereUnderAPointLightEndsAtItsCone) {
  // Light at height 3, sphere of radius 0.5 at height 1: the tangent cone has sine 0.25.
  Stage stage;
  stage.lighting().sources = {{LightType::Point, {0, 0, 3}}};
  stage.lighting().shadows = true;
  stage.add(sphereVis(0.5), sphere({0, 0, 1}));
  const double edge = 3 * 0.25 / std::sqrt(1 - 0.0625);
  EXPECT_NEAR(stage.at({edge - 1e-9, 0, 0}), 0.25, 1e-12);
  const double r = edge + 1e-9;
  EXPECT_NEAR(stage.at({r, 0, 0}), 0.25 + 0.75 * 3 / std::sqrt(9 + r * r), 1e-12);
}

TEST(Shadow, EndsAtThePointLight) {
  Stage stage;
  stage.lighting().sources = {{LightType::Point, {0, 0, 1}}};
  stage.lighting().shadows = true;
  stage.add(sphereVis(0.5), sphere({0, 0, 2}));  // behind the light
  EXPECT_NEAR(stage.at({0, 0, 0}), 1, 1e-12);
}

TEST(Shadow, OfATranslucentSphereLetsThroughBothOfItsSides) {
  Stage stage;
  stage.lighting().sources = {{LightType::Directional, {0, 0, -1}}};
  stage.lighting().shadows = true;
  stage.add(sphereVis(0.5, 0.4), sphere({0, 0, 1}));
  EXPECT_NEAR(stage.at({0, 0, 0}), 0.25 + 0.75 * 0.36, 1e-12);
}

TEST(Shadow, OfAVolumeIsItsTransmittance) {
  Stage stage;
  stage.lighting().sources = {{LightType::Directional, {0, 0, -1}}};
  stage.lighting().shadows = true;
  Vis smoke;
  smoke.volumeRendering = true;
  smoke.opacitymap = {true, {{0, 0.7}}};
  stage.add(smoke, makeVolume({{-1, -1, 0.5}, glm::dvec3(1), {3, 3, 2}}, [](glm::dvec3) { return 0; }));
  EXPECT_NEAR(stage.at({0.1, 0.2, 0}), 0.25 + 0.75 * std::exp(-0.7), 1e-12);
}

TEST(Shadow, SurfacesDoNotShadowThemselvesAtAnyScale) {
  for (double scale : {1e-3, 1.0, 1e7}) {
    for (glm::dvec3 shift : {glm::dvec3(0), glm::dvec3(1e4 * scale)}) {
      const double n = 24;
      const auto volume = makeVolume({shift - scale, glm::dvec3(2 * scale / (n - 1)), {24, 24, 24}},
                                     [&](glm::dvec3 p) { return glm::length(p - shift) / scale; });
      ReferenceScene scene;
      Vis vis = plain(VisType::Volume, glm::dvec3(1));
      vis.isovalues = {0.7};
      scene.visualization.operators = {vis, plain(VisType::Particles, glm::dvec3(1))};
      scene.visualization.operators[1].radius0 = 0.3 * scale;
      scene.data = {volume, sphere(shift + glm::dvec3(3 * scale, 0, 0))};
      Lighting& lighting = scene.visualization.lighting;
      lighting.Ka = 0;
      lighting.Kd = 1;
      lighting.sources = {{LightType::Directional, {0, 0, -1}}};
      Camera camera = along(shift + glm::dvec3(0, 0, 4 * scale), {0, 0, -1});
      camera.height = 8 * scale;
      camera.dimensions = {64, 16};
      const ReferencePicture lit = renderReference(scene, camera);
      lighting.shadows = true;
      const ReferencePicture shadowed = renderReference(scene, camera);
      int differing = 0;
      for (size_t i = 0; i < lit.rgba.size(); i++)
        differing += std::abs(lit.rgba[i] - shadowed.rgba[i]) > 1e-12;
      EXPECT_EQ(differing, 0) << scale;
    }
  }
}

TEST(AmbientOcclusion, UnderAWidePlaneIsTheCosineWeightedCap) {
  // A ceiling at height h blocks directions with h / cos <= R: the share 1 - (h/R)^2.
  Stage stage(4);
  stage.lighting().sources.clear();
  stage.lighting().Ka = 1;
  stage.lighting().aoCount = 1;
  stage.lighting().aoRadius = 1;
  stage.scene.visualization.operators[0].slices.push_back({{0, 0, 1}, 0.6});
  ReferenceOptions options;
  options.aoDirections = 20000;
  EXPECT_NEAR(stage.at({0.3, 0.1, 0}, options), 0.36, 2e-4);
  stage.scene.visualization.operators[0].opacity = 1;
  stage.lighting().aoRadius = 0.59;  // too short to reach it
  EXPECT_EQ(stage.at({0.3, 0.1, 0}, options), 1);
}

TEST(AmbientOcclusion, AtAWallIsOneHalf) {
  Stage stage(100);
  stage.lighting() = ambientOnly();
  stage.lighting().aoCount = 1;
  stage.lighting().aoRadius = 50;
  stage.scene.visualization.operators[0].slices.push_back({{1, 0, 0}, 1e-5});
  ReferenceOptions options;
  options.aoDirections = 20000;
  EXPECT_NEAR(stage.at({0, 0, 0}, options), 0.5, 2e-3);
}

TEST(AmbientOcclusion, OfASphereIsTheProjectedSolidAngle) {
  // A sphere straight above at distance d blocks (r/d)^2 of the cosine-weighted hemisphere.
  Stage stage;
  stage.lighting() = ambientOnly();
  stage.lighting().aoCount = 1;
  stage.lighting().aoRadius = 10;
  stage.add(sphereVis(0.5, 0.5), sphere({0, 0, 1}));
  ReferenceOptions options;
  options.aoDirections = 20000;
  EXPECT_NEAR(stage.at({0, 0, 0}, options), 1 - 0.25 * 0.75, 2e-4) << "two sides of opacity 1/2 block 3/4";
}

TEST(AmbientOcclusion, HookGivesTheDirections) {
  Stage stage(4);
  stage.lighting() = ambientOnly();
  stage.lighting().aoCount = 2;
  stage.scene.visualization.operators[0].slices.push_back({{0, 0, 1}, 0.6});
  ReferenceOptions options;
  options.aoHook = [](const AoRequest& request) {
    EXPECT_EQ(request.pixel, glm::ivec2(0));
    EXPECT_NEAR(request.normal.z, 1, 1e-15);
    return std::vector<glm::dvec3>{{0, 0, 1}, {1, 0, 0}, {0, 1, 0}};
  };
  EXPECT_NEAR(stage.at({0, 0, 0}, options), 2.0 / 3, 1e-15);
}

}  // namespace
}  // namespace gxy::reference

// SPDX-License-Identifier: Apache-2.0
// Pictures of isosurfaces and slices of unstructured volumes, against closed forms and uniform volumes.
#include <gtest/gtest.h>

#include "tests/reference/mesh_samples.h"

namespace gxy::reference {
namespace {

double slope(glm::dvec3 p) { return 0.125 + 0.5 * p.x + 0.25 * p.y - 0.125 * p.z; }

Vis surfacesOf(std::vector<double> isovalues, std::vector<Plane> slices, double opacity = 1) {
  Vis vis;
  vis.isovalues = std::move(isovalues);
  vis.slices = std::move(slices);
  vis.opacity = opacity;
  vis.colormap.points = {{0, {0, 0.2, 1}}, {0.4, {0, 1, 0.5}}, {0.4, {1, 1, 0}}, {1, {1, 0, 0}}};
  vis.opacitymap = {true, {{0, 0}, {1, 3}}};
  return vis;
}

ReferenceScene surfaceScene(std::vector<Vis> operators, const ReferenceData& data) {
  ReferenceScene scene;
  scene.data.assign(operators.size(), data);
  scene.visualization.operators = std::move(operators);
  scene.visualization.lighting = ambientOnly();
  return scene;
}

ReferenceScene surfaceScene(std::vector<Vis> operators, const std::shared_ptr<Mesh>& mesh) {
  return surfaceScene(std::move(operators), std::make_shared<const MeshField>(*mesh, std::nullopt));
}

Camera lookingDown(int size = 24) {
  Camera camera;
  camera.viewpoint = {2.2, 1.7, 3.1};
  camera.viewdirection = glm::dvec3(0.5) - camera.viewpoint;
  camera.dimensions = {size, size};
  camera.aov = 35;
  return camera;
}

/// Expects the same pictures of a linear field on a mesh and on a grid.
void expectThatOfTheGrid(const std::vector<Vis>& operators, const Lighting& lighting) {
  ReferenceScene ours = surfaceScene(operators, meshOf(cubeOfTets(4, inside(0.04, 9), slope))),
                 theirs = surfaceScene(operators, makeVolume(cube(5, 0, 1), slope));
  ours.visualization.lighting = theirs.visualization.lighting = lighting;
  ReferenceOptions how;
  how.tolerance = 1e-9;
  const ReferencePicture a = renderReference(ours, lookingDown(), how),
                         b = renderReference(theirs, lookingDown(), how);
  int seen = 0;
  for (size_t i = 0; i < a.rgba.size(); i++) EXPECT_NEAR(a.rgba[i], b.rgba[i], 1e-8) << "pixel " << i / 4;
  for (size_t i = 0; i < a.depth.size(); i++) {
    EXPECT_NEAR(a.depth[i], b.depth[i], 1e-12 * b.depth[i]);
    seen += b.depth[i] < 1e30;
  }
  EXPECT_GT(seen, 60);
}

const std::vector<Plane> kPlanes{{{1, 0.3, 0.2}, 0.7}, {{0, 0, -2}, -0.8}};

TEST(MeshSurfacePicture, OfALinearFieldIsThatOfTheUniformVolume) {
  const Lighting still = ambientOnly();
  expectThatOfTheGrid({surfacesOf({0.4}, {})}, still);
  expectThatOfTheGrid({surfacesOf({0.2, 0.31, 0.45, 0.6}, {}, 0.5)}, still);
  expectThatOfTheGrid({surfacesOf({}, kPlanes, 0.7)}, still);
  Vis all = surfacesOf({0.3, 0.5}, kPlanes, 0.6);
  all.volumeRendering = true;
  expectThatOfTheGrid({all}, still);
  all.clipPlanes = {{{1, 0.25, -0.5}, 0.125}, {{0, -1, 0}, -0.9}};
  expectThatOfTheGrid({all}, still);
  expectThatOfTheGrid({surfacesOf({0.35}, {}, 0.5), all}, still);
}

TEST(MeshSurfacePicture, OfALinearFieldIsThatOfTheUniformVolumeInAnyLight) {
  Lighting lighting;
  lighting.Ka = 0.3, lighting.Kd = 0.6, lighting.Ks = 0.2, lighting.shadows = true;
  lighting.sources = {{LightType::Directional, {-1, -2, -0.7}}, {LightType::Point, {0.1, 0.5, 2}}};
  lighting.aoCount = 3, lighting.aoRadius = 0.6;
  Vis vis = surfacesOf({0.3, 0.5}, kPlanes, 0.6);
  for (const bool twoSided : {true, false}) {
    vis.twoSided = twoSided;
    expectThatOfTheGrid({vis}, lighting);
  }
  vis.volumeRendering = true;
  vis.opacity = 1;
  expectThatOfTheGrid({vis}, lighting);
}

// Values rise to +x, so the outside is towards -x.
TEST(MeshSurfacePicture, TheOutsideOfAnIsosurfaceIsWhereValuesAreLower) {
  const auto mesh = meshOf(cubeOfTets(3, inside(0.04, 9), [](glm::dvec3 p) { return p.x; }));
  const auto shade = [&](Vis vis, double from) {
    vis.colormap.points = {{0, glm::dvec3(1)}};
    ReferenceScene scene = surfaceScene({vis}, mesh);
    Lighting& lighting = scene.visualization.lighting;
    lighting.Ka = 0, lighting.Kd = 1, lighting.Ks = 0;
    lighting.sources = {{LightType::Directional, {-from, 0, 0}}};
    return renderReference(scene, along({3 * from, 0.4, 0.3}, {-from, 0, 0})).rgba[0];
  };
  for (const double from : {-1.0, 1.0}) {
    Vis vis = surfacesOf({0.4}, {});
    vis.twoSided = false;
    EXPECT_NEAR(shade(vis, from), from < 0 ? 1 : 0, 1e-12);
    vis.twoSided = true;
    EXPECT_NEAR(shade(vis, from), 1, 1e-12);
    vis = surfacesOf({}, {{{2, 0, 0}, 0.8}});
    vis.twoSided = false;
    EXPECT_NEAR(shade(vis, from), from > 0 ? 1 : 0, 1e-12) << "a slice faces along its normal";
  }
}

TEST(MeshSurfacePicture, TranslucentSurfacesCutTheIntegralOfTheVolume) {
  Vis vis = surfacesOf({0.25, 0.75}, {{{0, 0, 1}, 0.5}}, 0.5);
  vis.volumeRendering = true;
  vis.opacitymap = {true, {{0, 2}}};
  vis.colormap.points = {{0, {0, 0, 0}}, {1, {0, 1, 0}}};
  const auto mesh = meshOf(cubeOfTets(4, inside(0.04, 9), [](glm::dvec3 p) { return p.z; }));
  const ReferencePicture picture =
      renderReference(surfaceScene({vis}, mesh), along({0.41, 0.52, 3}, {0, 0, -1}));
  // Green is z itself, with extinction 2: the haze from depth a to b below the top, seen from a.
  const auto haze = [](double a, double b) {
    const auto part = [](double x) { return -std::exp(-2 * x) * (1 - x - 0.5); };
    return (part(b) - part(a)) * std::exp(2 * a);
  };
  const double quarter = std::exp(-0.5);
  double green = 0, through = 1;
  for (int i = 0; i < 4; i++) {
    green += through * haze(0.25 * i, 0.25 * (i + 1));
    through *= quarter;
    if (i == 3) break;
    green += through * 0.5 * (0.75 - 0.25 * i);
    through *= 0.5;
  }
  EXPECT_NEAR(picture.rgba[1], green, 1e-9);
  EXPECT_NEAR(picture.rgba[3], 1 - through, 1e-9);
  EXPECT_NEAR(picture.depth[0], 2.25, 1e-12);
}

TEST(MeshSurfacePicture, SurfacesAtTheSamePlaceAreAllMetInTheOrderOfOperators) {
  const auto mesh = meshOf(cubeOfTets(4, kStill, [](glm::dvec3 p) { return p.z; }));
  Vis red = surfacesOf({0.5}, {{{0, 0, 1}, 0.5}}, 0.5), green = red;
  red.colormap.points = {{0, {1, 0, 0}}};
  green.colormap.points = {{0, {0, 1, 0}}};
  for (const glm::dvec3 at : {glm::dvec3(0.3, 0.4, 3), glm::dvec3(0.5, 0.5, 3), glm::dvec3(0.25, 0.4, 3)}) {
    const ReferencePicture picture = renderReference(surfaceScene({red, green}, mesh), along(at, {0, 0, -1}));
    EXPECT_NEAR(picture.rgba[0], 0.75, 1e-12);
    EXPECT_NEAR(picture.rgba[1], 0.1875, 1e-12);
  }
}

TEST(MeshSurfacePicture, TouchingSheetsAreTwoAndNearSheetsStayApart) {
  const auto alpha = [](auto field, double isovalue) {
    return renderReference(
               surfaceScene({surfacesOf({isovalue}, {}, 0.5)}, meshOf(cubeOfTets(4, kStill, field))),
               along({0.3, 0.42, 3}, {0, 0, -1}))
        .rgba[3];
  };
  const auto valley = [](glm::dvec3 p) { return std::abs(p.z - 0.5); };
  EXPECT_NEAR(alpha(valley, 0), 0.75, 1e-12);
  EXPECT_NEAR(alpha(valley, 1e-12), 0.75, 1e-12);
  EXPECT_EQ(alpha(valley, -1e-12), 0);
  EXPECT_EQ(alpha([](glm::dvec3 p) { return -std::abs(p.z - 0.5); }, 0), 0) << "nothing is higher";
}

TEST(MeshSurfacePicture, ShadowsAndOcclusionSeeOtherPartsOfASurface) {
  // a sheet with light from behind: its neighbour takes half of it
  const auto mesh = meshOf(cubeOfTets(4, inside(0.03, 5), [](glm::dvec3 p) { return p.z; }));
  Vis vis = surfacesOf({0.3, 0.6}, {}, 0.5);
  vis.colormap.points = {{0, glm::dvec3(1)}};
  ReferenceScene scene = surfaceScene({vis}, mesh);
  Lighting& lighting = scene.visualization.lighting;
  lighting.Ka = 0, lighting.Kd = 1, lighting.Ks = 0, lighting.shadows = true;
  lighting.sources = {{LightType::Directional, {0, 0, -1}}};
  const Camera camera = along({0.5, 0.5, 3}, {0, 0, -1});
  EXPECT_NEAR(renderReference(scene, camera).rgba[0], 0.5 + 0.25 * 0.5, 1e-12);
  lighting.Ka = 1, lighting.Kd = 0, lighting.aoCount = 1, lighting.aoRadius = 0.5;
  ReferenceOptions how;
  how.aoHook = [](const AoRequest& request) { return std::vector{request.normal}; };
  EXPECT_NEAR(renderReference(scene, camera, how).rgba[0], 0.5 + 0.25 * 0.5, 1e-12);
}

TEST(MeshSurfacePicture, IsTheSameToTheBitAtAnyScaleByPowersOfTwo) {
  const auto picture = [](double scale) {
    MeshPiece piece = cubeOfTets(3, inside(0.04, 9), slope);
    for (glm::dvec3& p : piece.points) p *= scale;
    Camera camera = lookingDown();
    camera.viewpoint *= scale;
    ReferenceScene scene =
        surfaceScene({surfacesOf({0.3, 0.5}, {{{1, 0.3, 0.2}, 0.7 * scale}}, 0.6)}, meshOf(piece));
    scene.visualization.lighting.shadows = true;
    scene.visualization.lighting.sources = {{LightType::Directional, {-1, -2, -0.7}}};
    return renderReference(scene, camera).rgba;
  };
  EXPECT_EQ(picture(1), picture(0x1p100));
  EXPECT_EQ(picture(1), picture(0x1p-100));
}

}  // namespace
}  // namespace gxy::reference

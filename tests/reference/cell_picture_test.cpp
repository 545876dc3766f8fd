// SPDX-License-Identifier: Apache-2.0
// Pictures of hexahedra, wedges and pyramids, against closed forms and uniform volumes.
#include <gtest/gtest.h>

#include "tests/reference/cell_samples.h"

namespace gxy::reference {
namespace {

double ramp(glm::dvec3 p) { return 0.125 + 0.5 * p.x + 0.25 * p.y - 0.125 * p.z; }

Vis hazeOf(std::vector<OpacityPoint> opacities) {
  Vis vis;
  vis.volumeRendering = true;
  vis.opacitymap = {true, std::move(opacities)};
  vis.colormap.points = {{0, {0, 0.2, 1}}, {0.4, {0, 1, 0.5}}, {0.4, {1, 1, 0}}, {1, {1, 0, 0}}};
  return vis;
}

ReferenceScene sceneWith(Vis vis, ReferenceData data) {
  ReferenceScene scene;
  scene.visualization.operators = {std::move(vis)};
  scene.visualization.lighting = ambientOnly();
  scene.data = {std::move(data)};
  return scene;
}

ReferenceScene sceneWith(Vis vis, const MeshPiece& piece) {
  return sceneWith(std::move(vis), std::make_shared<const MeshField>(*meshOf(piece), std::nullopt));
}

Camera above(int size = 20) {
  Camera camera;
  camera.viewpoint = {2.2, 1.7, 3.1};
  camera.viewdirection = glm::dvec3(0.5) - camera.viewpoint;
  camera.dimensions = {size, size};
  camera.aov = 35;
  return camera;
}

double largestGap(const ReferencePicture& a, const ReferencePicture& b) {
  double largest = 0;
  for (size_t i = 0; i < a.rgba.size(); i++) largest = std::max(largest, std::abs(a.rgba[i] - b.rgba[i]));
  return largest;
}

/// Expects the same picture of a mesh and of a uniform volume.
void expectAlike(ReferenceScene ours, ReferenceScene theirs, double tolerance, const char* name) {
  ReferenceOptions how;
  how.tolerance = 1e-9;
  const ReferencePicture a = renderReference(ours, above(), how), b = renderReference(theirs, above(), how);
  EXPECT_LT(largestGap(a, b), tolerance) << name;
  EXPECT_GT(*std::max_element(b.rgba.begin(), b.rgba.end()), 0.3);
  for (size_t i = 0; i < a.depth.size(); i++) EXPECT_NEAR(a.depth[i], b.depth[i], 1e-11 * b.depth[i]) << name;
}

const std::vector<std::vector<OpacityPoint>> kHazes{
    {{0, 0}, {1, 6}}, {{0, 0}, {0.34, 0}, {0.35, 60}, {0.36, 0}}, {{0, 0}, {0.5, 0}, {0.5, 9}, {0.7, 0.1}}};

TEST(CellPicture, AConstantFieldIsThePictureOfOneBox) {
  const auto box = makeVolume(cube(2, 0, 1), kOne);
  for (const CellFilling& filling : kFillings)
    expectAlike(sceneWith(hazeOf({{0, 2}}), filling.make(4, inside(0.06, 9), kOne)),
                sceneWith(hazeOf({{0, 2}}), box), 1e-12, filling.name);
}

TEST(CellPicture, ALinearFieldIsThatOfTheUniformVolume) {
  const auto volume = makeVolume(cube(5, 0, 1), ramp);
  for (const CellFilling& filling : kFillings)
    for (const auto& map : kHazes)
      expectAlike(sceneWith(hazeOf(map), filling.make(4, inside(0.06, 9), ramp)),
                  sceneWith(hazeOf(map), volume), 1e-9, filling.name);
}

TEST(CellPicture, AnyFieldOnStraightHexahedraIsThatOfTheUniformVolume) {
  const auto field = [](glm::dvec3 p) { return 0.5 + 0.4 * std::sin(9 * p.x) * std::cos(7 * p.y + 2 * p.z); };
  const auto volume = makeVolume(cube(5, 0, 1), field);
  const MeshPiece mesh = test::cubeOfHexes(4, kStill, field);
  for (const auto& map : kHazes)
    expectAlike(sceneWith(hazeOf(map), mesh), sceneWith(hazeOf(map), volume), 1e-8, "haze");
  Vis vis = hazeOf(kHazes[0]);
  vis.isovalues = {0.3, 0.62};
  vis.slices = {{{1, 0.3, 0.2}, 0.7}};
  vis.clipPlanes = {{{1, 0.25, -0.5}, 0.125}};
  vis.opacity = 0.5;
  expectAlike(sceneWith(vis, mesh), sceneWith(vis, volume), 1e-8, "surfaces in haze");
  vis.volumeRendering = false;
  expectAlike(sceneWith(vis, mesh), sceneWith(vis, volume), 1e-8, "surfaces");
}

TEST(CellPicture, SurfacesOfALinearFieldAreThoseOfTheUniformVolumeInAnyLight) {
  Lighting lighting;
  lighting.Ka = 0.3, lighting.Kd = 0.6, lighting.Ks = 0.2, lighting.shadows = true;
  lighting.sources = {{LightType::Directional, {-1, -2, -0.7}}, {LightType::Point, {0.1, 0.5, 2}}};
  lighting.aoCount = 2, lighting.aoRadius = 0.6;
  Vis vis = hazeOf({{0, 0}, {1, 3}});
  vis.isovalues = {0.3, 0.5};
  vis.slices = {{{1, 0.3, 0.2}, 0.7}};
  vis.opacity = 0.6;
  vis.volumeRendering = false;
  const auto volume = makeVolume(cube(5, 0, 1), ramp);
  for (const CellFilling& filling : kFillings)
    for (const bool twoSided : {true, false}) {
      vis.twoSided = twoSided;
      ReferenceScene ours = sceneWith(vis, filling.make(4, inside(0.06, 9), ramp)),
                     theirs = sceneWith(vis, volume);
      ours.visualization.lighting = theirs.visualization.lighting = lighting;
      expectAlike(ours, theirs, 1e-8, filling.name);
    }
}

TEST(CellPicture, TheEyeInACellSeesFromThereOn) {
  for (const CellFilling& filling : kFillings) {
    const MeshPiece piece = filling.make(3, inside(0.04, 9), kOne);
    for (const glm::dvec3 eye :
         {glm::dvec3(0.4, 0.45, 0.57), glm::dvec3(0.5, 0.5, 1.0 / 3), glm::dvec3(0.1, 0.2, 1)})
      EXPECT_NEAR(renderReference(sceneWith(hazeOf({{0, 2}}), piece), along(eye, {0, 0, -1})).rgba[3],
                  -std::expm1(-2 * eye.z), 1e-12);
  }
}

TEST(CellPicture, ASurfaceThatARayPassesTwiceInOneCellIsSeenTwice) {
  const MeshPiece piece = test::cubeOfHexes(1, kStill, [](glm::dvec3 p) { return p.x * (1 - p.y); });
  Vis vis;
  vis.isovalues = {0.2};
  vis.opacity = 0.5;
  vis.colormap.points = {{0, glm::dvec3(1)}};
  const auto alpha = [&](const glm::dvec3& from, const glm::dvec3& to) {
    return renderReference(sceneWith(vis, piece), along(from, to - from)).rgba[3];
  };
  EXPECT_NEAR(alpha({-1, -1, 0.3}, {2, 2, 0.5}), 0.75, 1e-12) << "s (1 - s) is 0.2 twice";
  EXPECT_NEAR(alpha({-1, 0.3, 0.3}, {2, 0.3, 0.5}), 0.5, 1e-12);
  EXPECT_NEAR(alpha({-0.5, 0.5, 0.3}, {0.5, 1.5, 0.3}), 0, 1e-12);
}

TEST(CellPicture, CellsOfAllTypesAreCountedInTheTypicalLength) {
  const MeshPiece piece = test::cubeOfAllCells(3, inside(0.04, 9), kOne);
  Vis vis = hazeOf({{0, 0.05}});
  vis.opacitymap.extinction = false;
  EXPECT_NEAR(renderReference(sceneWith(vis, piece), along({0.3, 0.4, 3}, {0, 0, -1})).rgba[3],
              1 - std::pow(0.95, std::cbrt(double(piece.cells.size()))), 1e-12);
}

TEST(CellPicture, IsTheSameToTheBitAtAnyScaleByPowersOfTwo) {
  const auto picture = [](double scale) {
    MeshPiece piece =
        test::cubeOfAllCells(2, inside(0.06, 9), [](glm::dvec3 p) { return p.x * p.y + 0.3 * p.z; });
    for (glm::dvec3& p : piece.points) p *= scale;
    Camera camera = above(12);
    camera.viewpoint *= scale;
    Vis vis = hazeOf({{0, 0}, {1, 6 / scale}});
    vis.isovalues = {0.3, 0.5};
    vis.slices = {{{1, 0.3, 0.2}, 0.7 * scale}};
    vis.opacity = 0.6;
    ReferenceScene scene = sceneWith(vis, piece);
    scene.visualization.lighting.shadows = true;
    scene.visualization.lighting.sources = {{LightType::Directional, {-1, -2, -0.7}}};
    return renderReference(scene, camera).rgba;
  };
  EXPECT_EQ(picture(1), picture(0x1p60));
  EXPECT_EQ(picture(1), picture(0x1p-60));
}

}  // namespace
}  // namespace gxy::reference

// SPDX-License-Identifier: Apache-2.0
// Pictures of unstructured volumes against closed forms, uniform volumes and fine sampling.
#include <gtest/gtest.h>

#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "tests/reference/mesh_samples.h"

namespace gxy::reference {
namespace {

/// Exact in float at all points that inside() makes.
double linear(glm::dvec3 p) { return 0.125 + 0.5 * p.x + 0.25 * p.y - 0.125 * p.z; }

Vis rendered(std::vector<OpacityPoint> opacities, bool extinction = true) {
  Vis vis;
  vis.volumeRendering = true;
  vis.opacitymap = {extinction, std::move(opacities)};
  vis.colormap.points = {{0, {0, 0.2, 1}}, {0.4, {0, 1, 0.5}}, {0.4, {1, 1, 0}}, {1, {1, 0, 0}}};
  return vis;
}

const std::vector<std::vector<OpacityPoint>> kMaps{
    {{0, 0}, {1, 6}},
    {{0, 0}, {0.34, 0}, {0.35, 60}, {0.36, 0}, {0.61, 0}, {0.62, 60}, {0.63, 0}},
    {{0, 0}, {0.5, 0}, {0.5, 9}, {0.7, 9}, {0.7, 0.1}}};

ReferenceScene sceneOf(Vis vis, ReferenceData data) {
  ReferenceScene scene;
  scene.visualization.operators = {std::move(vis)};
  scene.visualization.lighting = ambientOnly();
  scene.data = {std::move(data)};
  return scene;
}

ReferenceScene sceneOf(Vis vis, const std::shared_ptr<Mesh>& mesh) {
  return sceneOf(std::move(vis), std::make_shared<const MeshField>(*mesh, std::nullopt));
}

Camera fromAside(int size = 24) {
  Camera camera;
  camera.viewpoint = {2.2, 1.7, 3.1};
  camera.viewdirection = glm::dvec3(0.5) - camera.viewpoint;
  camera.dimensions = {size, size};
  camera.aov = 35;
  return camera;
}

double largestDifference(const ReferencePicture& a, const ReferencePicture& b) {
  double largest = 0;
  for (size_t i = 0; i < a.rgba.size(); i++) largest = std::max(largest, std::abs(a.rgba[i] - b.rgba[i]));
  return largest;
}

TEST(MeshPicture, ALinearFieldIsThePictureOfTheUniformVolume) {
  const auto mesh = meshOf(cubeOfTets(4, inside(0.04, 9), linear));
  const auto volume = makeVolume(cube(5, 0, 1), linear);
  ReferenceOptions how;
  how.tolerance = 1e-9;
  for (const auto& map : kMaps) {
    Vis vis = rendered(map);
    vis.clipPlanes = {{{1, 0.25, -0.5}, 0.125}};
    const ReferencePicture ours = renderReference(sceneOf(vis, mesh), fromAside(), how),
                           theirs = renderReference(sceneOf(vis, volume), fromAside(), how);
    EXPECT_LT(largestDifference(ours, theirs), 1e-9);
    EXPECT_GT(*std::max_element(theirs.rgba.begin(), theirs.rgba.end()), 0.5);
  }
  Vis vis = rendered({{0, 0}, {0.3, 0.5}, {0.8, 0.02}}, false);
  vis.referenceLength = 0.2;
  EXPECT_LT(largestDifference(renderReference(sceneOf(vis, mesh), fromAside(), how),
                              renderReference(sceneOf(vis, volume), fromAside(), how)),
            1e-9);
}

TEST(MeshPicture, OpacitiesCountTypicalLengths) {
  const auto mesh = meshOf(cubeOfTets(3, inside(0.04, 9), kOne));
  const Camera camera = along({0.3, 0.4, 3}, {0, 0, -1});
  const ReferencePicture picture = renderReference(sceneOf(rendered({{0, 0.05}}, false), mesh), camera);
  EXPECT_NEAR(picture.rgba[3], 1 - std::pow(0.95, std::cbrt(162.0)), 1e-12);
}

TEST(MeshPicture, TheEyeInACellSeesFromThereOn) {
  const auto mesh = meshOf(cubeOfTets(3, inside(0.04, 9), kOne));
  for (const glm::dvec3 eye :
       {glm::dvec3(0.4, 0.45, 0.57), glm::dvec3(0.5, 0.5, 1.0 / 3), glm::dvec3(0, 0, 1)})
    EXPECT_NEAR(renderReference(sceneOf(rendered({{0, 2}}), mesh), along(eye, {0, 0, -1})).rgba[3],
                -std::expm1(-2 * eye.z), 1e-12);
}

TEST(MeshPicture, ASurfaceInsideCutsTheIntegral) {
  ReferenceScene scene = sceneOf(rendered({{0, 2}}), meshOf(cubeOfTets(3, inside(0.04, 9), kOne)));
  auto ball = std::make_shared<Geometry>();
  ball->kind = GeometryKind::Particles;
  ball->blocks[0].points = {{0.5, 0.5, 0.5}};
  Vis spheres = plain(VisType::Particles, {0, 1, 0});
  spheres.radius0 = 0.25;
  spheres.opacity = 0.5;
  scene.visualization.operators[0].colormap.points = {{0, {1, 0, 0}}};
  scene.visualization.operators.push_back(spheres);
  scene.data.push_back(ball);
  const ReferencePicture picture = renderReference(scene, along({0.5, 0.5, 3}, {0, 0, -1}));
  const double front = std::exp(-0.5), middle = std::exp(-1.0);
  EXPECT_NEAR(picture.rgba[1], 0.5 * front + 0.25 * front * middle, 1e-12);
  EXPECT_NEAR(picture.rgba[3], 1 - 0.25 * std::exp(-2.0), 1e-12);
  EXPECT_NEAR(picture.depth[0], 2.25, 1e-12);
}

TEST(MeshPicture, AMeshCastsSoftShadows) {
  // a layer of haze over a plate that the light shines on from above
  ReferenceScene scene = sceneOf(rendered({{0, 0.7}}), meshOf(cubeOfTets(2, kStill, kOne)));
  auto plate = std::make_shared<Geometry>();
  plate->kind = GeometryKind::Triangles;
  plate->blocks[0].points = {{-5, -5, -0.5}, {5, -5, -0.5}, {0, 9, -0.5}};
  plate->blocks[0].triangles = {{0, 1, 2}};
  scene.visualization.operators.push_back(plain(VisType::Triangles, glm::dvec3(1)));
  scene.data.push_back(plate);
  Lighting& lighting = scene.visualization.lighting;
  lighting.Ka = 0, lighting.Kd = 1, lighting.Ks = 0, lighting.shadows = true;
  lighting.sources = {{LightType::Directional, {0, 0, -1}}};
  const Camera camera = along({-2.6, 0.3, 2.1}, glm::dvec3(0.4, 0.3, -0.5) - glm::dvec3(-2.6, 0.3, 2.1));
  Ray seen{camera.viewpoint, glm::normalize(camera.viewdirection)};
  const double before =
      lengthOf(MeshField(*meshOf(cubeOfTets(2, kStill, kOne)), std::nullopt).along(seen, {}));
  const double red = renderReference(scene, camera).rgba[0];
  scene.visualization.operators[0].colormap.points = {{0, glm::dvec3(0)}};  // the light of the haze itself
  EXPECT_NEAR(renderReference(scene, camera).rgba[2], std::exp(-0.7) * std::exp(-0.7 * before), 1e-9);
  EXPECT_NE(red, 0);
}

TEST(MeshPicture, AMeshAndAUniformVolumeAddUp) {
  ReferenceScene scene = sceneOf(rendered({{0, 0.7}}), meshOf(cubeOfTets(3, inside(0.04, 9), kOne)));
  scene.visualization.operators.push_back(rendered({{0, 1.1}}));
  scene.data.push_back(
      makeVolume({{0.25, 0.25, 0.5}, glm::dvec3(0.25), {3, 3, 5}}, [](glm::dvec3) { return 1; }));
  EXPECT_NEAR(renderReference(scene, along({0.5, 0.5, 3}, {0, 0, -1})).rgba[3], -std::expm1(-0.7 - 1.1),
              1e-12);
}

TEST(MeshPicture, IsTheSameToTheBitAtAnyScaleByPowersOfTwo) {
  const auto picture = [](double scale) {
    MeshPiece piece = cubeOfTets(3, inside(0.04, 9), linear);
    for (glm::dvec3& p : piece.points) p *= scale;
    Camera camera = fromAside();
    camera.viewpoint *= scale;
    return renderReference(sceneOf(rendered({{0, 0}, {1, 0.4}}, false), meshOf(piece)), camera).rgba;
  };
  EXPECT_EQ(picture(1), picture(0x1p100));
  EXPECT_EQ(picture(1), picture(0x1p-100));
}

/// Finds values by barycentric coordinates, in all cells one after the other.
class EveryCell {
 public:
  explicit EveryCell(const MeshPiece& piece) {
    const auto& cells = piece.cells.points[kTets];
    for (size_t i = 0; i < cells.size(); i += 4) {
      const auto at = [&](size_t k) { return piece.points[cells[i + k]]; };
      const auto value = [&](size_t k) { return double(piece.values[cells[i + k]]); };
      const glm::dmat3 edges(at(1) - at(0), at(2) - at(0), at(3) - at(0));
      const glm::dvec3 rises(value(1) - value(0), value(2) - value(0), value(3) - value(0));
      cells_.push_back({glm::inverse(edges), at(0), rises, value(0)});
    }
  }
  /// In the first cell that holds the place; NaN outside.
  double operator()(glm::dvec3 p) const {
    for (const Cell& cell : cells_) {
      const glm::dvec3 w = cell.inverse * (p - cell.origin);
      if (std::min({w.x, w.y, w.z, 1 - w.x - w.y - w.z}) >= -1e-12)
        return cell.value + glm::dot(w, cell.rises);
    }
    return std::numeric_limits<double>::quiet_NaN();
  }

 private:
  struct Cell {
    glm::dmat3 inverse;
    glm::dvec3 origin, rises;
    double value;
  };
  std::vector<Cell> cells_;
};

TEST(MeshPicture, RandomValuesMatchFineSampling) {
  Uniform random(21);
  MeshPiece piece = cubeOfTets(2, inside(0.09, 5), [&](glm::dvec3) { return random(); });
  piece = without(piece, {glm::dvec3(0.6, -1, 0.6), glm::dvec3(2)});
  const auto mesh = meshOf(piece);
  const MeshField field(*mesh, std::nullopt);
  const EveryCell valueAt(piece);
  for (const auto& map : kMaps) {
    const Vis vis = rendered(map);
    const Transfer transfer(vis, 1);
    const VolumeTerm term{&field, &transfer};
    for (int i = 0; i < 4; i++) {
      const Ray ray =
          towards(glm::dvec3(0.5) + random.inCube(i < 2 ? 0.4 : 1.2), glm::dvec3(0.5) + random.inCube(0.3));
      const RayIntegral found = integrateRay({&term, 1}, ray);
      RayIntegral sum;
      constexpr int kSteps = 400000;
      for (int k = 0; k < kSteps; k++) {
        const double dt = 4.0 / kSteps, value = valueAt(ray.at((k + 0.5) * dt));
        if (std::isnan(value)) continue;
        const double opacity = -std::expm1(-transfer.extinction(value) * dt);
        sum.colour += sum.transmittance * opacity * transfer.colour(value);
        sum.transmittance *= 1 - opacity;
      }
      EXPECT_NEAR(found.transmittance, sum.transmittance, 1e-4);
      for (int c = 0; c < 3; c++) EXPECT_NEAR(found.colour[c], sum.colour[c], 1e-4);
    }
  }
}

}  // namespace
}  // namespace gxy::reference

// SPDX-License-Identifier: Apache-2.0
// Translucent surfaces that coincide count each, in one partition and where faces of partitions cut them; and what one mesh or
// one tube is made of does not show: rays run through its vertices, edges and joints exactly.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/backends.h"
#include "tests/support/frames.h"

namespace gxy::test {
namespace {

constexpr int kSize = 16;               // pixels of a side
constexpr double kPixel = 2.0 / kSize;  // the middles of pixels are at (i + 1/2) kPixel

/// Parallel rays along z, towards -z (`forward`) or +z, over [-1, 1]^2.
TestScene sceneAlong(bool forward) {
  TestScene scene;
  scene.name = "coincident";
  scene.domain = {glm::dvec3(-2), glm::dvec3(2)};
  scene.camera.viewpoint = {0, 0, forward ? 5 : -5};
  scene.camera.viewdirection = {0, 0, forward ? -1 : 1};
  scene.camera.viewup = {0, 1, 0};
  scene.camera.aov = 0;
  scene.camera.height = 2;
  scene.camera.dimensions = {kSize, kSize};
  scene.settings.background = glm::dvec4(0);
  scene.visualization.lighting.sources.clear();
  scene.visualization.lighting.Ka = 1;
  return scene;
}

Vis& add(TestScene& scene, VisType type, double opacity) {
  Vis& vis = scene.visualization.operators.emplace_back();
  vis.type = type;
  vis.dataset = "data";
  vis.opacity = opacity;
  vis.colormap.points = {{0, {1, 1, 1}}};
  vis.volumeRendering = false;
  return vis;
}

Vis& addGeometry(TestScene& scene, VisType type, WholeGeometry geometry, double opacity = 0.5) {
  geometry.block.ids.clear();
  const size_t n = geometry.kind == GeometryKind::Particles   ? geometry.block.points.size()
                   : geometry.kind == GeometryKind::PathLines ? geometry.block.segments.size()
                                                              : geometry.block.triangles.size();
  for (size_t i = 0; i < n; i++) geometry.block.ids.push_back(i);
  scene.data.emplace_back(std::make_shared<const WholeGeometry>(std::move(geometry)));
  return add(scene, type, opacity);
}

/// A mesh wider than the view, of squares of `step` pixels, whose vertices are in the middles of pixels, at heights z(i, j).
template <class Height>
WholeGeometry meshOf(int step, Height z) {
  WholeGeometry mesh;
  mesh.kind = GeometryKind::Triangles;
  const int n = kSize / step + 3;
  for (int j = 0; j < n; j++)
    for (int i = 0; i < n; i++)
      mesh.block.points.push_back(
          {((i - 1) * step + 0.5) * kPixel - 1, ((j - 1) * step + 0.5) * kPixel - 1, z(i, j)});
  mesh.block.values.assign(mesh.block.points.size(), 0.f);
  for (uint32_t j = 0; j + 1 < uint32_t(n); j++)
    for (uint32_t i = 0; i + 1 < uint32_t(n); i++) {
      const uint32_t k = j * uint32_t(n) + i, l = k + uint32_t(n);
      if ((i + j) % 2 == 0)
        mesh.block.triangles.insert(mesh.block.triangles.end(), {{k, k + 1, l + 1}, {l + 1, l, k}});
      else
        mesh.block.triangles.insert(mesh.block.triangles.end(), {{k + 1, l + 1, l}, {k, k + 1, l}});
    }
  return mesh;
}

WholeGeometry flat(double z) {
  return meshOf(2, [=](int, int) { return z; });
}
WholeGeometry hilly(int step) {
  return meshOf(step, [](int i, int j) { return (3 * i + 5 * j) % 7 / 14.0 - 0.2; });
}

/// Each triangle so many times, with its corners turned.
WholeGeometry times(WholeGeometry mesh, int n) {
  const auto once = mesh.block.triangles;
  for (int k = 1; k < n; k++)
    for (const auto& t : once)
      mesh.block.triangles.push_back({t[size_t(k) % 3], t[size_t(k + 1) % 3], t[size_t(k + 2) % 3]});
  return mesh;
}

std::shared_ptr<const WholeVolume> ramp() {
  Grid grid;
  grid.points = {21, 21, 21};
  grid.origin = glm::dvec3(-2);
  grid.spacing = glm::dvec3(0.2);
  static const auto volume = std::make_shared<const WholeVolume>(
      sampled(grid, [](glm::dvec3 p) { return p.z + 0.15 * std::sin(3 * p.x) * std::cos(2 * p.y); }));
  return volume;
}

Vis& addVolume(TestScene& scene) {
  scene.data.emplace_back(ramp());
  return add(scene, VisType::Volume, 0.5);
}

/// The opacity of each pixel, the same however the scene is cut.
std::vector<float> opacities(const TestScene& scene) {
  const Picture whole = wholeOnEmbree(scene);
  for (const Cut& cut : {test::whole(scene.domain), lattice(scene.domain, {2, 2, 2}, 3),
                         octants(scene.domain, {0.5 * kPixel, 0.5 * kPixel, 0.1}, 8)})
    EXPECT_EQ(difference(whole, render(scene, cut)), "") << cut.name;
  std::vector<float> seen;
  for (size_t i = 3; i < whole.rgba.size(); i += 4) seen.push_back(whole.rgba[i]);
  return seen;
}

void expectEverywhere(const TestScene& scene, float opacity, const std::string& what = {}) {
  const std::vector<float> seen = opacities(scene);
  for (size_t i = 0; i < seen.size(); i++) ASSERT_EQ(seen[i], opacity) << what << ", pixel " << i;
}

TEST(Coincident, EdgesAndVerticesOfAMeshAreNotSeen) {
  for (const bool forward : {false, true})
    for (int step : {1, 2, 4}) {
      TestScene scene = sceneAlong(forward);
      addGeometry(scene, VisType::Triangles, hilly(step));
      expectEverywhere(scene, 0.5f, std::to_string(step));
    }
}

// A double pyramid, of which edges and silhouette run through the middles of pixels: rays meet both sides or none.
TEST(Coincident, ClosedMeshesHaveTwoSidesEverywhere) {
  for (const bool forward : {false, true}) {
    WholeGeometry mesh;
    mesh.kind = GeometryKind::Triangles;
    const double r = 6 * kPixel, m = 0.5 * kPixel;
    mesh.block.points = {{m + r, m, 0}, {m, m + r, 0}, {m - r, m, 0},
                         {m, m - r, 0}, {m, m, 0.7},   {m, m, -0.6}};
    for (uint32_t i = 0; i < 4; i++) {
      mesh.block.triangles.push_back({i, (i + 1) % 4, 4});
      mesh.block.triangles.push_back({(i + 1) % 4, i, 5});
    }
    TestScene scene = sceneAlong(forward);
    addGeometry(scene, VisType::Triangles, mesh);
    int both = 0;
    for (float a : opacities(scene)) {
      EXPECT_TRUE(a == 0 || a == 0.75f) << a;
      both += a == 0.75f;
    }
    EXPECT_GE(both, 61);  // those inside
    EXPECT_LE(both, 85);  // and on the silhouette
  }
}

TEST(Coincident, TrianglesOfOneOperatorCountEach) {
  for (const WholeGeometry& mesh : {flat(0.1), hilly(2), hilly(4)})
    for (int n : {2, 3}) {
      TestScene scene = sceneAlong(true);
      addGeometry(scene, VisType::Triangles, times(mesh, n));
      expectEverywhere(scene, n == 2 ? 0.75f : 0.875f);
    }
}

TEST(Coincident, TrianglesOfSeveralOperatorsCountEach) {
  for (const WholeGeometry& mesh : {flat(0.1), hilly(2)}) {
    TestScene scene = sceneAlong(true);
    for (int n = 0; n < 3; n++) addGeometry(scene, VisType::Triangles, mesh);
    expectEverywhere(scene, 0.875f);
  }
}

TEST(Coincident, SlicesCountEach) {
  for (const Plane& plane : {Plane{{0, 0, 1}, 0.1}, Plane{{0.3, 0.2, 1}, 0.05}})
    for (const bool apart : {false, true}) {
      TestScene scene = sceneAlong(true);
      addVolume(scene).slices = {plane};
      if (apart)
        addVolume(scene).slices = {plane};
      else
        scene.visualization.operators[0].slices.push_back(plane);
      expectEverywhere(scene, 0.75f);
      scene.visualization.operators[0].slices.push_back(plane);
      expectEverywhere(scene, 0.875f);
    }
}

TEST(Coincident, SlicesAndTrianglesCountEach) {
  for (const bool triangleFirst : {false, true}) {
    TestScene scene = sceneAlong(true);
    if (triangleFirst) addGeometry(scene, VisType::Triangles, flat(0.1));
    addVolume(scene).slices = {{{0, 0, 1}, 0.1}};
    if (!triangleFirst) addGeometry(scene, VisType::Triangles, flat(0.1));
    expectEverywhere(scene, 0.75f);
    addGeometry(scene, VisType::Triangles, times(flat(0.1), 2));
    expectEverywhere(scene, 0.9375f);
  }
}

TEST(Coincident, IsosurfacesOfSeveralOperatorsCountEach) {
  for (const bool forward : {false, true}) {
    TestScene scene = sceneAlong(forward);
    addVolume(scene).isovalues = {0.1};
    expectEverywhere(scene, 0.5f);
    addVolume(scene).isovalues = {0.1};
    expectEverywhere(scene, 0.75f);
    addVolume(scene).isovalues = {0.1, 0.3};
    expectEverywhere(scene, 0.9375f);
  }
}

// Where the field is 0 at z = 0, on the points of the grid.
TEST(Coincident, IsosurfacesAndSlicesCountEach) {
  WholeVolume plain = *ramp();
  plain = sampled(plain.grid, [](glm::dvec3 p) { return p.z; });
  for (const bool apart : {false, true}) {
    TestScene scene = sceneAlong(true);
    addVolume(scene).isovalues = {0};
    if (apart) addVolume(scene);
    scene.visualization.operators.back().slices = {{{0, 0, 1}, 0}};
    for (auto& data : scene.data) data = std::make_shared<const WholeVolume>(plain);
    addGeometry(scene, VisType::Triangles, flat(0));
    expectEverywhere(scene, 0.875f);
  }
}

// The front and the back of each.
TEST(Coincident, SpheresCountEach) {
  for (const bool apart : {false, true}) {
    TestScene scene = sceneAlong(true);
    WholeGeometry balls;
    balls.block.points.assign(apart ? 1 : 3, {0.1, 0.2, 0.3});
    for (int n = 0; n < (apart ? 3 : 1); n++) addGeometry(scene, VisType::Particles, balls).radius0 = 0.55;
    int met = 0;
    for (float a : opacities(scene)) {
      EXPECT_TRUE(a == 0 || a == 1 - 0.015625f) << a;
      met += a > 0;
    }
    EXPECT_NEAR(met, 3.14 * std::pow(0.55 / kPixel, 2), 6);
  }
}

/// Lines along x, one where the other is, with joints in the middles of pixels.
WholeGeometry linesOf(int copies) {
  WholeGeometry line;
  line.kind = GeometryKind::PathLines;
  for (int n = 0; n < copies; n++) {
    const auto first = uint32_t(line.block.points.size());
    for (uint32_t i = 0; i < 9; i++) {
      line.block.points.push_back({(2.0 * i - 7.5) * kPixel, -0.5 * kPixel, 0.05});
      if (i == 8) continue;
      const uint32_t p = first + i;
      line.block.segments.push_back({p, p + 1});
      line.block.neighbours.push_back({i > 0 ? p - 1 : p, i < 7 ? p + 2 : p + 1});
    }
  }
  return line;
}

TEST(Coincident, JointsOfATubeAreNotSeen) {
  TestScene scene = sceneAlong(true);
  addGeometry(scene, VisType::PathLines, linesOf(1)).radius0 = 2.2 * kPixel;
  int met = 0;
  for (float a : opacities(scene)) {
    EXPECT_TRUE(a == 0 || a == 0.75f) << a;
    met += a > 0;
  }
  EXPECT_GE(met, 70);
}

TEST(Coincident, TubesCountEach) {
  for (const bool apart : {false, true}) {
    TestScene scene = sceneAlong(true);
    for (int n = 0; n < (apart ? 2 : 1); n++)
      addGeometry(scene, VisType::PathLines, linesOf(apart ? 1 : 2)).radius0 = 2.2 * kPixel;
    int met = 0;
    for (float a : opacities(scene)) {
      EXPECT_TRUE(a == 0 || a == 0.9375f) << a;
      met += a > 0;
    }
    EXPECT_GE(met, 70);
  }
}

// A white floor under two black sheets, in light from above, which passes both on its way down and back.
TEST(Coincident, ShadowsAreOfEach) {
  TestScene scene = sceneAlong(true);
  scene.visualization.lighting.Ka = 0;
  scene.visualization.lighting.Kd = 1;
  scene.visualization.lighting.Ks = 0;
  scene.visualization.lighting.shadows = true;
  scene.visualization.lighting.sources = {{LightType::Directional, {0, 0, -1}}};
  addGeometry(scene, VisType::Triangles, flat(-0.5), 1);
  for (int n = 0; n < 2; n++)
    addGeometry(scene, VisType::Triangles, hilly(2)).colormap.points = {{0, {0, 0, 0}}};
  expectEverywhere(scene, 1);
  const Picture picture = wholeOnEmbree(scene);
  for (size_t i = 0; i < picture.rgba.size(); i += 4) ASSERT_NEAR(picture.rgba[i], 0.0625, 1e-6);
}

}  // namespace
}  // namespace gxy::test

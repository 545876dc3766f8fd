// SPDX-License-Identifier: Apache-2.0
#include "tests/support/scenes.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "core/comm/random.h"

namespace gxy::test {

namespace {

using std::numbers::pi;

double uniform(Random& random) { return double(random.next() >> 11) * 0x1p-53; }

Grid fillingGrid() {
  const Box d = sceneDomain();
  Grid grid;
  grid.points = {33, 28, 38};
  grid.origin = d.lo;
  for (int a = 0; a < 3; a++) grid.spacing[a] = (d.hi[a] - d.lo[a]) / double(grid.points[a] - 1);
  return grid;
}

double smooth(glm::dvec3 p) {
  return 0.5 + 0.25 * std::sin(3.1 * p.x + 0.3) * std::cos(2.3 * p.y) + 0.25 * std::sin(2.7 * p.z + p.x);
}

std::shared_ptr<const WholeVolume> smoothVolume() {
  static const auto volume = std::make_shared<const WholeVolume>(sampled(fillingGrid(), smooth));
  return volume;
}

std::shared_ptr<const WholeVolume> secondVolume() {
  Grid grid;
  grid.points = {25, 27, 24};
  grid.origin = {-0.31, -0.52, 0.13};
  grid.spacing = {0.041, 0.037, 0.05};
  static const auto volume = std::make_shared<const WholeVolume>(sampledAsBytes(grid, [](glm::dvec3 p) {
    return std::exp(-6 * glm::dot(p - glm::dvec3(0.2, 0, 0.7), p - glm::dvec3(0.2, 0, 0.7)));
  }));
  return volume;
}

ColorMap colors() {
  return {{{0, {0.1, 0.2, 0.9}}, {0.4, {0.2, 0.9, 0.3}}, {0.7, {0.9, 0.8, 0.2}}, {1, {0.9, 0.1, 0.1}}}};
}

Vis& addOperator(TestScene& scene, VisType type, double opacity) {
  Vis& vis = scene.visualization.operators.emplace_back();
  vis.type = type;
  vis.dataset = "data";
  vis.colormap = colors();
  vis.opacity = opacity;
  return vis;
}

Vis& addVolume(TestScene& scene, std::shared_ptr<const WholeVolume> volume, double opacity) {
  scene.data.emplace_back(std::move(volume));
  return addOperator(scene, VisType::Volume, opacity);
}

Vis& addGeometry(TestScene& scene, WholeGeometry geometry, VisType type, double opacity) {
  scene.data.emplace_back(std::make_shared<const WholeGeometry>(std::move(geometry)));
  return addOperator(scene, type, opacity);
}

glm::dvec3 inDomain(glm::dvec3 f) {
  const Box d = sceneDomain();
  return d.lo + f * (d.hi - d.lo);
}

}  // namespace

Box sceneDomain() { return {{-0.9, -0.75, -0.4}, {1.1, 0.8, 1.3}}; }

Camera cameraOutside(const Box& domain, glm::ivec2 size) {
  Camera camera;
  const glm::dvec3 centre = 0.5 * (domain.lo + domain.hi);
  camera.viewpoint = centre + glm::dvec3(1.9, 1.4, 3.1);
  camera.viewdirection = centre - camera.viewpoint;
  camera.aov = 34;
  camera.dimensions = size;
  return camera;
}

TestScene emptyScene(std::string name, glm::ivec2 size) {
  TestScene scene;
  scene.name = std::move(name);
  scene.domain = sceneDomain();
  scene.camera = cameraOutside(scene.domain, size);
  scene.settings.background = {0.1, 0.1, 0.2, 1};
  scene.visualization.lighting.sources = {{LightType::Directional, {-0.4, -1, -0.6}}};
  return scene;
}

void addSmoothVolume(TestScene& scene) {
  Vis& vis = addVolume(scene, smoothVolume(), 1);
  vis.volumeRendering = true;
  vis.opacitymap = {false, {{0, 0}, {0.3, 0.02}, {1, 0.3}}};
}

void addSpikyVolume(TestScene& scene) {
  Vis& vis = addVolume(scene, smoothVolume(), 1);
  vis.volumeRendering = true;
  vis.opacitymap = {
      false, {{0, 0}, {0.42, 0}, {0.43, 0.9}, {0.44, 0}, {0.7, 0}, {0.7, 0.2}, {0.8, 0.2}, {0.8, 0}, {1, 0}}};
}

void addSecondVolume(TestScene& scene) {
  Vis& vis = addVolume(scene, secondVolume(), 1);
  vis.volumeRendering = true;
  vis.dataRange = std::array<double, 2>{0, 255};
  vis.opacitymap = {false, {{0, 0}, {0.2, 0}, {0.6, 0.25}, {0.61, 0}, {1, 0.4}}};
}

void addIsosurfaces(TestScene& scene, double opacity) {
  addVolume(scene, smoothVolume(), opacity).isovalues = {0.35, 0.62};
}

void addSlices(TestScene& scene, double opacity) {
  addVolume(scene, smoothVolume(), opacity).slices = {{{1, 0, 0}, 0.1}, {{0.3, 1, 0.5}, 0.2}};
}

void addParticles(TestScene& scene, double opacity) {
  WholeGeometry g;
  Random random(7);
  for (int i = 0; i < 90; i++) {
    g.block.points.push_back(inDomain({uniform(random), uniform(random), uniform(random)}));
    g.block.values.push_back(float(uniform(random)));
    g.block.ids.push_back(uint64_t(i));
  }
  Vis& vis = addGeometry(scene, std::move(g), VisType::Particles, opacity);
  vis.radius0 = 0.02, vis.radius1 = 0.13, vis.value0 = 0, vis.value1 = 1;
}

void addTubes(TestScene& scene, double opacity) {
  WholeGeometry g;
  g.kind = GeometryKind::PathLines;
  for (int line = 0; line < 4; line++) {
    const uint32_t first = uint32_t(g.block.points.size()), last = first + 23;
    for (uint32_t i = first; i <= last; i++) {
      const double s = double(i - first) / 23, a = 9 * s + line * pi / 2;
      g.block.points.push_back(inDomain({0.5 + 0.4 * std::cos(a), s, 0.5 + 0.4 * std::sin(a)}));
      g.block.values.push_back(float(0.5 + 0.5 * std::sin(17 * s)));
      if (i == last) continue;
      g.block.ids.push_back(g.block.ids.size());
      g.block.segments.push_back({i, i + 1});
      g.block.neighbours.push_back({i > first ? i - 1 : i, i + 1 < last ? i + 2 : i + 1});
    }
  }
  Vis& vis = addGeometry(scene, std::move(g), VisType::PathLines, opacity);
  vis.radius0 = 0.02, vis.radius1 = 0.06, vis.value0 = 0, vis.value1 = 1;
}

void addMesh(TestScene& scene, double opacity) {
  constexpr uint32_t kRings = 14, kSides = 22;
  WholeGeometry g;
  g.kind = GeometryKind::Triangles;
  for (uint32_t i = 0; i <= kRings; i++)
    for (uint32_t j = 0; j < kSides; j++) {
      const double a = pi * (i + 0.05) / (kRings + 0.1), b = 2 * pi * j / kSides;
      const glm::dvec3 n(std::sin(a) * std::cos(b), std::cos(a), std::sin(a) * std::sin(b));
      g.block.points.push_back(glm::dvec3(0.05, 0.05, 0.4) + 0.55 * n);
      g.block.normals.push_back(glm::vec3(n));
      g.block.values.push_back(float(double(i) / kRings));
    }
  for (uint32_t i = 0; i < kRings; i++)
    for (uint32_t j = 0; j < kSides; j++) {
      const uint32_t a = i * kSides + j, b = i * kSides + (j + 1) % kSides, c = a + kSides, d = b + kSides;
      g.block.triangles.push_back({a, b, c});
      g.block.triangles.push_back({b, d, c});
    }
  for (size_t t = 0; t < g.block.triangles.size(); t++) g.block.ids.push_back(t);
  addGeometry(scene, std::move(g), VisType::Triangles, opacity);
}

void addColors(TestScene& scene) {
  for (auto& data : scene.data) {
    const auto* whole = std::get_if<std::shared_ptr<const WholeGeometry>>(&data);
    if (!whole) continue;
    WholeGeometry colored = **whole;
    colored.block.values.clear();
    Random random(11);
    for (size_t i = 0; i < colored.block.points.size(); i++)
      colored.block.colors.push_back(glm::vec3{uniform(random), uniform(random), uniform(random)});
    data = std::make_shared<const WholeGeometry>(std::move(colored));
  }
}

void addClipPlane(TestScene& scene) {
  for (Vis& vis : scene.visualization.operators) vis.clipPlanes.push_back({{-0.2, 0.1, -1}, -0.75});
}

void addLights(TestScene& scene) {
  Lighting& l = scene.visualization.lighting;
  l.sources = {{LightType::Directional, {-0.5, -1, -0.4}},
               {LightType::Point, inDomain({0.4, 0.9, 0.6})},
               {LightType::Camera, {0.3, 0.2, 0}}};
  l.shadows = true;
  l.Ka = 0.3, l.Kd = 0.6, l.Ks = 0.2;
}

void addOcclusion(TestScene& scene) {
  scene.visualization.lighting.aoCount = 4;
  scene.visualization.lighting.aoRadius = 0.45;
}

std::vector<TestScene> scenesOfEachKind() {
  std::vector<TestScene> scenes;
  auto add = [&](const char* name) -> TestScene& { return scenes.emplace_back(emptyScene(name)); };
  {
    TestScene& s = add("smooth volume");
    addSmoothVolume(s);
  }
  {
    TestScene& s = add("spiky volume");
    addSpikyVolume(s);
  }
  {
    TestScene& s = add("isosurfaces");
    addIsosurfaces(s, 1);
  }
  {
    TestScene& s = add("translucent isosurfaces");
    addIsosurfaces(s, 0.4);
  }
  {
    TestScene& s = add("slices");
    addSlices(s, 0.6);
  }
  {
    TestScene& s = add("particles");
    addParticles(s, 1);
  }
  {
    TestScene& s = add("tubes");
    addTubes(s, 1);
  }
  {
    TestScene& s = add("mesh");
    addMesh(s, 1);
  }
  {
    TestScene& s = add("colours");
    addParticles(s, 1);
    addTubes(s, 0.6);
    addMesh(s, 0.7);
    for (Vis& vis : s.visualization.operators) vis.radius0 = vis.radius1 = 0.06;
    addColors(s);
    addLights(s);
  }
  {
    TestScene& s = add("several volumes");
    addSmoothVolume(s);
    addSecondVolume(s);
    addSpikyVolume(s);
  }
  {
    TestScene& s = add("second volume alone");
    addSecondVolume(s);
  }
  {
    TestScene& s = add("translucent surfaces");
    addParticles(s, 0.5);
    addTubes(s, 0.4);
    addMesh(s, 0.3);
  }
  {
    TestScene& s = add("clip planes");
    addSmoothVolume(s);
    addIsosurfaces(s, 1);
    addParticles(s, 1);
    addMesh(s, 1);
    addClipPlane(s);
  }
  {
    TestScene& s = add("shadows and occlusion");
    addIsosurfaces(s, 1);
    addParticles(s, 1);
    addLights(s);
    addOcclusion(s);
  }
  {
    TestScene& s = add("volume shadows");
    addSmoothVolume(s);
    addMesh(s, 1);
    addLights(s);
  }
  {
    TestScene& s = add("translucent shadows");
    addMesh(s, 0.5);
    addSlices(s, 0.5);
    addLights(s);
    addOcclusion(s);
  }
  {
    TestScene& s = add("orthographic");
    addSmoothVolume(s);
    addIsosurfaces(s, 0.5);
    addTubes(s, 1);
    s.camera.aov = 0;
    s.camera.height = 2.4;
  }
  {
    TestScene& s = add("from inside");
    addSmoothVolume(s);
    addSecondVolume(s);
    addTubes(s, 0.7);
    s.camera.viewpoint = inDomain({0.43, 0.51, 0.77});
    s.camera.aov = 70;
  }
  {
    TestScene& s = add("four rays a pixel");
    addSmoothVolume(s);
    addParticles(s, 0.8);
    s.settings.raysPerPixel = 4;
  }
  return scenes;
}

TestScene everything(glm::ivec2 size) {
  TestScene s = emptyScene("everything", size);
  addSmoothVolume(s);
  addSecondVolume(s);
  addIsosurfaces(s, 0.6);
  addSlices(s, 0.5);
  addParticles(s, 1);
  addTubes(s, 0.7);
  addMesh(s, 0.5);
  addClipPlane(s);
  addLights(s);
  addOcclusion(s);
  return s;
}

}  // namespace gxy::test

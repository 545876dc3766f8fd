// SPDX-License-Identifier: Apache-2.0
#include "tests/agreement/scenes.h"

#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <numbers>

#include "core/data/macrocells.h"
#include "tools/gxyrender/reference_scene.h"

namespace gxy::agreement {

Vis& TestScene::add(Vis vis, std::shared_ptr<const Volume> volume) {
  data.emplace_back().volume = std::move(volume);
  return visualization.operators.emplace_back(std::move(vis));
}

Vis& TestScene::add(Vis vis, std::shared_ptr<const Mesh> mesh) {
  data.emplace_back().mesh = std::move(mesh);
  return visualization.operators.emplace_back(std::move(vis));
}

Vis& TestScene::add(Vis vis, std::shared_ptr<const Geometry> geometry) {
  data.emplace_back().geometry = std::move(geometry);
  return visualization.operators.emplace_back(std::move(vis));
}

std::shared_ptr<const CompiledScene> TestScene::compile() const {
  Box all = domain;
  if (all.empty())
    for (const OperatorData& d : data)
      all.extend(d.volume ? d.volume->grid.box() : d.mesh ? d.mesh->box : d.geometry->box);
  for (int a = 0; a < 3; a++) {  // a partitioning has a volume
    const glm::dvec3 size = all.hi - all.lo;
    const double longest = std::max({size.x, size.y, size.z, std::abs(all.lo[a]) * 1e-12, 1e-300});
    if (!(size[a] > 0)) all.lo[a] -= 0.5 * longest, all.hi[a] += 0.5 * longest;
  }
  std::vector<OperatorData> complete = data;
  for (size_t i = 0; i < complete.size(); i++) {
    const Vis& vis = visualization.operators[i];
    if (complete[i].mesh && !vis.isovalues.empty())
      complete[i].gradients =
          std::make_shared<const PointGradients>(localGradients(*complete[i].mesh, vis.component));
  }
  return compileScene(visualization, std::move(complete),
                      std::make_shared<Partitioning>(Partitioning::single(all)), settings, others);
}

reference::ReferenceScene TestScene::forReference() const {
  return referenceScene(visualization, data, settings);
}

TestScene sceneFrom(std::string name, glm::dvec3 eye, int width, int height) {
  TestScene scene;
  scene.name = std::move(name);
  scene.camera.viewpoint = eye;
  scene.camera.viewdirection = -eye;
  scene.camera.dimensions = {width, height};
  scene.camera.aov = 35;
  return scene;
}

TestScene moved(const TestScene& from, double factor, glm::dvec3 shift) {
  TestScene scene = from;
  auto place = [&](glm::dvec3 p) { return p * factor + shift; };
  auto plane = [&](Plane& p) { p.offset = p.offset * factor + glm::dot(p.normal, shift); };
  scene.camera.viewpoint = place(scene.camera.viewpoint);
  scene.camera.height *= factor;
  if (!scene.domain.empty()) scene.domain = {place(scene.domain.lo), place(scene.domain.hi)};
  Lighting& lighting = scene.visualization.lighting;
  lighting.aoRadius *= factor;
  for (Light& l : lighting.sources) {
    if (l.type == LightType::Point) l.v = place(l.v);
    if (l.type == LightType::Camera) l.v *= factor;
  }
  for (Vis& vis : scene.visualization.operators) {
    for (Plane& p : vis.clipPlanes) plane(p);
    for (Plane& p : vis.slices) plane(p);
    vis.radius0 *= factor, vis.radius1 *= factor;
    if (vis.referenceLength) *vis.referenceLength *= factor;
    if (vis.opacitymap.extinction)
      for (OpacityPoint& p : vis.opacitymap.points) p.opacity /= factor;
  }
  for (OperatorData& d : scene.data) {
    if (d.volume) {
      auto volume = std::make_shared<Volume>(*d.volume);
      volume->grid.origin = place(volume->grid.origin);
      volume->grid.spacing *= factor;
      d.volume = volume;
    } else if (d.mesh) {
      auto mesh = std::make_shared<Mesh>(*d.mesh);
      mesh->box = {place(mesh->box.lo), place(mesh->box.hi)};
      for (auto& [partition, block] : mesh->blocks) {
        std::vector<glm::dvec3> points(block.points.begin(), block.points.end());
        for (glm::dvec3& p : points) p = place(p);
        block.points = std::move(points);
      }
      d.mesh = mesh;
    } else {
      auto geometry = std::make_shared<Geometry>(*d.geometry);
      for (glm::dvec3& p : geometry->blocks.at(0).points) p = place(p);
      geometry->box = boxOf(geometry->blocks.at(0));
      d.geometry = geometry;
    }
  }
  return scene;
}

namespace {

std::shared_ptr<Volume> finished(const Grid& grid, const Samples& samples, ScalarType type) {
  auto volume = std::make_shared<Volume>();
  const FieldStatistics statistics = statisticsOf(samples, type, 1);
  const Encoding encoding = encodingOf(type, 1, statistics.ranges[0]);
  volume->name = "test";
  volume->grid = grid;
  volume->stored = encoding.stored;
  volume->shift = encoding.shift, volume->scale = encoding.scale;
  volume->ranges = statistics.ranges;
  volume->noDataSamples = statistics.noDataSamples;
  VolumeBlock& block = volume->blocks[0];
  block.extent.points = grid.points;
  block.samples = convert(samples, type, encoding);
  completeBlock(block, encoding.stored, 1);
  return volume;
}

template <class T>
Samples sampled(const Grid& grid, const FieldFunction& field) {
  Samples samples(size_t(grid.points[0] * grid.points[1] * grid.points[2]) * sizeof(T));
  std::byte* out = samples.data();
  for (int64_t k = 0; k < grid.points[2]; k++)
    for (int64_t j = 0; j < grid.points[1]; j++)
      for (int64_t i = 0; i < grid.points[0]; i++, out += sizeof(T)) {
        double value = field(grid.origin + grid.spacing * glm::dvec3(i, j, k));
        if (std::is_integral_v<T>)
          value = std::clamp(std::round(value), double(std::numeric_limits<T>::lowest()),
                             double(std::numeric_limits<T>::max()));
        const T stored = T(value);
        std::memcpy(out, &stored, sizeof stored);
      }
  return samples;
}

}  // namespace

std::shared_ptr<Volume> makeVolume(const Grid& grid, const FieldFunction& field, ScalarType type) {
  return finished(grid, withType(type, [&](auto t) { return sampled<decltype(t)>(grid, field); }), type);
}

Grid cube(int64_t n, double half) {
  return {glm::dvec3(-half), glm::dvec3(2 * half / double(n - 1)), {n, n, n}};
}

std::shared_ptr<Geometry> makeGeometry(GeometryKind kind, GeometryBlock block) {
  auto made = std::make_shared<Geometry>();
  const size_t count = kind == GeometryKind::Particles   ? block.points.size()
                       : kind == GeometryKind::PathLines ? block.segments.size()
                                                         : block.triangles.size();
  block.ids.resize(count);
  for (size_t i = 0; i < count; i++) block.ids[i] = i;
  made->name = "test";
  made->kind = kind;
  made->droppedPrimitives = uint64_t(dropUnusable(block, kind));
  made->primitives = block.ids.size();
  made->box = boxOf(block);
  made->range = rangeOf(block);
  made->radiusRange = radiusRangeOf(block);
  made->colored = !block.colors.empty();
  made->blocks[0] = std::move(block);
  return made;
}

void addLine(GeometryBlock& block, const std::vector<glm::dvec3>& points, const std::vector<float>& values) {
  const auto first = uint32_t(block.points.size()), last = first + uint32_t(points.size()) - 1;
  block.points.insert(block.points.end(), points.begin(), points.end());
  block.values.insert(block.values.end(), values.begin(), values.end());
  for (uint32_t i = first; i < last; i++) {
    block.segments.push_back({i, i + 1});
    block.neighbours.push_back({i > first ? i - 1 : i, i + 1 < last ? i + 2 : i + 1});
  }
}

GeometryBlock coloured(GeometryBlock block) {
  block.values.clear();
  for (const glm::dvec3& p : block.points) {
    const glm::dvec3 waves(std::sin(3 * p.x + p.y), std::sin(4 * p.y + 1), std::sin(5 * p.z + p.x + 2));
    block.colors.push_back(glm::vec3(0.5 + 0.5 * waves));
  }
  return block;
}

GeometryBlock sphereMesh(int n, bool normals, bool values) {
  GeometryBlock block;
  for (int j = 0; j <= n; j++)
    for (int i = 0; i < n; i++) {
      const double theta = std::numbers::pi * j / n, phi = 2 * std::numbers::pi * i / n;
      const glm::dvec3 p(std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi));
      block.points.push_back(p);
      if (normals) block.normals.push_back(glm::vec3(p));
      if (values) block.values.push_back(float(0.5 + 0.5 * p.y));
    }
  auto index = [&](int i, int j) { return uint32_t(j * n + i % n); };
  for (int j = 0; j < n; j++)
    for (int i = 0; i < n; i++) {
      block.triangles.push_back({index(i, j), index(i + 1, j), index(i + 1, j + 1)});
      block.triangles.push_back({index(i, j), index(i + 1, j + 1), index(i, j + 1)});
    }
  return block;
}

double marschnerLobb(glm::dvec3 p) {
  const double pi = std::numbers::pi, r = std::sqrt(p.x * p.x + p.y * p.y);
  return (1 - std::sin(pi * p.z / 2) + 0.25 * (1 + std::cos(12 * pi * std::cos(pi * r / 2)))) / 2.5;
}

double waves(glm::dvec3 p) {
  Uniform random(7);
  double sum = 0;
  for (int i = 0; i < 12; i++) {
    const glm::dvec3 k = random.inCube(6);
    sum += std::sin(glm::dot(k, p) + 6.2831853 * random());
  }
  return sum / 5;
}

Vis rendered(std::vector<OpacityPoint> opacity, double lo, double hi, bool extinction) {
  Vis vis = surfaces(VisType::Volume, lo, hi);
  vis.volumeRendering = true;
  vis.opacitymap = {extinction, std::move(opacity)};
  return vis;
}

Vis surfaces(VisType type, double lo, double hi) {
  Vis vis;
  vis.type = type;
  const double middle = 0.5 * (lo + hi);
  vis.colormap.points = {{lo, {0.1, 0.2, 0.9}}, {middle, {0.9, 0.9, 0.5}}, {hi, {0.9, 0.1, 0.1}}};
  return vis;
}

namespace {

GeometryBlock floorMesh() {
  GeometryBlock block;
  block.points = {{-2, -1.05, -2}, {2, -1.05, -2}, {2, -1.05, 2}, {-2, -1.05, 2}};
  block.triangles = {{0, 1, 2}, {0, 2, 3}};
  return block;
}

}  // namespace

std::shared_ptr<const Volume> wavy() {
  static const auto volume = makeVolume(cube(28), waves);
  return volume;
}

TestScene solids(const std::string& name, int size) {
  TestScene scene = sceneFrom(name, glm::dvec3(2.1, 1.7, 3.3), size, size);
  scene.add(surfaces(VisType::Triangles), makeGeometry(GeometryKind::Triangles, floorMesh()));
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

TestScene everything(int size) {
  TestScene scene = solids("everything", size);
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
  return scene;
}

}  // namespace gxy::agreement

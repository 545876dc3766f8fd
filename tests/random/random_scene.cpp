// SPDX-License-Identifier: Apache-2.0
#include "tests/random/random_scene.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "core/scene/state_file.h"
#include "tests/random/random_data.h"

namespace gxy::test {

namespace {

ColorMap randomColors(Choices& choose, double lo, double hi) {
  ColorMap map;
  const int points = choose.oneIn(6) ? 1 : choose.from(2, 6);
  for (int i = 0; i < points; i++) {
    const double value = choose.oneIn(4) ? choose.in(lo, hi) : lo + (hi - lo) * i / std::max(1, points - 1);
    map.points.push_back({value, choose.point(0, 1)});  // not sorted: reading the state file does that
  }
  return map;
}

/// The colour of the nearest point, as of labels.
ColorMap categories(ColorMap map) {
  std::stable_sort(map.points.begin(), map.points.end(),
                   [](const ColorPoint& a, const ColorPoint& b) { return a.value < b.value; });
  ColorMap steps;
  for (const ColorPoint& p : map.points) {
    if (!steps.points.empty()) {
      const ColorPoint before = steps.points.back();
      const double middle = 0.5 * (before.value + p.value);
      steps.points.push_back({middle, before.rgb});
      steps.points.push_back({middle, p.rgb});
    }
    steps.points.push_back(p);
  }
  return steps;
}

OpacityMap randomOpacity(Choices& choose, double lo, double hi, double cell) {
  OpacityMap map;
  auto add = [&](double f, double a) { map.points.push_back({lo + f * (hi - lo), a}); };
  const double most = choose.oneIn(3) ? 0.9 : 0.25;
  switch (choose.below(8)) {
    case 0:  // spikes
      for (double middle : {choose.in(0.1, 0.45), choose.in(0.55, 0.9)}) {
        const double width = choose.in(0.002, 0.05);
        add(middle - width, 0), add(middle, most * choose.unit()), add(middle + width, 0);
      }
      break;
    case 1: {  // steps
      const double f = choose.in(0.2, 0.5), g = choose.in(0.5, 0.8), a = most * choose.unit();
      add(f, 0), add(f, a), add(g, a), add(g, choose.oneIn(2) ? 0 : 0.5 * a);
      break;
    }
    case 2:  // opaque from somewhere on
      add(0, 0), add(choose.in(0.3, 0.8), 0), add(choose.in(0.8, 0.95), 1), add(1, 1);
      break;
    case 3:  // one point
      add(0.5, choose.oneIn(4) ? double(choose.below(2)) : most * choose.unit());
      break;
    case 4:  // nearly transparent
      add(0, 0), add(1, 0.004 * choose.unit());
      break;
    case 5:  // anything, unsorted
      for (int n = choose.from(2, 5); n > 0; n--) add(choose.unit(), most * choose.unit());
      break;
    default:  // smooth
      add(0, 0), add(0.5, 0.3 * most * choose.unit()), add(1, most * choose.unit());
  }
  if (choose.oneIn(4)) {
    map.extinction = true;
    for (OpacityPoint& p : map.points) p.opacity *= choose.scale(0.5, 3) / cell;
  }
  return map;
}

Plane randomPlane(Choices& choose) {
  glm::dvec3 normal = choose.direction();
  if (choose.oneIn(4)) {
    normal = glm::dvec3(0);
    normal[choose.below(3)] = choose.oneIn(2) ? 1 : -1;
  }
  const double offset = glm::dot(normal, choose.point(-0.6, 0.6)), length = choose.scale(0.3, 3);
  return {length * normal, length * offset};
}

void clipAndFade(Choices& choose, Vis& vis) {
  if (choose.oneIn(4))
    for (int n = choose.from(1, 2); n > 0; n--) vis.clipPlanes.push_back(randomPlane(choose));
  if (choose.oneIn(3)) vis.opacity = choose.oneIn(6) ? 0 : choose.in(0.2, 0.9);
  if (choose.oneIn(5)) vis.twoSided = false;
}

void addVolume(Choices& choose, TestScene& scene) {
  RandomVolume made = randomVolume(choose);
  Vis vis;
  vis.type = VisType::Volume;
  if (made.volume.components > 1 && choose.oneIn(2)) vis.component = choose.below(made.volume.components);
  const bool magnitude = made.volume.components > 1 && !vis.component;
  const double lo = magnitude ? 0 : made.lo;
  const double hi = magnitude ? std::sqrt(2.0) * std::max(std::abs(made.lo), std::abs(made.hi)) : made.hi;
  const glm::dvec3 cells = made.volume.grid.spacing;
  vis.colormap = randomColors(choose, lo, hi);
  const int shown = choose.from(1, 7);  // bits: rendered, isosurfaces, slices
  vis.volumeRendering = shown & 1;
  vis.opacitymap = randomOpacity(choose, lo, hi, std::max({cells.x, cells.y, cells.z}));
  if (choose.oneIn(3) || std::min({cells.x, cells.y, cells.z}) < 1e-3)
    vis.referenceLength = choose.scale(0.03, 0.5);
  if (choose.oneIn(6)) vis.dataRange = {{lo + 0.1 * (hi - lo), hi - 0.2 * (hi - lo)}};
  if (shown & 2)
    for (int n = choose.from(1, 3); n > 0; n--)
      vis.isovalues.push_back(lo +
                              (hi - lo) * (choose.oneIn(8) ? choose.from(0, 5) / 5.0 : choose.in(0.1, 0.9)));
  if (shown & 4)
    for (int n = choose.from(1, 2); n > 0; n--) vis.slices.push_back(randomPlane(choose));
  clipAndFade(choose, vis);
  scene.data.emplace_back(std::make_shared<const WholeVolume>(std::move(made.volume)));
  scene.visualization.operators.push_back(std::move(vis));
}

void addCells(Choices& choose, TestScene& scene) {
  RandomMesh made = randomCells(choose);
  Vis vis;
  vis.type = VisType::Volume;
  vis.volumeRendering = true;
  vis.colormap = randomColors(choose, made.lo, made.hi);
  vis.opacitymap = randomOpacity(choose, made.lo, made.hi, made.size);
  if (choose.oneIn(3) || made.thin) vis.referenceLength = choose.scale(0.03, 0.5);
  if (choose.oneIn(6)) vis.dataRange = {{0.9 * made.lo + 0.1 * made.hi, 0.2 * made.lo + 0.8 * made.hi}};
  clipAndFade(choose, vis);
  scene.data.emplace_back(std::make_shared<const WholeMesh>(std::move(made.mesh)));
  scene.visualization.operators.push_back(std::move(vis));
}

void addGeometry(Choices& choose, TestScene& scene) {
  const auto kind = GeometryKind(choose.below(3));
  Vis vis;
  vis.type = kind == GeometryKind::Particles   ? VisType::Particles
             : kind == GeometryKind::PathLines ? VisType::PathLines
                                               : VisType::Triangles;
  const bool repeats = choose.oneIn(2);
  WholeGeometry made = kind == GeometryKind::Particles   ? randomParticles(choose)
                       : kind == GeometryKind::PathLines ? randomLines(choose, repeats)
                                                         : randomMesh(choose);
  vis.colormap = randomColors(choose, 0, 1);
  Choices apart = choose;  // what is chosen next does not depend on these
  if (apart.oneIn(2)) vis.colormap.nan = apart.point(0, 1);
  vis.radius0 = choose.oneIn(5) ? 0 : choose.scale(0.02, 0.3);
  vis.radius1 = choose.oneIn(8) ? -0.1 : choose.scale(0.02, 0.3);
  vis.value1 = choose.oneIn(4) ? 0 : 1;
  clipAndFade(choose, vis);
  scene.data.emplace_back(std::make_shared<const WholeGeometry>(std::move(made)));
  scene.visualization.operators.push_back(std::move(vis));
}

Lighting randomLighting(Choices& choose) {
  Lighting l;
  l.sources.clear();
  for (int n = choose.below(3); n > 0; n--) {
    const auto type = LightType(choose.below(3));
    l.sources.push_back({type, type == LightType::Directional ? choose.direction() : choose.point(-2, 2)});
  }
  l.shadows = choose.oneIn(3);
  l.aoCount = choose.oneIn(4) ? choose.from(1, 3) : 0;
  l.aoRadius = choose.scale(0.1, 3);
  l.Ka = choose.in(0, 0.6), l.Kd = choose.in(0, 0.8), l.Ks = choose.oneIn(2) ? 0 : choose.in(0, 0.6);
  l.shininess = choose.scale(1, 60);
  return l;
}

Camera randomCamera(Choices& choose) {
  Camera c;
  c.dimensions = choose.oneIn(3) ? glm::ivec2(29, 20) : glm::ivec2(24, 24);
  const glm::dvec3 from = choose.direction(), target = choose.point(-0.3, 0.3);
  c.viewpoint = target + from * choose.in(3, 5);
  c.aov = choose.in(25, 45);
  c.viewup = choose.direction();
  switch (choose.below(10)) {
    case 0:  // inside
      c.viewpoint = choose.point(-0.9, 0.9);
      c.aov = choose.in(40, 120);
      break;
    case 1: {  // far away
      const double distance = choose.scale(10, 1e6);
      c.viewpoint = target + from * distance;
      c.aov = std::min(40.0, 170 / distance);
      break;
    }
    case 2:  // orthographic
      c.aov = 0;
      c.height = choose.in(1, 4);
      break;
    case 3:  // wide
      c.viewpoint = target + from * choose.in(0.5, 2);
      c.aov = choose.in(120, 179);
      break;
    case 4: {  // along an axis, through planes of the grids
      glm::dvec3 axis(0);
      axis[choose.below(3)] = choose.oneIn(2) ? 1 : -1;
      c.viewpoint = 4.0 * axis;
      c.viewdirection = -axis;
      c.viewup = {axis.y, axis.z, axis.x};
      c.aov = choose.oneIn(2) ? 0 : 40;
      c.height = 2.2;
      return c;
    }
    case 5:  // on a face
      c.viewpoint = choose.point(-0.9, 0.9);
      c.viewpoint[choose.below(3)] = choose.oneIn(2) ? 1 : -1;
      c.aov = choose.in(40, 90);
      break;
    default:
      break;
  }
  c.viewdirection = target - c.viewpoint;
  return c;
}

/// Every length multiplied by `factor`, then moved by `shift`.
void place(TestScene& scene, double factor, glm::dvec3 shift) {
  auto at = [&](glm::dvec3 p) { return p * factor + shift; };
  scene.camera.viewpoint = at(scene.camera.viewpoint);
  scene.camera.height *= factor;
  Lighting& lighting = scene.visualization.lighting;
  lighting.aoRadius *= factor;
  for (Light& l : lighting.sources) {
    if (l.type == LightType::Point) l.v = at(l.v);
    if (l.type == LightType::Camera) l.v *= factor;
  }
  for (size_t i = 0; i < scene.data.size(); i++) {
    Vis& vis = scene.visualization.operators[i];
    for (auto* planes : {&vis.clipPlanes, &vis.slices})
      for (Plane& p : *planes) p.offset = p.offset * factor + glm::dot(p.normal, shift);
    vis.radius0 *= factor, vis.radius1 *= factor;
    if (vis.referenceLength) *vis.referenceLength *= factor;
    if (vis.opacitymap.extinction)
      for (OpacityPoint& p : vis.opacitymap.points) p.opacity /= factor;
    if (auto* volume = std::get_if<std::shared_ptr<const WholeVolume>>(&scene.data[i])) {
      auto moved = std::make_shared<WholeVolume>(**volume);
      moved->grid.origin = at(moved->grid.origin);
      moved->grid.spacing *= factor;
      *volume = std::move(moved);
    } else if (auto* mesh = std::get_if<std::shared_ptr<const WholeMesh>>(&scene.data[i])) {
      auto moved = std::make_shared<WholeMesh>(**mesh);
      for (glm::dvec3& p : moved->cells.points) p = at(p);
      *mesh = std::move(moved);
    } else {
      auto& geometry = std::get<std::shared_ptr<const WholeGeometry>>(scene.data[i]);
      auto moved = std::make_shared<WholeGeometry>(*geometry);
      for (glm::dvec3& p : moved->block.points) p = at(p);
      geometry = std::move(moved);
    }
  }
}

/// The box of all data, with some volume in each direction.
Box domainOf(const TestScene& scene) {
  Box box;
  for (const auto& data : scene.data) {
    if (const auto* volume = std::get_if<std::shared_ptr<const WholeVolume>>(&data))
      box.extend((*volume)->grid.box());
    else if (const auto* mesh = std::get_if<std::shared_ptr<const WholeMesh>>(&data))
      box.extend(describedMesh((*mesh)->cells).box);
    else
      box.extend(boxOf(std::get<std::shared_ptr<const WholeGeometry>>(data)->block));
  }
  if (box.empty())
    return {glm::dvec3(-1), glm::dvec3(1)};  // all its geometry was dropped, as it cannot be drawn
  const glm::dvec3 size = box.hi - box.lo;
  const glm::dvec3 farthest = glm::max(glm::abs(box.lo), glm::abs(box.hi));
  const double longest =
      std::max({size.x, size.y, size.z, 1e-9 * farthest.x, 1e-9 * farthest.y, 1e-9 * farthest.z});
  for (int a = 0; a < 3; a++)
    if (!(size[a] > 1e-9 * longest)) box.lo[a] -= 0.01 * longest, box.hi[a] += 0.01 * longest;
  return box;
}

}  // namespace

State stateOf(const TestScene& scene) {
  State state;
  state.settings = scene.settings;
  state.cameras = {scene.camera};
  state.visualizations = {scene.visualization};
  for (size_t i = 0; i < scene.data.size(); i++) {
    Vis& vis = state.visualizations[0].operators[i];
    const bool mesh = std::holds_alternative<std::shared_ptr<const WholeMesh>>(scene.data[i]);
    const char* extension = mesh ? ".vtu" : vis.type == VisType::Volume ? ".vti" : ".vtp";
    vis.dataset = "data" + std::to_string(i);
    state.datasets.push_back(
        {vis.dataset, DatasetType(vis.type), vis.dataset + extension, "", {0.7, 0.6, 0.5, 1}});
  }
  return state;
}

namespace {

/// Chooses what a scene has besides its operators.
TestScene finished(uint64_t seed, Choices& choose, TestScene scene) {
  scene.visualization.lighting = randomLighting(choose);
  scene.camera = randomCamera(choose);
  scene.settings.background = glm::dvec4(choose.point(0, 1), choose.oneIn(3) ? choose.unit() : 1);
  scene.settings.raysPerPixel = choose.oneIn(8) ? choose.from(2, 3) : 1;
  const double factor = choose.oneIn(3) ? choose.scale(1e-30, 1e30) : 1;
  const double farthest = choose.oneIn(4) ? choose.scale(1, 1e6) : 0;
  place(scene, factor, factor * farthest * choose.point(-1, 1));
  scene.domain = domainOf(scene);
  Choices apart(~seed);  // what else a seed draws does not depend on it
  for (Vis& vis : scene.visualization.operators)
    if (vis.volumeRendering && apart.oneIn(4)) vis.colormap = categories(vis.colormap);

  StateFile read = readState(writeState(stateOf(scene)), scene.name);
  scene.visualization = std::move(read.state.visualizations.at(0));
  scene.camera = read.state.cameras.at(0);
  scene.settings = read.state.settings;
  return scene;
}

}  // namespace

TestScene randomScene(uint64_t seed) {
  Choices choose(seed);
  TestScene scene;
  scene.name = "random_" + std::to_string(seed);
  const int operators = choose.oneIn(4) ? choose.from(3, 4) : choose.from(1, 2);
  for (int n = 0; n < operators; n++)
    choose.below(5) < 3 ? addVolume(choose, scene) : addGeometry(choose, scene);
  return finished(seed, choose, std::move(scene));
}

TestScene randomMeshScene(uint64_t seed) {
  Choices choose(seed);
  TestScene scene;
  scene.name = "random_mesh_" + std::to_string(seed);
  addCells(choose, scene);
  for (int n = choose.oneIn(2) ? 0 : choose.from(1, 2); n > 0; n--) {
    choose.oneIn(3) ? addVolume(choose, scene) : addGeometry(choose, scene);
    scene.visualization.operators.back().volumeRendering = false;
  }
  return finished(seed, choose, std::move(scene));
}

Cut randomCut(const TestScene& scene, uint64_t seed) {
  Choices choose(seed);
  const int ranks = choose.from(1, 6);
  // sometimes cut on the points of the first volume's grid, up to one cell a partition
  const auto* volume = std::get_if<std::shared_ptr<const WholeVolume>>(&scene.data[0]);
  if (volume && (*volume)->grid.box() == scene.domain && choose.oneIn(2)) {
    const Grid& grid = (*volume)->grid;
    std::array<std::vector<double>, 3> faces;
    for (int a = 0; a < 3; a++) {
      const int64_t cells = grid.points[size_t(a)] - 1;
      faces[size_t(a)] = evenFaces(scene.domain.lo[a], scene.domain.hi[a],
                                   choose.from(1, int(std::min<int64_t>(cells, 4))), cells);
    }
    return {"on grid points, " + std::to_string(ranks) + " ranks", ranks,
            Partitioning::lattice(faces, ranks)};
  }
  if (choose.oneIn(3))
    return lattice(scene.domain, {choose.from(1, 3), choose.from(1, 3), choose.from(1, 3)}, ranks);
  return kdCut(scene.domain, choose.from(2, 12), ranks, seed);
}

agreement::TestScene inOnePiece(const TestScene& scene) {
  agreement::TestScene out;
  out.name = scene.name;
  out.visualization = scene.visualization;
  out.settings = scene.settings;
  out.camera = scene.camera;
  out.domain = scene.domain;
  const Partitioning one = Partitioning::single(scene.domain);
  for (size_t i = 0; i < scene.data.size(); i++) {
    const Vis& vis = scene.visualization.operators[i];
    if (const auto* volume = std::get_if<std::shared_ptr<const WholeVolume>>(&scene.data[i])) {
      out.data.emplace_back().volume = cut(**volume, one, 1).at(0);
    } else if (const auto* mesh = std::get_if<std::shared_ptr<const WholeMesh>>(&scene.data[i])) {
      out.data.emplace_back().mesh = cut(**mesh, one, 1).at(0);
    } else {
      const auto& geometry = *std::get<std::shared_ptr<const WholeGeometry>>(scene.data[i]);
      const bool flat = geometry.kind == GeometryKind::Triangles;
      auto radius = [&](double value) { return flat ? 0 : radiusOf(vis, value); };
      out.data.emplace_back().geometry = distributed(geometry, one, radius, 1).at(0);
      out.data.back().color = {0.7, 0.6, 0.5};
    }
  }
  return out;
}

double brightest(const TestScene& scene) {
  const Lighting& l = scene.visualization.lighting;
  return std::max(1.0, l.Ka + l.Kd + l.Ks);
}

}  // namespace gxy::test

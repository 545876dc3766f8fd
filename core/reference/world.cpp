// SPDX-License-Identifier: Apache-2.0
#include "core/reference/world.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <span>
#include <utility>

#include "core/comm/error.h"
#include "core/reference/isosurface.h"
#include "core/reference/reference.h"

namespace gxy::reference {
namespace {

/// The part of a ray that the clip planes keep.
Interval keptBy(std::span<const Plane> planes, const Ray& ray) {
  Interval kept{-kInfinity, kInfinity};
  for (const Plane& plane : planes) {
    const double towards = glm::dot(plane.normal, ray.direction);
    const double missing = plane.offset - glm::dot(plane.normal, ray.origin);
    if (towards > 0) {
      kept.lo = std::max(kept.lo, missing / towards);
    } else if (towards < 0) {
      kept.hi = std::min(kept.hi, missing / towards);
    } else if (missing > 0) {
      return {kInfinity, -kInfinity};
    }
  }
  return kept;
}

/// The part of a ray that an operator's clip planes and the extent of its field keep.
Interval keptOf(const Vis& vis, const std::optional<Field>& field, const Ray& ray) {
  const Interval kept = keptBy(vis.clipPlanes, ray);
  if (!field || !field->grid().rim) return kept;
  const Box box = field->grid().box();
  return kept.intersected(keptBy(planesAround(box.lo, box.hi), ray));
}

/// The radius at a point. Never negative: a radius that the map takes below zero is 0.
double radiusAt(const Vis& vis, const GeometryBlock& block, size_t point) {
  double radius = vis.radius0;
  const double value = radiusValue(block, point);
  if (vis.value0 != vis.value1 && !std::isnan(value)) {
    const double w = (value - vis.value0) / (vis.value1 - vis.value0);
    radius = mix(vis.radius0, vis.radius1, std::clamp(w, 0.0, 1.0));
  }
  return std::max(0.0, radius);
}

Ball ballAt(const Vis& vis, const GeometryBlock& block, size_t point) {
  return {block.points[point], radiusAt(vis, block, point)};
}

RoundCone coneOf(const Vis& vis, const GeometryBlock& block, uint32_t a, uint32_t b) {
  return {ballAt(vis, block, a), ballAt(vis, block, b)};
}

std::array<glm::dvec3, 3> cornersOf(const GeometryBlock& block, size_t item) {
  const auto& v = block.triangles[item];
  return {block.points[v[0]], block.points[v[1]], block.points[v[2]]};
}

Box boxOf(const Ball& ball) {
  return ball.radius > 0 ? Box{ball.centre - ball.radius, ball.centre + ball.radius} : Box{};
}

Box boxOf(const RoundCone& cone) {
  if (!(cone.a.radius > 0 || cone.b.radius > 0)) return {};
  Box box;
  for (const Ball& ball : {cone.a, cone.b}) {
    box.extend(ball.centre - ball.radius);
    box.extend(ball.centre + ball.radius);
  }
  return box;
}

std::vector<Box> boxesOf(const Vis& vis, const Geometry& geometry, const GeometryBlock& block) {
  std::vector<Box> boxes;
  if (geometry.kind == GeometryKind::Particles) {
    for (size_t i = 0; i < block.points.size(); i++) boxes.push_back(boxOf(ballAt(vis, block, i)));
  } else if (geometry.kind == GeometryKind::PathLines) {
    for (const auto& [a, b] : block.segments) boxes.push_back(boxOf(coneOf(vis, block, a, b)));
  } else {
    for (size_t i = 0; i < block.triangles.size(); i++) {
      Box box;
      for (const glm::dvec3& p : cornersOf(block, i)) box.extend(p);
      boxes.push_back(box);
    }
  }
  return boxes;
}

/// Tubes are one body: a surface inside the segment before or after does not count. The ball at a joint is on
/// both segments; it is a surface only of the first of them, also where a segment has no length.
bool insideNeighbour(const Vis& vis, const GeometryBlock& block, size_t item, glm::dvec3 p) {
  if (item >= block.neighbours.size()) return false;
  const auto [a, b] = block.segments[item];
  const auto [before, after] = block.neighbours[item];
  auto inside = [&](const RoundCone& cone) {
    return cone.depth(p) > 1e-9 * std::max(cone.a.radius, cone.b.radius);
  };
  return (before != a && (coneOf(vis, block, a, b).axial(p) <= 0 || inside(coneOf(vis, block, before, a)))) ||
         (after != b && inside(coneOf(vis, block, b, after)));
}

/// Whether two segments follow each other in one line.
bool adjoins(const GeometryBlock& block, size_t item, size_t other) {
  if (item >= block.neighbours.size()) return false;
  const auto same = [&](uint32_t i, uint32_t j) { return block.points[i] == block.points[j]; };
  const auto [a, b] = block.segments[item];
  const auto [before, after] = block.neighbours[item];
  const auto [from, to] = block.segments[other];
  return (before != a && same(from, before) && same(to, a)) ||
         (after != b && same(from, b) && same(to, after));
}

glm::dvec3 unitOr(glm::dvec3 v, glm::dvec3 fallback) {
  const double length = glm::length(v);
  return length > 0 && std::isfinite(length) ? v / length : fallback;
}

/// Whether a surface at t lies behind what was met last.
bool isBehind(double t, int vis, uint64_t primitive, const Behind& last) {
  return t > last.t || (t == last.t && std::pair(vis, primitive) > std::pair(last.vis, last.primitive));
}

double magnitude(glm::dvec3 v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); }

}  // namespace

World::ShownOperator World::makeVolume(const ReferenceScene& scene, size_t index) {
  if (const auto* mesh = std::get_if<std::shared_ptr<const MeshField>>(&scene.data[index]); mesh && *mesh)
    return makeMesh(*mesh, index);
  const Vis& vis = scene_->visualization.operators[index];
  const auto* volume = std::get_if<std::shared_ptr<const Volume>>(&scene.data[index]);
  if (!volume || !*volume) throw Error("reference: operator " + std::to_string(index) + " expects a volume");
  Field field(*volume, vis.component);
  const Grid& grid = field.grid();
  for (int a = 0; a < 3; a++) {
    if (grid.points[a] < 2)
      throw Error("reference: volume '" + (*volume)->name + "' needs 2 points on every axis");
  }
  box_.extend(grid.box());
  const double length = vis.referenceLength.value_or(field.smallestSpacing());
  return {&vis, Transfer(vis, length), std::move(field), nullptr, {}, nullptr, std::nullopt};
}

World::ShownOperator World::makeMesh(std::shared_ptr<const MeshField> mesh, size_t index) {
  const Vis& vis = scene_->visualization.operators[index];
  box_.extend(mesh->box());
  const double length = vis.referenceLength.value_or(mesh->typicalLength());
  std::vector<MeshSurface> surfaces;
  for (const Plane& plane : vis.slices) surfaces.push_back(mesh->slice(plane));
  for (const double isovalue : vis.isovalues) surfaces.push_back(mesh->isosurface(isovalue));
  return {&vis,    Transfer(vis, length), std::nullopt, std::move(mesh), std::move(surfaces),
          nullptr, std::nullopt};
}

World::ShownOperator World::makeGeometry(const ReferenceScene& scene, size_t index) {
  const Vis& vis = scene_->visualization.operators[index];
  const auto* geometry = std::get_if<std::shared_ptr<const Geometry>>(&scene.data[index]);
  const GeometryKind kind = vis.type == VisType::Particles   ? GeometryKind::Particles
                            : vis.type == VisType::PathLines ? GeometryKind::PathLines
                                                             : GeometryKind::Triangles;
  if (!geometry || !*geometry || (*geometry)->kind != kind || (*geometry)->blocks.count(0) == 0) {
    throw Error("reference: operator " + std::to_string(index) +
                " expects geometry of its kind in one partition");
  }
  const auto boxes = boxesOf(vis, **geometry, (*geometry)->blocks.at(0));
  for (const Box& box : boxes) box_.extend(box);
  return {&vis, Transfer(vis, 1), std::nullopt, nullptr, {}, *geometry, Bvh(boxes)};
}

World::World(const ReferenceScene& scene) : scene_(std::make_shared<ReferenceScene>(scene)) {
  const auto& operators = scene_->visualization.operators;
  if (operators.size() != scene.data.size()) throw Error("reference: expected one dataset for each operator");
  for (size_t i = 0; i < operators.size(); i++) {
    parts_.push_back(operators[i].type == VisType::Volume ? makeVolume(scene, i) : makeGeometry(scene, i));
  }
}

void World::nearestVolumeSurface(int index, const Ray& ray, Interval range, const Behind& last,
                                 SurfaceHit& best) const {
  const ShownOperator& part = parts_[size_t(index)];
  uint64_t primitive = 0;
  for (const Plane& plane : part.vis->slices) {
    const double t =
        (plane.offset - glm::dot(plane.normal, ray.origin)) / glm::dot(plane.normal, ray.direction);
    if (range.contains(t) && isBehind(t, index, primitive, last) && t < best.t &&
        part.field->value(ray.at(t))) {
      best.t = t;
      best.primitive = primitive;
    }
    primitive++;
  }
  // True if no isosurface was met at last.t.
  const bool again = isBehind(last.t, index, part.vis->slices.size(), last);
  const double after = again ? std::nextafter(last.t, -kInfinity) : last.t;
  for (double isovalue : part.vis->isovalues) {
    const auto t = firstRoot(*part.field, ray, isovalue, {range.lo, std::min(range.hi, best.t)}, after);
    if (t && *t < best.t) {
      best.t = *t;
      best.primitive = primitive;
    }
    primitive++;
  }
}

void World::nearestMeshSurface(int index, const Ray& ray, Interval range, const Behind& last,
                               SurfaceHit& best) const {
  const ShownOperator& part = parts_[size_t(index)];
  for (uint64_t primitive = 0; primitive < part.surfaces.size(); primitive++) {
    const MeshSurface& surface = part.surfaces[primitive];
    const double other = best.t;  // of an earlier operator or surface, which wins ties
    surface.tree().traverse(
        ray, std::max(range.lo, last.t), [&] { return std::min(range.hi, best.t); },
        [&](uint32_t cell) {
          for (const MeshCrossing& found : surface.crossings(cell, ray)) {
            if (!range.contains(found.t) || !(found.t < other)) continue;
            const bool again = found.t == last.t && index == last.vis && primitive == last.primitive;
            if (again ? cell <= last.item : !isBehind(found.t, index, primitive, last)) continue;
            if (found.t > best.t || (found.t == best.t && cell >= best.item)) continue;
            best.t = found.t;
            best.primitive = primitive;
            best.item = cell;
          }
        });
  }
}

void World::nearestPrimitive(int index, const Ray& ray, Interval range, const Behind& last,
                             SurfaceHit& best) const {
  const ShownOperator& part = parts_[size_t(index)];
  const GeometryBlock& block = part.geometry->blocks.at(0);
  const bool sphere = part.geometry->kind == GeometryKind::Particles;
  const double other = best.t;  // of an earlier operator, which wins ties
  auto consider = [&](double t, uint32_t item) {
    const uint64_t id = item < block.ids.size() ? block.ids[item] : item;
    if (!range.contains(t) || !isBehind(t, index, id, last) || !(t < other)) return;
    const bool met = t == last.t && index == last.vis;
    if (t > best.t || (t == best.t && id >= best.primitive)) return;
    if (!sphere && !block.segments.empty()) {
      if (met && adjoins(block, item, last.item)) return;
      if (insideNeighbour(*part.vis, block, item, ray.at(t))) return;
    }
    best.t = t;
    best.primitive = id;
    best.item = item;
  };
  auto visit = [&](uint32_t item) {
    if (part.geometry->kind == GeometryKind::Triangles) {
      if (const TriangleHit hit = cross(cornersOf(block, item), ray); hit.hit) consider(hit.t, item);
      return;
    }
    const Crossing c =
        sphere ? cross(ballAt(*part.vis, block, item), ray)
               : cross(coneOf(*part.vis, block, block.segments[item][0], block.segments[item][1]), ray);
    if (!c.hit) return;
    consider(c.in, item);
    consider(c.out, item);
  };
  part.tree->traverse(
      ray, std::max(range.lo, last.t), [&] { return std::min(range.hi, best.t); }, visit);
}

void World::describeVolumeSurface(const ShownOperator& part, const Ray& ray, SurfaceHit& hit) {
  const Vis& vis = *part.vis;
  const glm::dvec3 viewer = -ray.direction;
  hit.slack += 1e-9 * part.field->smallestSpacing();
  if (hit.primitive >= vis.slices.size()) {
    // The outside of the surface is where values are lower, as for a contour in VTK.
    hit.geometric = unitOr(-part.field->cellGradient(cellMet(*part.field, ray, hit.t), hit.position), viewer);
    hit.normal = unitOr(-part.field->smoothGradient(hit.position), hit.geometric);
    hit.colour = part.transfer.colour(vis.isovalues[hit.primitive - vis.slices.size()]);
  } else {
    const Plane& plane = vis.slices[hit.primitive];
    hit.normal = hit.geometric = glm::normalize(plane.normal);
    hit.colour = part.transfer.colour(part.field->value(hit.position).value_or(0));
  }
}

void World::describeMeshSurface(const ShownOperator& part, const Ray& ray, SurfaceHit& hit) {
  const Vis& vis = *part.vis;
  const MeshSurface& surface = part.surfaces[hit.primitive];
  const glm::dvec3 met = ray.at(hit.t);
  hit.slack = std::max(hit.slack, 64 * std::numeric_limits<double>::epsilon() * surface.farthest(hit.item));
  const auto crossings = surface.crossings(hit.item, ray);
  const MeshCrossing& crossing = *std::ranges::find(crossings, hit.t, &MeshCrossing::t);
  if (hit.primitive >= vis.slices.size()) {
    hit.geometric = -surface.upwards(crossing, ray.direction, hit.position - met);
    hit.normal = -surface.smoothUpwards(crossing, -hit.geometric, hit.position - met);
    hit.colour = part.transfer.colour(vis.isovalues[hit.primitive - vis.slices.size()]);
  } else {
    hit.normal = hit.geometric = glm::normalize(vis.slices[hit.primitive].normal);
    hit.colour = part.transfer.colour(surface.valueNear(crossing, hit.position - met));
  }
}

void World::describePrimitive(const ShownOperator& part, const Ray& ray, SurfaceHit& hit) {
  const Vis& vis = *part.vis;
  const GeometryBlock& block = part.geometry->blocks.at(0);
  std::array<uint32_t, 3> points{hit.item, 0, 0};
  glm::dvec3 weights(1, 0, 0);
  if (part.geometry->kind == GeometryKind::Particles) {
    hit.normal = hit.geometric = glm::normalize(hit.position - block.points[hit.item]);
  } else if (part.geometry->kind == GeometryKind::PathLines) {
    const auto [a, b] = block.segments[hit.item];
    const RoundCone cone = coneOf(vis, block, a, b);
    const double u = cone.axial(hit.position);
    points = {a, b, b};
    weights = {1 - u, u, 0};
    hit.normal = hit.geometric = cone.normal(hit.position);
  } else {
    const auto corners = cornersOf(block, hit.item);
    points = block.triangles[hit.item];
    hit.geometric = glm::normalize(glm::cross(corners[1] - corners[0], corners[2] - corners[0]));
    weights = cross(corners, ray).weights;
    hit.normal = hit.geometric;
    if (!block.normals.empty()) {
      glm::dvec3 smooth(0);
      for (int i = 0; i < 3; i++) smooth += weights[i] * glm::dvec3(block.normals[points[i]]);
      hit.normal = unitOr(smooth, hit.geometric);
    }
  }
  if (!block.colors.empty()) {
    for (int i = 0; i < 3; i++) hit.colour += weights[i] * glm::dvec3(block.colors[points[i]]);
  } else if (block.values.empty()) {
    hit.colour = part.transfer.firstColour();
  } else {
    double value = 0;
    for (int i = 0; i < 3; i++) value += weights[i] != 0 ? weights[i] * block.values[points[i]] : 0;
    hit.colour = std::isnan(value) ? part.transfer.colourOfNan() : part.transfer.colour(value);
  }
}

std::optional<SurfaceHit> World::firstHit(const Ray& ray, const Behind& last, double limit,
                                          glm::dvec3 aside) const {
  SurfaceHit best;
  bool found = false;
  best.t = limit;
  for (size_t i = 0; i < parts_.size(); i++) {
    const ShownOperator& part = parts_[i];
    const Interval range = Interval{}.intersected(keptOf(*part.vis, part.field, ray));
    const double before = best.t;
    if (part.field) {
      nearestVolumeSurface(int(i), ray, range, last, best);
    } else if (part.mesh) {
      nearestMeshSurface(int(i), ray, range, last, best);
    } else if (part.geometry) {
      nearestPrimitive(int(i), ray, range, last, best);
    }
    if (!(best.t < before)) continue;
    best.vis = int(i);
    found = true;
  }
  if (!found) return std::nullopt;
  const ShownOperator& part = parts_[best.vis];
  best.position = ray.at(best.t) + aside;
  best.opacity = part.vis->opacity;
  best.slack =
      64 * std::numeric_limits<double>::epsilon() * std::max(magnitude(ray.origin), magnitude(best.position));
  if (part.field) {
    describeVolumeSurface(part, ray, best);
  } else if (part.mesh) {
    describeMeshSurface(part, ray, best);
  } else {
    describePrimitive(part, ray, best);
  }
  best.position = ray.at(best.t);
  if (part.vis->twoSided && glm::dot(best.normal, ray.direction) > 0) best.normal = -best.normal;
  if (glm::dot(best.normal, best.geometric) < 0) best.geometric = -best.geometric;
  return best;
}

VolumeRay World::volumes(const Ray& ray, Interval range) const {
  std::vector<VolumeTerm> terms;
  for (const ShownOperator& part : parts_) {
    if (!part.vis->volumeRendering) continue;
    const Interval kept = keptOf(*part.vis, part.field, ray);
    if (part.field) terms.push_back({&*part.field, &part.transfer, kept});
    if (part.mesh) terms.push_back({part.mesh.get(), &part.transfer, kept});
  }
  return VolumeRay(terms, ray, range);
}

double World::transmittance(const Ray& ray, double limit, double tolerance) const {
  double passed = 1;
  Behind last;
  while (passed > 0) {
    const auto hit = firstHit(ray, last, limit);
    if (!hit) break;
    passed *= 1 - hit->opacity;
    last = *hit;
  }
  if (passed > 0) passed *= volumes(ray, {0, limit}).integrate({0, limit}, tolerance).transmittance;
  return passed;
}

}  // namespace gxy::reference

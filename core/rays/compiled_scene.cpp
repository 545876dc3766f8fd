// SPDX-License-Identifier: Apache-2.0
#include "core/rays/compiled_scene.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <optional>

#include "core/comm/error.h"
#include "core/comm/parallel_for.h"
#include "core/kernels/single_views.h"
#include "core/rays/compiled_mesh.h"
#include "core/rays/iso_mask.h"
#include "core/rays/step_plan.h"
#include "core/scene/colormaps.h"
#include "core/scene/json_text.h"

namespace gxy {

namespace {

// In longest sides of what is seen: it lies strictly inside the visible domain, by this margin.
constexpr double kDomainMargin = 1e-5;

CompiledPlane compilePlane(const Plane& plane, const RenderSpace& space) {
  const double length = glm::length(plane.normal);
  const glm::dvec3 n = plane.normal / length;
  const double offset = (plane.offset / length - glm::dot(n, space.centre)) * space.scale;
  return {float(n.x), float(n.y), float(n.z), float(offset)};
}

bool planeMeets(const CompiledPlane& p, const Box& box, const RenderSpace& space) {
  const glm::dvec3 lo = space.toRender(box.lo), hi = space.toRender(box.hi);
  const glm::dvec3 centre = 0.5 * (lo + hi), half = 0.5 * (hi - lo);
  const double reach =
      std::abs(p.x) * half.x + std::abs(p.y) * half.y + std::abs(p.z) * half.z + kDomainMargin;
  return std::abs(p.x * centre.x + p.y * centre.y + p.z * centre.z - p.offset) <= reach;
}

// The largest extinction of a rendered volume on a uniform grid, per unit of t.
double largestExtinction(const CompiledOperator& op) {
  const Volume& volume = *op.data.volume;
  const Range& range = volume.ranges.at(op.summary);
  if (!op.vis.volumeRendering || range.empty()) return 0;
  auto stored = [&](double v) { return float((v - volume.shift) / volume.scale); };
  return op.map.over(stored(range.min), stored(range.max)).extinction;
}

void compileVolume(CompiledOperator& op, CompiledScene& scene) {
  const Volume& volume = *op.data.volume;
  const RenderSpace& space = scene.space;
  const glm::dvec3 origin = space.toRender(volume.grid.origin);
  for (int k = 0; k < 3; k++) {
    op.gridOrigin[k] = float(origin[k]);
    op.gridInverse[k] = float(1 / (volume.grid.spacing[k] * space.scale));
  }
  if (op.vis.component && *op.vis.component >= volume.components)
    throw Error("dataset \"" + op.vis.dataset + "\": component " + std::to_string(*op.vis.component) +
                " was asked for, it has " + std::to_string(volume.components) + " (counted from 0)");
  op.summary = volume.components == 1 ? 0 : op.vis.component.value_or(volume.components);

  const glm::dvec3 s = volume.grid.spacing;
  MapUnits units{volume.shift, volume.scale, 1 / space.scale,
                 op.vis.referenceLength.value_or(std::min({s.x, s.y, s.z}))};
  const OpacityMap opacity = effectiveOpacityMap(op.vis);
  op.map = CompiledMap(effectiveColorMap(op.vis), op.vis.volumeRendering ? &opacity : nullptr, units);
  if (largestExtinction(op) == 0) op.vis.volumeRendering = false;  // nothing of the volume would be seen
  for (double v : op.vis.isovalues) op.isovalues.push_back(float((v - volume.shift) / volume.scale));
  for (const Plane& p : op.vis.slices) op.slices.push_back(compilePlane(p, space));
  if (op.vis.every == 0) return;
  if (!(op.vis.every * space.scale * kMostSteps >= 1))
    throw Error("rays are to meet \"" + op.vis.dataset + "\" every " + numberText(op.vis.every) +
                ", expected at least " + numberText(1 / (space.scale * kMostSteps)) +
                ", a 32768th of the domain's longest side");
  op.every = float(std::min(op.vis.every * space.scale, 1e29));
}

// Calls visit(index, firstCell) for the block's macrocells that have cells between the points of an extent,
// until a call returns true. Returns whether one did.
template <class Visit>
bool anyMacrocell(const VolumeBlock& block, const Extent& extent, Visit&& visit) {
  Index3 from, to;  // indices of macrocells in the block
  for (size_t a = 0; a < 3; a++) {
    from[a] = std::max<int64_t>(extent.first[a] / kMacrocellSize - block.firstMacrocell[a], 0);
    const int64_t lastCell = extent.first[a] + extent.points[a] - 2;
    to[a] = std::min(lastCell / kMacrocellSize + 1 - block.firstMacrocell[a], block.macrocells[a]);
  }
  for (int64_t z = from[2]; z < to[2]; z++)
    for (int64_t y = from[1]; y < to[1]; y++)
      for (int64_t x = from[0]; x < to[0]; x++) {
        const auto index = size_t((z * block.macrocells[1] + y) * block.macrocells[0] + x);
        const Index3& f = block.firstMacrocell;
        if (visit(index, Index3{(f[0] + x) * kMacrocellSize, (f[1] + y) * kMacrocellSize,
                                (f[2] + z) * kMacrocellSize}))
          return true;
      }
  return false;
}

bool showsSurfaces(const CompiledOperator& op) {
  return op.vis.type != VisType::Volume || !op.isovalues.empty() || !op.slices.empty() || op.every > 0;
}

// Enters operator `number` in the scene's lists.
void listOperator(const CompiledOperator& op, int32_t number, CompiledScene& scene) {
  if (op.data.volume && (!op.slices.empty() || op.every > 0)) scene.sliced.push_back(number);
  if (op.data.volume && !op.isovalues.empty()) scene.isosurfaces.push_back(number);
  if (op.vis.type == VisType::Volume && op.vis.volumeRendering) scene.rendered.push_back(number);
}

using OtherScenes = std::span<const std::shared_ptr<const CompiledScene>>;

// Returns another scene's plan of the same isosurfaces; null if there is none.
const std::vector<int32_t>* isoMaskAmong(OtherScenes scenes, const CompiledOperator& op, int partition) {
  for (const auto& scene : scenes)
    for (const CompiledOperator& o : scene->operators) {
      if (o.data.volume != op.data.volume || o.summary != op.summary || o.isovalues != op.isovalues) continue;
      const auto part = o.parts.find(partition);
      if (part != o.parts.end()) return &part->second.isoMask;
    }
  return nullptr;
}

// Plans the macrocells of a volume and decides which partitions are visible. A partition is visible if
// something is in the cells that it touches or, because rays round, in the cells next to them. Ghost layers
// reach further.
void planVolume(CompiledOperator& op, CompiledScene& scene, OtherScenes known, const Advance& advance) {
  const Volume& volume = *op.data.volume;
  const RenderSpace& space = scene.space;
  const glm::dvec3 s = volume.grid.spacing;
  std::optional<double> others;
  if (scene.rendered.size() > 1) {
    others = 0;
    for (const CompiledOperator& o : scene.operators)
      if (&o != &op && o.data.volume) *others += largestExtinction(o);
  }
  const bool cut = std::any_of(scene.operators.begin(), scene.operators.end(), showsSurfaces);
  op.occludingExtinction = cut ? kAllOccluding : float(others.value_or(0));
  const double cellT = std::max({s.x, s.y, s.z}) * space.scale;
  for (const auto& [partition, block] : volume.blocks) {
    if (block.extent.count() == 0) continue;
    OperatorInPartition& part = op.parts[partition];
    part.block = &block;
    const auto& summaries = block.summaries.at(op.summary);
    if (op.vis.volumeRendering)
      part.plan = stepPlan(summaries, op.map, cellT, scene.settings.tolerance, scene.settings.step, others);
    if (anyIsosurface(summaries, op.isovalues)) {
      const std::vector<int32_t>* same = isoMaskAmong(known, op, partition);
      part.isoMask =
          same ? *same
               : isoMask(block, volume.stored, volume.components,
                         volume.components == 1 ? 0 : op.vis.component.value_or(-1), summaries, op.isovalues,
                         kMostIsoWords, partOf(advance, op.parts.size() - 1, volume.blocks.size()));
      scene.isoCellsSkipped += cellsWithoutIsovalue(part.isoMask, summaries.size());
    }
    const Extent near = extentOf(volume.grid, scene.partitioning->box(partition), 1);
    bool visible = anyMacrocell(block, near, [&](size_t i, const Index3& firstCell) {
      return (!part.plan.empty() && part.plan[i] != 0) ||
             (!part.isoMask.empty() && hasIsoCell(part.isoMask, i, firstCell, near));
    });
    visible = visible || op.every > 0;
    for (const CompiledPlane& p : op.slices)
      visible = visible || planeMeets(p, scene.partitioning->box(partition), space);
    if (visible) scene.visible[partition] = 1;
  }
}

// Spreads the lowest 10 bits of x, with two 0 bits between neighbours.
uint32_t spread(uint32_t x) {
  x = (x | x << 16) & 0x030000ff;
  x = (x | x << 8) & 0x0300f00f;
  x = (x | x << 4) & 0x030c30c3;
  return (x | x << 2) & 0x09249249;
}

// Orders primitives along Morton's curve through space, so that neighbours are close in memory. Which of two
// comes first depends only on their first corners and ids, and so is the same in all partitions. Ties between
// hits are decided by this order.
std::vector<uint32_t> alongCurve(const GeometryBlock& block, GeometryKind kind, const RenderSpace& space,
                                 const Advance& advance) {
  std::vector<uint64_t> places(block.ids.size());  // place on the curve in the upper 32 bits, index below
  const auto find = [&](size_t i) {
    const glm::dvec3 p = space.toRender(block.points[*primitivePoints(block, kind, i).begin()]);
    uint32_t place = 0;
    for (int a = 0; a < 3; a++) place |= spread(uint32_t(std::clamp((p[a] + 0.5) * 1024, 0.0, 1023.0))) << a;
    places[i] = uint64_t(place) << 32 | i;
  };
  parallelFor(size_t(0), places.size(), find, advance);
  parallelSort(places.begin(), places.end());
  return {places.begin(), places.end()};  // keeps the lower 32 bits, the indices
}

void compileGeometry(CompiledOperator& op, CompiledScene& scene, const Advance& advance) {
  const Geometry& geometry = *op.data.geometry;
  op.map = CompiledMap(effectiveColorMap(op.vis), nullptr, MapUnits{});
  CompiledGeometry compiled;
  if (!op.data.primitives)
    for (const auto& [partition, block] : geometry.blocks)
      if (!block.ids.empty())
        compiled[partition] = compilePrimitives(block, geometry.kind, op.vis, scene.space,
                                                partOf(advance, compiled.size(), geometry.blocks.size()));
  bool mapped = !geometry.range.empty();
  for (const auto& [partition, primitives] : op.data.primitives ? *op.data.primitives : compiled) {
    op.parts[partition].geometry = primitives;
    scene.visible[partition] = 1;
    mapped = mapped || !primitives->values.empty();
  }
  if (!mapped) op.map = CompiledMap(ColorMap{{ColorPoint{0, op.data.color}}}, nullptr, MapUnits{});
}

VisType typeFor(GeometryKind kind) {
  if (kind == GeometryKind::Particles) return VisType::Particles;
  return kind == GeometryKind::PathLines ? VisType::PathLines : VisType::Triangles;
}

}  // namespace

RenderSpace renderSpaceOf(const Partitioning& partitioning) {
  const Box& b = partitioning.domain();
  const glm::dvec3 size = b.hi - b.lo;
  const double longest = std::max({size.x, size.y, size.z});
  return {0.5 * b.lo + 0.5 * b.hi, longest > 0 ? 1 / longest : 1};
}

std::array<double, 4> radiiOf(const Vis& vis) {
  if (vis.type == VisType::Triangles) return {};
  return {vis.radius0, vis.radius1, vis.value0, vis.value1};
}

double radiusOf(const Vis& vis, double value) {
  if (vis.value0 == vis.value1 || std::isnan(value)) return std::max(0.0, vis.radius0);
  const double f = std::clamp((value - vis.value0) / (vis.value1 - vis.value0), 0.0, 1.0);
  return std::max(0.0, vis.radius0 + f * (vis.radius1 - vis.radius0));
}

double largestRadius(const Vis& vis, const Range& range) {
  if (vis.type == VisType::Triangles) return 0;
  const double withoutData = radiusOf(vis, std::numeric_limits<double>::quiet_NaN());
  if (range.empty()) return std::max(withoutData, radiusOf(vis, 0));
  return std::max({withoutData, radiusOf(vis, range.min), radiusOf(vis, range.max)});
}

size_t GeometryInPartition::bytes() const {
  return 4 * (points.size() + normals.size() + values.size() + colors.size() + indices.size() +
              neighbours.size() + orders.size() + corners.size() + shell.size() + unseen.size()) +
         bricks.size() * sizeof(Range);
}

size_t CompiledScene::bytes() const {
  size_t n = 0;
  for (const auto& op : operators) {
    n += (op.map.nodes.size() * 18 + op.map.buckets.size()) * 4;
    for (const auto& [partition, part] : op.parts) n += 4 * (part.plan.size() + part.isoMask.size());
  }
  return n;
}

std::vector<SharedBytes> CompiledScene::sharedBytes() const {
  std::vector<SharedBytes> shared;
  for (const auto& op : operators)
    for (const auto& [partition, part] : op.parts)
      for (const auto& geometry : {part.geometry, part.surfaces}) {
        if (!geometry) continue;
        shared.push_back({geometry.get(), geometry->bytes()});
        if (geometry->cells) shared.push_back({geometry->cells.get(), geometry->cells->bytes()});
      }
  return shared;
}

std::shared_ptr<const GeometryInPartition> compilePrimitives(const GeometryBlock& all, GeometryKind kind,
                                                             const Vis& vis, const RenderSpace& space,
                                                             const Advance& advance) {
  const Advance sorting = partOf(advance, 0, 3), gathering = partOf(advance, 1, 3),
                converting = partOf(advance, 2, 3);
  const std::vector<uint32_t> order = alongCurve(all, kind, space, sorting);
  const bool particles =
      kind == GeometryKind::Particles;  // They need no copy in order, as they share no points.
  const GeometryBlock ordered = particles ? GeometryBlock() : subset(all, kind, order, gathering);
  const GeometryBlock& block = particles ? all : ordered;
  const size_t points = block.points.size();
  auto compiled = std::make_shared<GeometryInPartition>();
  GeometryInPartition& part = *compiled;
  part.points.reserve(4 * points);
  part.values.reserve(block.values.size());
  part.normals.reserve(3 * block.normals.size());
  part.colors.reserve(3 * block.colors.size());
  for (size_t n = 0; n < points; n++) {
    tell(converting, n, points);
    const size_t i = particles ? order[n] : n;
    const glm::dvec3 p = space.toRender(block.points[i]);
    const double radius =
        kind == GeometryKind::Triangles ? 0 : radiusOf(vis, radiusValue(block, i)) * space.scale;
    for (double x : {p.x, p.y, p.z, radius}) part.points.push_back(float(x));
    if (!block.values.empty()) part.values.push_back(block.values[i]);
    const auto append = [i](std::vector<float>& to, const std::vector<glm::vec3>& from) {
      if (!from.empty()) to.insert(to.end(), {from[i].x, from[i].y, from[i].z});
    };
    append(part.normals, block.normals);
    append(part.colors, block.colors);
  }
  const auto append = [](auto& to, const auto& from) {
    to.reserve(to.size() +
               from.size() * std::tuple_size_v<typename std::decay_t<decltype(from)>::value_type>);
    for (const auto& numbers : from) to.insert(to.end(), std::begin(numbers), std::end(numbers));
  };
  append(part.indices, block.segments);
  append(part.indices, block.triangles);
  append(part.neighbours, block.neighbours);
  part.primitives = uint32_t(block.ids.size());
  return compiled;
}

std::shared_ptr<CompiledScene> compileScene(const Visualization& visualization,
                                            std::vector<OperatorData> data,
                                            std::shared_ptr<const Partitioning> partitioning,
                                            const RenderSettings& settings,
                                            std::span<const std::shared_ptr<const CompiledScene>> others,
                                            const Advance& advance) {
  auto scene = std::make_shared<CompiledScene>();
  scene->visualization = visualization;
  scene->settings = settings;
  scene->partitioning = partitioning;
  scene->space = renderSpaceOf(*partitioning);
  scene->visible.assign(partitioning->partitions(), 0);
  scene->cellPartition.assign(partitioning->cellPartition().begin(), partitioning->cellPartition().end());
  for (int a = 0; a < 3; a++) {
    for (double f : partitioning->faces(a))
      scene->faces[a].push_back(float((f - scene->space.centre[a]) * scene->space.scale));
    scene->faces[a].front() = -std::numeric_limits<float>::infinity();
    scene->faces[a].back() = std::numeric_limits<float>::infinity();
  }

  Box seen;
  double largestColor = 0;
  const size_t count = visualization.operators.size();
  for (size_t i = 0; i < count; i++) {
    CompiledOperator& op = scene->operators.emplace_back();
    op.vis = visualization.operators[i];
    op.data = data.at(i);
    const bool isVolume = op.vis.type == VisType::Volume;
    if (isVolume ? !op.data.volume && !op.data.mesh
                 : !op.data.geometry || typeFor(op.data.geometry->kind) != op.vis.type)
      throw Error("operator " + std::to_string(i + 1) + ": dataset \"" + op.vis.dataset +
                  "\" is not of the kind that this operator shows");
    for (const Plane& p : op.vis.clipPlanes) op.clips.push_back(compilePlane(p, scene->space));
    if (op.data.mesh) {
      compileMesh(op, *scene);
      for (const Plane& p : op.vis.slices) op.slices.push_back(compilePlane(p, scene->space));
      seen.extend(op.data.mesh->box);
    } else if (isVolume) {
      const Grid& grid = op.data.volume->grid;
      if (grid.rim)
        for (const Plane& p : planesAround(grid.box().lo, grid.box().hi))
          op.clips.push_back(compilePlane(p, scene->space));
      compileVolume(op, *scene);
      seen.extend(op.data.volume->grid.box());
    } else {
      compileGeometry(op, *scene, partOf(advance, i, 2 * count));
      Box b = op.data.geometry->box;
      const double r = largestRadius(op.vis, op.data.geometry->radiusRange.value_or(op.data.geometry->range));
      if (!b.empty()) seen.extend(Box{b.lo - r, b.hi + r});
    }
    listOperator(op, int32_t(i), *scene);
    if (showsSurfaces(op) && op.vis.opacity < 1) scene->opaqueSurfaces = false;
    const bool colored = !isVolume && op.data.geometry->colored;
    largestColor = std::max(largestColor, colored ? 1 : op.map.largestColor);
  }
  if (scene->rendered.size() > MANY_VOLUMES)
    throw Error("a visualization renders " + std::to_string(scene->rendered.size()) +
                " volumes at once, expected at most " + std::to_string(MANY_VOLUMES));
  if (scene->rendered.size() > 1)
    for (const int32_t i : scene->rendered)
      if (const CompiledOperator& op = scene->operators[size_t(i)]; op.data.mesh)
        throw Error(
            "dataset \"" + op.vis.dataset +
            "\": an unstructured volume cannot be rendered together with another volume yet, expected one "
            "rendered volume");
  for (size_t i = 0; i < count; i++) {
    CompiledOperator& op = scene->operators[i];
    const Advance planning = partOf(advance, count + i, 2 * count);
    if (op.data.volume) planVolume(op, *scene, others, planning);
    if (op.data.mesh) planMesh(op, *scene, others, planning);
  }
  if (seen.empty()) seen = partitioning->domain();
  const glm::dvec3 lo = scene->space.toRender(seen.lo), hi = scene->space.toRender(seen.hi), size = hi - lo;
  const double margin = kDomainMargin * std::max({size.x, size.y, size.z, 1e-3});
  scene->lo = lo - margin;
  scene->hi = hi + margin;
  const Lighting& l = visualization.lighting;
  scene->largestRadiance = std::max(1.0, l.Ka + l.Kd + l.Ks) * std::max(largestColor, 1e-3);
  scene->tMin = float(settings.tolerance * kEarlyEnd / scene->largestRadiance);
  return scene;
}

}  // namespace gxy

// SPDX-License-Identifier: Apache-2.0
#include "core/rays/compiled_mesh.h"

#include <cmath>
#include <string>

#include "core/comm/error.h"
#include "core/comm/parallel_for.h"
#include "core/scene/colormaps.h"

namespace gxy {

namespace {

// What the operator shows of a point's stored values.
class ShownValues {
 public:
  ShownValues(const CompiledOperator& op, const MeshBlock& block)
      : values_(block.values),
        components_(size_t(op.data.mesh->components)),
        component_(op.vis.component.value_or(-1)) {}

  float operator()(size_t point) const {
    const float* of = values_.data() + point * components_;
    if (components_ == 1) return of[0];
    if (component_ >= 0) return of[component_];
    float squares = 0;
    for (size_t c = 0; c < components_; c++) squares += of[c] * of[c];
    return std::sqrt(squares);
  }

  // Of all points; empty if none has a finite value.
  Range range() const {
    Range range;
    for (size_t p = 0; p * components_ < values_.size(); p++) range.extend(double((*this)(p)));
    return range;
  }

 private:
  const std::vector<float>& values_;
  const size_t components_;
  const int component_;
};

// Whether the map shows something of stored values in this range.
bool shows(const CompiledMap& map, const Range& range) {
  return !range.empty() && map.over(float(range.min), float(range.max)).extinction > 0;
}

// Returns the cells of another scene that shows the same values of the same mesh; null if there are none.
std::shared_ptr<const GeometryInPartition> cellsAmong(
    std::span<const std::shared_ptr<const CompiledScene>> scenes, const CompiledOperator& op,
    const RenderSpace& space, int partition) {
  for (const auto& scene : scenes)
    for (const CompiledOperator& o : scene->operators) {
      if (o.data.mesh != op.data.mesh || o.summary != op.summary || scene->space != space) continue;
      const auto part = o.parts.find(partition);
      if (part != o.parts.end()) return part->second.geometry;
    }
  return nullptr;
}

GeometryInPartition cellsOf(const MeshBlock& block, const ShownValues& shown, const RenderSpace& space,
                            const Advance& advance) {
  GeometryInPartition cells;
  cells.points.resize(block.points.size() * 4);
  parallelFor(
      size_t(0), block.points.size(),
      [&](size_t i) {
        const glm::dvec3 p = space.toRender(block.points[i]);
        for (int a = 0; a < 3; a++) cells.points[4 * i + size_t(a)] = float(p[a]);
        cells.points[4 * i + 3] = shown(i);
      },
      advance);
  cells.indices = block.cells.points[size_t(CellType::Tetrahedron)];
  cells.neighbours = block.neighbours[size_t(CellType::Tetrahedron)];
  cells.shell = block.shell;
  cells.primitives = uint32_t(block.shell.size());
  return cells;
}

}  // namespace

void compileMesh(CompiledOperator& op, const CompiledScene& scene) {
  const Mesh& mesh = *op.data.mesh;
  const auto refuse = [&](const char* what) {
    throw Error("dataset \"" + op.vis.dataset + "\": " + what +
                " of unstructured volumes cannot be shown yet, expected volume rendering alone");
  };
  if (!op.vis.isovalues.empty()) refuse("isosurfaces");
  if (!op.vis.slices.empty()) refuse("slices");
  if (op.vis.every > 0) refuse("places at equal distances");
  if (op.vis.component && *op.vis.component >= mesh.components)
    throw Error("dataset \"" + op.vis.dataset + "\": component " + std::to_string(*op.vis.component) +
                " was asked for, it has " + std::to_string(mesh.components) + " (counted from 0)");
  op.summary = mesh.components == 1 ? 0 : op.vis.component.value_or(mesh.components);
  const MapUnits units{mesh.shift, mesh.scale, 1 / scene.space.scale,
                       op.vis.referenceLength.value_or(typicalLength(mesh))};
  const OpacityMap opacity = effectiveOpacityMap(op.vis);
  op.map = CompiledMap(effectiveColorMap(op.vis), op.vis.volumeRendering ? &opacity : nullptr, units);
  Range stored = mesh.ranges.at(size_t(op.summary));
  if (!stored.empty())
    stored = {(stored.min - mesh.shift) / mesh.scale, (stored.max - mesh.shift) / mesh.scale};
  if (!shows(op.map, stored)) op.vis.volumeRendering = false;  // nothing of the mesh would be seen
}

void planMesh(CompiledOperator& op, CompiledScene& scene,
              std::span<const std::shared_ptr<const CompiledScene>> others, const Advance& advance) {
  if (!op.vis.volumeRendering) return;
  const auto& blocks = op.data.mesh->blocks;
  size_t done = 0;
  for (const auto& [partition, block] : blocks) {
    const Advance part = partOf(advance, done++, blocks.size());
    const ShownValues shown(op, block);
    if (block.shell.empty() || !shows(op.map, shown.range())) continue;
    auto& cells = op.parts[partition].geometry;
    cells = cellsAmong(others, op, scene.space, partition);
    if (!cells) cells = std::make_shared<const GeometryInPartition>(cellsOf(block, shown, scene.space, part));
    scene.visible[size_t(partition)] = 1;
  }
}

}  // namespace gxy

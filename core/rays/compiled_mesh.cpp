// SPDX-License-Identifier: Apache-2.0
#include "core/rays/compiled_mesh.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <iterator>
#include <optional>
#include <string>
#include <vector>

#include "core/comm/error.h"
#include "core/comm/parallel_for.h"
#include "core/kernels/single_views.h"
#include "core/rays/kernel_cells.h"
#include "core/scene/colormaps.h"

namespace gxy {

namespace {

constexpr size_t kWorthLeavingOut = 16;  // one brick in so many must not be seen

// The number of cells in a brick.
size_t brickSize(uint32_t corners) {
  return size_t(1) << (corners == 4 ? TETRAHEDRA_IN_BRICK : HEXAHEDRA_IN_BRICK);
}

using OtherScenes = std::span<const std::shared_ptr<const CompiledScene>>;

// What an operator shows of a block.
struct ShownValues {
  std::vector<float> points;
  std::vector<float> cells;  // empty if the data are those of points
  bool constant;             // whether cells are in their own values

  ShownValues(const CompiledOperator& op, const MeshBlock& block)
      : points(shownValues(block.values, op.data.mesh->components, op.vis.component)),
        cells(shownValues(block.cellValues, op.data.mesh->components, op.vis.component)),
        constant(showsConstantCells(op)) {}

  // Whether a cell of these points has data.
  bool hold(size_t cell, std::span<const uint32_t> corners) const {
    if (!cells.empty() && !std::isfinite(cells[cell])) return false;
    return std::all_of(corners.begin(), corners.end(), [&](uint32_t p) { return std::isfinite(points[p]); });
  }
};

Range rangeOf(std::span<const float> values) {
  Range range;
  for (const float v : values) range.extend(double(v));
  return range;
}

// Whether the map shows something of stored values in this range.
bool shows(const CompiledMap& map, const Range& range) {
  return !range.empty() && map.over(float(range.min), float(range.max)).extinction > 0;
}

bool showsSameValues(const CompiledOperator& a, const CompiledOperator& b) {
  return a.data.mesh == b.data.mesh && a.summary == b.summary && a.vis.cells == b.vis.cells;
}

bool showsSameSurfaces(const CompiledOperator& a, const CompiledOperator& b) {
  return showsSameValues(a, b) && a.isovalues == b.isovalues && a.slices == b.slices &&
         a.data.gradients == b.data.gradients;
}

// Returns what another scene has in the partition of an operator that is the same in this respect; null if there is none.
std::shared_ptr<const GeometryInPartition> partAmong(
    OtherScenes scenes, const CompiledOperator& op, const RenderSpace& space, int partition,
    std::shared_ptr<const GeometryInPartition> OperatorInPartition::*which,
    bool (*isSame)(const CompiledOperator&, const CompiledOperator&)) {
  for (const auto& scene : scenes)
    for (const CompiledOperator& o : scene->operators) {
      if (scene->space != space || !isSame(o, op)) continue;
      const auto part = o.parts.find(partition);
      if (part != o.parts.end() && part->second.*which) return part->second.*which;
    }
  return nullptr;
}

glm::vec3 placeIn(const RenderSpace& space, const glm::dvec3& point) {
  const glm::dvec3 p = space.toRender(point);
  return {float(p.x), float(p.y), float(p.z)};
}

// The ranges of values in bricks of cells.
std::vector<Range> brickRanges(const KernelCells& kernel, const ShownValues& shown, const Advance& advance) {
  const size_t size = brickSize(kernel.corners);
  std::vector<Range> bricks((kernel.size() + size - 1) / size);
  parallelFor(
      size_t(0), bricks.size(),
      [&](size_t i) {
        const size_t end = std::min((i + 1) * size, kernel.size());
        for (size_t cell = i * size; cell < end; cell++) {
          if (shown.constant) {
            bricks[i].extend(double(shown.cells[cell]));
          } else {
            for (const uint32_t p : kernel.pointsOf(cell)) bricks[i].extend(double(shown.points[p]));
          }
        }
      },
      advance);
  return bricks;
}

GeometryInPartition cellsOf(const MeshBlock& block, const KernelCells& kernel, const ShownValues& shown,
                            const RenderSpace& space, const Advance& advance) {
  GeometryInPartition cells;
  cells.points.resize(block.points.size() * 4);
  parallelFor(
      size_t(0), block.points.size(),
      [&](size_t i) {
        const glm::vec3 p = placeIn(space, block.points[i]);
        std::copy_n(&p.x, 3, &cells.points[4 * i]);
        cells.points[4 * i + 3] = shown.points[i];
      },
      advance);
  // Where values are those at points, the cells' own ones only say which are not seen.
  if (shown.constant ||
      std::any_of(shown.cells.begin(), shown.cells.end(), [](float v) { return !std::isfinite(v); }))
    cells.values = shown.cells;
  cells.indices.assign(kernel.points.begin(), kernel.points.end());
  cells.neighbours.assign(kernel.neighbours.begin(), kernel.neighbours.end());
  cells.orders = kernel.orders;
  cells.shell = kernel.shell;
  cells.primitives = uint32_t(cells.shell.size());
  cells.bricks = brickRanges(kernel, shown, advance);
  return cells;
}

bool isUnseen(const std::vector<uint32_t>& unseen, size_t brick) {
  return (unseen[brick / 32] >> brick % 32 & 1) != 0;
}

// The bricks of which the map shows nothing, a bit for each; empty if they are too few to be worth leaving them out.
std::vector<uint32_t> unseenBricks(const CompiledMap& map, const std::vector<Range>& bricks) {
  std::vector<uint32_t> unseen((bricks.size() + 31) / 32, 0);
  size_t count = 0;
  for (size_t i = 0; i < bricks.size(); i++) {
    if (shows(map, bricks[i])) continue;
    unseen[i / 32] |= 1u << i % 32;
    count++;
  }
  if (count * kWorthLeavingOut < bricks.size() || count == 0) unseen.clear();
  return unseen;
}

// The cells without the bricks that are not seen: what rays meet first is then the faces between these and others. Returns nothing if there
// are more such faces than cells left out.
std::optional<GeometryInPartition> withoutBricks(std::shared_ptr<const GeometryInPartition> cells,
                                                 uint32_t corners, std::vector<uint32_t> unseen,
                                                 const Advance& advance) {
  GeometryInPartition part;
  const size_t size = brickSize(corners), sides = corners == 4 ? 4 : 6;
  const auto hasUnseen = [&](FaceId face) { return isUnseen(unseen, cellOf(face) / size); };
  std::copy_if(cells->shell.begin(), cells->shell.end(), std::back_inserter(part.shell),
               [&](FaceId face) { return !hasUnseen(face); });
  const size_t count = cells->neighbours.size() / sides, shell = part.shell.size();
  size_t leftOut = 0;
  for (size_t brick = 0; brick < cells->bricks.size(); brick++)
    if (isUnseen(unseen, brick)) leftOut += std::min(size, count - brick * size);
  for (size_t brick = 0; brick < cells->bricks.size(); brick++) {
    if (isUnseen(unseen, brick)) continue;
    if (part.shell.size() > shell + leftOut) return std::nullopt;
    if (brick % 64 == 0) tell(advance, brick, cells->bricks.size());
    for (size_t cell = brick * size; cell < std::min((brick + 1) * size, count); cell++)
      for (size_t side = 0; side < sides; side++) {
        const FaceId behind = cells->neighbours[cell * sides + side];
        if (behind != kNoFace && hasUnseen(behind)) part.shell.push_back(faceId(uint32_t(cell), int(side)));
      }
  }
  part.primitives = uint32_t(part.shell.size());
  part.unseen = std::move(unseen);
  part.cells = std::move(cells);
  return part;
}

// The cells of a partition that rays go through, given all of them; null if there are none.
std::shared_ptr<const GeometryInPartition> seenCells(std::shared_ptr<const GeometryInPartition> cells,
                                                     const CompiledOperator& op, const CompiledScene& scene,
                                                     OtherScenes others, int partition,
                                                     const Advance& advance) {
  const MeshReport& report = op.data.mesh->report;
  // Where cells overlap at a face, those that are met first hide others, seen or not.
  if (report.foldedFaces > 0 || report.crowdedFaces > 0) return cells;
  std::vector<uint32_t> unseen = unseenBricks(op.map, cells->bricks);
  if (unseen.empty()) return cells;
  for (const auto& other : others)
    for (const CompiledOperator& o : other->operators) {
      if (other->space != scene.space || !showsSameValues(o, op)) continue;
      const auto part = o.parts.find(partition);
      if (part == o.parts.end() || !part->second.geometry) continue;
      const auto& made = part->second.geometry;
      if (made->cells == cells && made->unseen == unseen) return made;
    }
  auto part = withoutBricks(cells, hasOnlyTetrahedra(*op.data.mesh) ? 4 : 8, std::move(unseen), advance);
  if (!part) return cells;
  if (part->primitives == 0) return nullptr;
  return std::make_shared<const GeometryInPartition>(std::move(*part));
}

// The cells that the surfaces of an operator pass in one partition, one surface after the other.
class SurfaceCells {
 public:
  // `gradients`: x y z for each point, or null.
  SurfaceCells(const MeshBlock& block, const KernelCells& kernel, const ShownValues& shown,
               const std::vector<float>* gradients, const RenderSpace& space)
      : block_(block), kernel_(kernel), shown_(shown), gradients_(gradients), space_(space) {
    if (gradients) numbers_.resize(block.points.size(), kNone);
  }

  // Appends the cells that a surface passes, given the level at each point. It passes a cell if the level is above 0 at some of its
  // corners and not at others. A slice in a face of a cell is thus in the cell above it; where there is none, the cell below it has the
  // slice, with levels turned over.
  void add(std::span<const float> level, uint32_t surface, std::optional<float> isovalue,
           const Advance& advance) {
    const std::vector<Passed> passed = passedBy(level, !isovalue, advance);
    const size_t first = cells_.indices.size(), corners = kernel_.corners, all = first + passed.size();
    cells_.points.resize(4 * corners * all);
    cells_.values.resize(corners * all);
    if (!kernel_.orders.empty()) cells_.orders.resize(all);
    cells_.indices.resize(all, surface);
    parallelFor(size_t(0), passed.size(), [&](size_t i) {
      const auto [cell, ends] = passed[i];
      size_t corner = (first + i) * corners;
      for (const uint32_t p : kernel_.pointsOf(cell)) {
        const glm::vec3 place = placeIn(space_, block_.points[p]);
        std::copy_n(&place.x, 3, &cells_.points[4 * corner]);
        cells_.points[4 * corner + 3] = ends ? -level[p] : level[p];
        cells_.values[corner++] = isovalue.value_or(shown_.constant ? shown_.cells[cell] : shown_.points[p]);
      }
      if (!kernel_.orders.empty()) cells_.orders[first + i] = kernel_.orders[cell];
    });
    if (!gradients_) return;
    cells_.corners.resize(corners * all, 0);
    if (!isovalue) return;
    auto number = cells_.corners.begin() + std::ptrdiff_t(corners * first);
    for (const Passed& p : passed)
      for (const uint32_t point : kernel_.pointsOf(p.cell)) *number++ = numberOf(point);
  }
  GeometryInPartition take() { return std::move(cells_); }

 private:
  static constexpr uint32_t kNone = UINT32_MAX;

  struct Passed {
    uint32_t cell;
    bool ends;  // whether the surface is in an outer face, and the cell below it
  };

  // The cells that a surface passes, in their order.
  std::vector<Passed> passedBy(std::span<const float> level, bool isSlice, const Advance& advance) const {
    constexpr size_t kTogether = 8192;
    std::vector<std::vector<Passed>> found((kernel_.size() + kTogether - 1) / kTogether);
    parallelFor(size_t(0), found.size(), [&](size_t i) {
      tell(advance, i * kTogether, kernel_.size());
      for (size_t cell = i * kTogether; cell < std::min((i + 1) * kTogether, kernel_.size()); cell++) {
        const std::span<const uint32_t> at = kernel_.pointsOf(cell);
        const auto above = std::count_if(at.begin(), at.end(), [&](uint32_t p) { return level[p] > 0; });
        if (above == std::ptrdiff_t(at.size()) || (above == 0 && !isSlice) || !shown_.hold(cell, at))
          continue;
        if (above == 0) {
          uint32_t on = 0;
          for (size_t k = 0; k < at.size(); k++) on |= uint32_t(level[at[k]] == 0) << k;
          if (on == 0 || !kernel_.isOuterSide(cell, on)) continue;
        }
        found[i].push_back({uint32_t(cell), above == 0});
      }
    });
    std::vector<Passed> passed;
    for (const auto& some : found) passed.insert(passed.end(), some.begin(), some.end());
    return passed;
  }

  // The number of a point's gradient among those that are kept.
  uint32_t numberOf(uint32_t point) {
    uint32_t& number = numbers_[point];
    if (number == kNone) {
      number = uint32_t(cells_.normals.size() / 3);
      const float* const gradient = gradients_->data() + 3 * size_t(point);
      cells_.normals.insert(cells_.normals.end(), gradient, gradient + 3);
    }
    return number;
  }

  const MeshBlock& block_;
  const KernelCells& kernel_;
  const ShownValues& shown_;
  const std::vector<float>* const gradients_;
  const RenderSpace& space_;
  std::vector<uint32_t> numbers_;  // of the gradients of points, or kNone
  GeometryInPartition cells_;
};

// Returns the cells that the operator's surfaces pass; null if there are none.
std::shared_ptr<const GeometryInPartition> surfacesOf(const CompiledOperator& op, const MeshBlock& block,
                                                      int partition, const KernelCells& kernel,
                                                      const ShownValues& shown, const RenderSpace& space,
                                                      const Advance& advance) {
  const bool isSmooth = op.data.gradients && !op.isovalues.empty();
  SurfaceCells passed(block, kernel, shown, isSmooth ? &op.data.gradients->at(partition) : nullptr, space);
  std::vector<float> level(shown.points.size());
  const size_t count = op.slices.size() + op.isovalues.size();
  for (size_t surface = 0; surface < count; surface++) {
    const Advance part = partOf(advance, surface, count);
    std::optional<float> isovalue;
    if (surface < op.slices.size()) {
      const CompiledPlane& plane = op.slices[surface];
      const glm::dvec3 normal(plane.x, plane.y, plane.z);
      parallelFor(size_t(0), level.size(), [&](size_t p) {
        level[p] =
            float(glm::dot(normal, glm::dvec3(placeIn(space, block.points[p]))) - double(plane.offset));
      });
    } else {
      isovalue = op.isovalues[surface - op.slices.size()];
      for (size_t p = 0; p < level.size(); p++) level[p] = shown.points[p] - *isovalue;
    }
    passed.add(level, uint32_t(surface), isovalue, part);
  }
  GeometryInPartition cells = passed.take();
  if (cells.indices.empty()) return nullptr;
  const size_t most =
      kernel.corners == 4 ? size_t(1) << 28 : size_t(1) << 27;  // arrays have at most 2^32 numbers
  if (cells.indices.size() >= most)
    throw Error("dataset \"" + op.vis.dataset + "\": surfaces pass " + std::to_string(cells.indices.size()) +
                " cells of one partition, expected fewer than " + std::to_string(most) +
                "; cut the data into more partitions");
  cells.primitives = uint32_t(cells.indices.size());
  return std::make_shared<const GeometryInPartition>(std::move(cells));
}

}  // namespace

void compileMesh(CompiledOperator& op, const CompiledScene& scene) {
  const Mesh& mesh = *op.data.mesh;
  if (op.vis.every > 0)
    throw Error(
        "dataset \"" + op.vis.dataset +
        "\": rays cannot meet an unstructured volume at equal distances yet, expected isosurfaces or slices");
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
  // Nothing of the mesh would be seen. Averages of cells may be outside of the cells' range, as ghosts count for them.
  if (!mesh.ofCells && !shows(op.map, stored)) op.vis.volumeRendering = false;
  for (const double v : op.vis.isovalues) op.isovalues.push_back(float((v - mesh.shift) / mesh.scale));
}

std::optional<std::string> warningOf(const Vis& vis, const Mesh& mesh) {
  if (!mesh.ofCells || vis.cells == CellsShown::Smooth || vis.isovalues.empty()) return std::nullopt;
  return "dataset \"" + vis.dataset +
         "\": its data are those of cells, and isosurfaces are those of averages at points; `cells`: "
         "\"smooth\" shows "
         "these everywhere";
}

void planMesh(CompiledOperator& op, CompiledScene& scene, OtherScenes others, const Advance& advance) {
  const auto& blocks = op.data.mesh->blocks;
  size_t done = 0;
  for (const auto& entry : blocks) {
    const int partition = entry.first;
    const MeshBlock& block = entry.second;
    const Advance part = partOf(advance, done++, blocks.size());
    const ShownValues shown(op, block);
    OperatorInPartition planned;
    std::optional<KernelCells> kernel;
    const auto kernelCellsOnce = [&]() -> const KernelCells& {
      if (!kernel) kernel = kernelCells(block, hasOnlyTetrahedra(*op.data.mesh));
      return *kernel;
    };
    if (op.vis.volumeRendering && !block.shell.empty() &&
        shows(op.map, rangeOf(shown.constant ? shown.cells : shown.points))) {
      planned.geometry =
          partAmong(others, op, scene.space, partition, &OperatorInPartition::geometry, showsSameValues);
      if (!planned.geometry)
        planned.geometry = std::make_shared<const GeometryInPartition>(
            cellsOf(block, kernelCellsOnce(), shown, scene.space, partOf(part, 0, 2)));
      if (planned.geometry->cells) planned.geometry = planned.geometry->cells;
      planned.geometry =
          seenCells(std::move(planned.geometry), op, scene, others, partition, partOf(part, 0, 2));
    }
    if (!op.isovalues.empty() || !op.slices.empty()) {
      planned.surfaces =
          partAmong(others, op, scene.space, partition, &OperatorInPartition::surfaces, showsSameSurfaces);
      if (!planned.surfaces)
        planned.surfaces =
            surfacesOf(op, block, partition, kernelCellsOnce(), shown, scene.space, partOf(part, 1, 2));
    }
    if (!planned.geometry && !planned.surfaces) continue;
    op.parts[partition] = std::move(planned);
    scene.visible[size_t(partition)] = 1;
  }
}

}  // namespace gxy

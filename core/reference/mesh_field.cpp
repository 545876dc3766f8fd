// SPDX-License-Identifier: Apache-2.0
#include "core/reference/mesh_field.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numeric>
#include <set>
#include <string>
#include <tuple>

#include "core/comm/error.h"

namespace gxy::reference {
namespace {

/// Points at the same place get the same number.
std::vector<uint32_t> numberedByPlace(const std::vector<glm::dvec3>& points) {
  std::vector<uint32_t> order(points.size()), numbers(points.size());
  std::iota(order.begin(), order.end(), 0u);
  const auto place = [&](uint32_t i) { return std::tie(points[i].x, points[i].y, points[i].z); };
  std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return place(a) < place(b); });
  for (size_t k = 0; k < order.size(); k++)
    numbers[order[k]] = k > 0 && place(order[k - 1]) == place(order[k]) ? numbers[order[k - 1]] : order[k];
  return numbers;
}

double trueValue(const Mesh& mesh, const MeshBlock& block, size_t point, std::optional<int> component) {
  const float* stored = &block.values[point * size_t(mesh.components)];
  const auto part = [&](int c) { return mesh.shift + mesh.scale * double(stored[c]); };
  if (component) return part(*component);
  if (mesh.components == 1) return part(0);
  double squares = 0;
  for (int c = 0; c < mesh.components; c++) squares += part(c) * part(c);
  return std::sqrt(squares);
}

}  // namespace

MeshField::MeshField(const Mesh& mesh, std::optional<int> component)
    : box_(mesh.box), typicalLength_(gxy::typicalLength(mesh)) {
  if (component && (*component < 0 || *component >= mesh.components)) {
    throw Error("reference: mesh '" + mesh.name + "' has no component " + std::to_string(*component) +
                ": expected 0 to " + std::to_string(mesh.components - 1));
  }
  std::vector<Cell> cells;
  for (const auto& [partition, block] : mesh.blocks) {
    const auto& corners = block.cells.points[size_t(CellType::Tetrahedron)];
    if (block.cells.size() * 4 != corners.size())
      throw Error("reference: mesh '" + mesh.name + "' has cells that are no tetrahedra");
    if (block.values.size() < block.points.size() * size_t(mesh.components))
      throw Error("reference: mesh '" + mesh.name + "' has fewer values than points");
    const auto first = uint32_t(points_.size());
    points_.insert(points_.end(), block.points.begin(), block.points.end());
    for (size_t i = 0; i < block.points.size(); i++) values_.push_back(trueValue(mesh, block, i, component));
    for (size_t i = 0; i < corners.size(); i += 4)
      cells.push_back(
          {first + corners[i], first + corners[i + 1], first + corners[i + 2], first + corners[i + 3]});
  }
  const std::vector<uint32_t> numbers =
      mesh.blocks.size() > 1 ? numberedByPlace(points_) : std::vector<uint32_t>();
  std::set<Cell> seen;
  std::vector<Box> boxes;
  for (Cell cell : cells) {
    if (!numbers.empty())
      for (uint32_t& corner : cell) corner = numbers[corner];
    std::sort(cell.begin(), cell.end());
    if (!numbers.empty() && !seen.insert(cell).second) continue;
    if (!std::all_of(cell.begin(), cell.end(), [&](uint32_t p) { return std::isfinite(values_[p]); }))
      continue;
    boxes.push_back(boxAround(cornersOf(cell)));
    cells_.push_back(cell);
  }
  tree_.emplace(boxes);
}

Tetrahedron MeshField::cornersOf(const Cell& cell) const {
  return {points_[cell[0]], points_[cell[1]], points_[cell[2]], points_[cell[3]]};
}

std::array<double, 4> MeshField::valuesOf(const Cell& cell) const {
  return {values_[cell[0]], values_[cell[1]], values_[cell[2]], values_[cell[3]]};
}

std::vector<MeshSpan> MeshField::along(const Ray& ray, Interval range) const {
  std::vector<MeshSpan> spans;
  tree_->traverse(
      ray, range.lo, [&] { return range.hi; },
      [&](uint32_t index) {
        const Cell& cell = cells_[index];
        const auto passage = passageThrough(cornersOf(cell), ray);
        if (!passage) return;
        const auto& [front, back] = *passage;
        if (front.t == back.t || !(back.t > range.lo && front.t < range.hi)) return;
        spans.push_back({front.t, back.t, front.mean(valuesOf(cell)), back.mean(valuesOf(cell))});
      });
  std::sort(spans.begin(), spans.end(), [](const MeshSpan& a, const MeshSpan& b) {
    return std::tie(a.t0, a.t1, a.value0, a.value1) < std::tie(b.t0, b.t1, b.value0, b.value1);
  });
  return spans;
}

MeshSurface MeshField::isosurface(double isovalue) const {
  std::vector<LevelCell> cells;
  for (const Cell& cell : cells_) {
    const std::array<double, 4> values = valuesOf(cell);
    std::array<double, 4> levels = values;
    for (double& level : levels) level -= isovalue;
    if (isPassed(levels)) cells.push_back({cornersOf(cell), levels, values});
  }
  return MeshSurface(std::move(cells));
}

MeshSurface MeshField::slice(const Plane& plane) const {
  std::vector<LevelCell> cells;
  for (const Cell& cell : cells_) {
    const Tetrahedron corners = cornersOf(cell);
    std::array<double, 4> levels;
    for (size_t i = 0; i < 4; i++) levels[i] = glm::dot(plane.normal, corners[i]) - plane.offset;
    if (isPassed(levels)) cells.push_back({corners, levels, valuesOf(cell)});
  }
  return MeshSurface(std::move(cells));
}

}  // namespace gxy::reference

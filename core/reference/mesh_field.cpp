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

/// How far a cubic along a ray may be from the field of a cell, as a part of the range of the cell's values.
constexpr double kTolerance = 1e-7;

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
  std::vector<Corners> tetrahedra;
  std::vector<Other> others;
  for (const auto& [partition, block] : mesh.blocks) {
    if (block.values.size() < block.points.size() * size_t(mesh.components))
      throw Error("reference: mesh '" + mesh.name + "' has fewer values than points");
    const auto first = uint32_t(points_.size());
    points_.insert(points_.end(), block.points.begin(), block.points.end());
    for (size_t i = 0; i < block.points.size(); i++) values_.push_back(trueValue(mesh, block, i, component));
    addCells(block, first, tetrahedra, others);
  }
  const std::vector<uint32_t> numbers =
      mesh.blocks.size() > 1 ? numberedByPlace(points_) : std::vector<uint32_t>();
  std::vector<Box> boxes;
  std::set<Corners> seen;
  for (Corners cell : tetrahedra) {
    if (!numbers.empty())
      for (uint32_t& corner : cell) corner = numbers[corner];
    std::sort(cell.begin(), cell.end());
    if ((!numbers.empty() && !seen.insert(cell).second) || !haveData(cell)) continue;
    boxes.push_back(boxAround(cornersOf(cell)));
    tetrahedra_.push_back(cell);
  }
  std::set<std::array<uint32_t, 8>> seenOthers;
  for (Other& cell : others) {
    const auto points = std::span(cell.points).first(shapeOf(cell.type).points);
    if (!numbers.empty()) {
      for (uint32_t& corner : points) corner = numbers[corner];
      std::array<uint32_t, 8> key;
      key.fill(UINT32_MAX);
      std::copy(points.begin(), points.end(), key.begin());
      std::sort(key.begin(), key.end());
      if (!seenOthers.insert(key).second) continue;
    }
    if (!haveData(points)) continue;
    boxes.push_back(boxAround(cornersOf(cell).corners()));
    others_.push_back(cell);
  }
  tree_.emplace(boxes);
}

void MeshField::addCells(const MeshBlock& block, uint32_t firstPoint, std::vector<Corners>& tetrahedra,
                         std::vector<Other>& others) const {
  const auto& corners = block.cells.points[size_t(CellType::Tetrahedron)];
  for (size_t i = 0; i + 4 <= corners.size(); i += 4)
    tetrahedra.push_back({firstPoint + corners[i], firstPoint + corners[i + 1], firstPoint + corners[i + 2],
                          firstPoint + corners[i + 3]});
  for (const CellType type : {CellType::Pyramid, CellType::Wedge, CellType::Hexahedron}) {
    const auto& points = block.cells.points[size_t(type)];
    const size_t n = shapeOf(type).points;
    for (size_t i = 0; i + n <= points.size(); i += n) {
      Other cell{type};
      for (size_t k = 0; k < n; k++) cell.points[k] = firstPoint + points[i + k];
      others.push_back(cell);
    }
  }
}

bool MeshField::haveData(std::span<const uint32_t> points) const {
  return std::all_of(points.begin(), points.end(), [&](uint32_t p) { return std::isfinite(values_[p]); });
}

Tetrahedron MeshField::cornersOf(const Corners& cell) const {
  return {points_[cell[0]], points_[cell[1]], points_[cell[2]], points_[cell[3]]};
}

BentCell MeshField::cornersOf(const Other& cell) const {
  BentCell bent{cell.type, {}, cell.points};
  for (size_t k = 0; k < shapeOf(cell.type).points; k++) bent.corner[k] = points_[cell.points[k]];
  return bent;
}

std::array<double, 4> MeshField::valuesOf(const Corners& cell) const {
  return {values_[cell[0]], values_[cell[1]], values_[cell[2]], values_[cell[3]]};
}

OfCorners MeshField::valuesOf(const Other& cell) const {
  OfCorners values{};
  for (size_t k = 0; k < shapeOf(cell.type).points; k++) values[k] = values_[cell.points[k]];
  return values;
}

std::vector<MeshSpan> MeshField::along(const Ray& ray, Interval range) const {
  /// The part of a ray in one cell. Its spans stay together, also if cells overlap.
  struct Part {
    double t0, t1, value0, value1;
    std::vector<MeshSpan> spans;
  };
  std::vector<Part> parts;
  const auto isMet = [&](double t0, double t1) { return t1 > range.lo && t0 < range.hi; };
  const auto alongTetrahedron = [&](const Corners& cell) {
    const auto passage = passageThrough(cornersOf(cell), ray);
    if (!passage) return;
    const auto& [front, back] = *passage;
    if (front.t == back.t || !isMet(front.t, back.t)) return;
    const double value0 = front.mean(valuesOf(cell)), value1 = back.mean(valuesOf(cell));
    const Cubic linear{{value0, mix(value0, value1, 1 / 3.0), mix(value0, value1, 2 / 3.0), value1}};
    parts.push_back({front.t, back.t, value0, value1, {{front.t, back.t, linear}}});
  };
  const auto alongOther = [&](const Other& cell) {
    const BentCell bent = cornersOf(cell);
    const OfCorners values = valuesOf(cell);
    const auto [low, high] = std::minmax_element(values.begin(), values.begin() + shapeOf(cell.type).points);
    const CellOnRay on(bent, ray);
    for (const CellPassage& passage : on.passages()) {
      if (passage.in.t == passage.out.t || !isMet(passage.in.t, passage.out.t)) continue;
      Part part{passage.in.t, passage.out.t, passage.in.mean(values), passage.out.mean(values), {}};
      for (const CellStretch& one : on.stretches(passage, values, kTolerance * (*high - *low)))
        if (isMet(one.t0, one.t1)) part.spans.push_back({one.t0, one.t1, one.value});
      parts.push_back(std::move(part));
    }
  };
  tree_->traverse(
      ray, range.lo, [&] { return range.hi; },
      [&](uint32_t index) {
        if (index < tetrahedra_.size()) {
          alongTetrahedron(tetrahedra_[index]);
        } else {
          alongOther(others_[index - tetrahedra_.size()]);
        }
      });
  std::sort(parts.begin(), parts.end(), [](const Part& a, const Part& b) {
    return std::tie(a.t0, a.t1, a.value0, a.value1) < std::tie(b.t0, b.t1, b.value0, b.value1);
  });
  std::vector<MeshSpan> spans;
  for (const Part& part : parts) spans.insert(spans.end(), part.spans.begin(), part.spans.end());
  return spans;
}

MeshSurface MeshField::isosurface(double isovalue) const {
  return surface([&](uint32_t point) { return values_[point] - isovalue; }, LevelKind::Values);
}

MeshSurface MeshField::slice(const Plane& plane) const {
  return surface([&](uint32_t point) { return glm::dot(plane.normal, points_[point]) - plane.offset; },
                 LevelKind::Distances);
}

MeshSurface MeshField::surface(const std::function<double(uint32_t)>& levelOf, LevelKind kind) const {
  std::vector<LevelCell> tetrahedra;
  for (const Corners& cell : tetrahedra_) {
    std::array<double, 4> levels;
    for (size_t i = 0; i < 4; i++) levels[i] = levelOf(cell[i]);
    if (isPassed(levels)) tetrahedra.push_back({cornersOf(cell), levels, valuesOf(cell)});
  }
  std::vector<LevelBentCell> others;
  for (const Other& cell : others_) {
    OfCorners levels{};
    const size_t n = shapeOf(cell.type).points;
    for (size_t i = 0; i < n; i++) levels[i] = levelOf(cell.points[i]);
    if (isPassed(std::span(levels).first(n))) others.push_back({cornersOf(cell), levels, valuesOf(cell)});
  }
  return MeshSurface(std::move(tetrahedra), std::move(others), kind);
}

}  // namespace gxy::reference

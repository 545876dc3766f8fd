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

/// Of a point or a cell, given the stored values of all.
double trueValue(const Mesh& mesh, const std::vector<float>& values, size_t place,
                 std::optional<int> component) {
  const float* stored = &values[place * size_t(mesh.components)];
  const auto part = [&](int c) { return mesh.shift + mesh.scale * double(stored[c]); };
  if (component) return part(*component);
  if (mesh.components == 1) return part(0);
  double squares = 0;
  for (int c = 0; c < mesh.components; c++) squares += part(c) * part(c);
  return std::sqrt(squares);
}

/// Each corner of a cell with three of its neighbours along edges, in all ways.
std::vector<std::array<uint8_t, 4>> cornersWithNeighbours(CellType type) {
  std::vector<std::array<uint8_t, 4>> all;
  const CellShape& shape = shapeOf(type);
  for (uint8_t corner = 0; corner < shape.points; corner++) {
    std::set<uint8_t> neighbours;
    for (const CellFace& face : std::span(shape.face).first(shape.faces))
      for (size_t k = 0; k < face.corners; k++)
        if (face.corner[k] == corner) neighbours.insert(face.corner[(k + 1) % face.corners]);
    const std::vector<uint8_t> at(neighbours.begin(), neighbours.end());
    for (size_t i = 0; i < at.size(); i++)
      for (size_t j = i + 1; j < at.size(); j++)
        for (size_t k = j + 1; k < at.size(); k++) all.push_back({corner, at[i], at[j], at[k]});
  }
  return all;
}

}  // namespace

MeshField::MeshField(const Mesh& mesh, std::optional<int> component, CellsShown shown)
    : box_(mesh.box), typicalLength_(gxy::typicalLength(mesh)) {
  if (component && (*component < 0 || *component >= mesh.components)) {
    throw Error("reference: mesh '" + mesh.name + "' has no component " + std::to_string(*component) +
                ": expected 0 to " + std::to_string(mesh.components - 1));
  }
  Cells all;
  for (const auto& [partition, block] : mesh.blocks) {
    const auto each = size_t(mesh.components);
    if (block.values.size() < block.points.size() * each ||
        (mesh.ofCells && block.cellValues.size() < block.cells.size() * each))
      throw Error("reference: mesh '" + mesh.name + "' has fewer values than points or cells");
    const auto first = uint32_t(points_.size());
    points_.insert(points_.end(), block.points.begin(), block.points.end());
    for (size_t i = 0; i < block.points.size(); i++)
      values_.push_back(trueValue(mesh, block.values, i, component));
    addCells(mesh, block, component, first, all);
  }
  const std::vector<uint32_t> numbers =
      mesh.blocks.size() > 1 ? numberedByPlace(points_) : std::vector<uint32_t>();
  const bool constant = mesh.ofCells && shown == CellsShown::Flat;
  std::vector<Box> boxes;
  std::set<Corners> seen;
  for (size_t i = 0; i < all.tetrahedra.size(); i++) {
    Corners cell = all.tetrahedra[i];
    if (!numbers.empty())
      for (uint32_t& corner : cell) corner = numbers[corner];
    std::sort(cell.begin(), cell.end());
    if ((!numbers.empty() && !seen.insert(cell).second) || !haveData(cell, all.tetrahedronValues[i]))
      continue;
    boxes.push_back(boxAround(cornersOf(cell)));
    tetrahedra_.push_back(cell);
    if (constant) tetrahedronValues_.push_back(all.tetrahedronValues[i]);
  }
  std::set<std::array<uint32_t, 8>> seenOthers;
  for (size_t i = 0; i < all.others.size(); i++) {
    Other& cell = all.others[i];
    const auto points = std::span(cell.points).first(shapeOf(cell.type).points);
    if (!numbers.empty()) {
      for (uint32_t& corner : points) corner = numbers[corner];
      std::array<uint32_t, 8> key;
      key.fill(UINT32_MAX);
      std::copy(points.begin(), points.end(), key.begin());
      std::sort(key.begin(), key.end());
      if (!seenOthers.insert(key).second) continue;
    }
    if (!haveData(points, all.otherValues[i])) continue;
    boxes.push_back(boxAround(cornersOf(cell).corners()));
    others_.push_back(cell);
    if (constant) otherValues_.push_back(all.otherValues[i]);
  }
  tree_.emplace(boxes);
  gradients_ = gradients();
}

void MeshField::addCells(const Mesh& mesh, const MeshBlock& block, std::optional<int> component,
                         uint32_t firstPoint, Cells& cells) const {
  size_t number = 0;
  const auto ownValue = [&] {
    return mesh.ofCells ? trueValue(mesh, block.cellValues, number++, component) : 0;
  };
  const auto& corners = block.cells.points[size_t(CellType::Tetrahedron)];
  for (size_t i = 0; i + 4 <= corners.size(); i += 4) {
    cells.tetrahedra.push_back({firstPoint + corners[i], firstPoint + corners[i + 1],
                                firstPoint + corners[i + 2], firstPoint + corners[i + 3]});
    cells.tetrahedronValues.push_back(ownValue());
  }
  for (const CellType type : {CellType::Pyramid, CellType::Wedge, CellType::Hexahedron}) {
    const auto& points = block.cells.points[size_t(type)];
    const size_t n = shapeOf(type).points;
    for (size_t i = 0; i + n <= points.size(); i += n) {
      Other cell{type};
      for (size_t k = 0; k < n; k++) cell.points[k] = firstPoint + points[i + k];
      cells.others.push_back(cell);
      cells.otherValues.push_back(ownValue());
    }
  }
}

bool MeshField::haveData(std::span<const uint32_t> points, double own) const {
  return std::isfinite(own) &&
         std::all_of(points.begin(), points.end(), [&](uint32_t p) { return std::isfinite(values_[p]); });
}

Tetrahedron MeshField::cornersOf(const Corners& cell) const {
  return {points_[cell[0]], points_[cell[1]], points_[cell[2]], points_[cell[3]]};
}

BentCell MeshField::cornersOf(const Other& cell) const {
  BentCell bent{cell.type, {}, cell.points};
  for (size_t k = 0; k < shapeOf(cell.type).points; k++) bent.corner[k] = points_[cell.points[k]];
  return bent;
}

std::array<double, 4> MeshField::valuesOfTetrahedron(size_t cell) const {
  std::array<double, 4> values{};
  for (size_t k = 0; k < 4; k++)
    values[k] = tetrahedronValues_.empty() ? values_[tetrahedra_[cell][k]] : tetrahedronValues_[cell];
  return values;
}

OfCorners MeshField::valuesOfOther(size_t cell) const {
  OfCorners values{};
  for (size_t k = 0; k < shapeOf(others_[cell].type).points; k++)
    values[k] = otherValues_.empty() ? values_[others_[cell].points[k]] : otherValues_[cell];
  return values;
}

std::vector<MeshSpan> MeshField::along(const Ray& ray, Interval range) const {
  /// The part of a ray in one cell. Its spans stay together, also if cells overlap.
  struct Part {
    double t0, t1, value0, value1;
    std::vector<MeshSpan> spans;
  };
  std::vector<Part> parts;
  const bool constant = !tetrahedronValues_.empty() || !otherValues_.empty();
  const auto isMet = [&](double t0, double t1) { return t1 > range.lo && t0 < range.hi; };
  const auto alongTetrahedron = [&](size_t cell) {
    const auto passage = passageThrough(cornersOf(tetrahedra_[cell]), ray);
    if (!passage) return;
    const auto& [front, back] = *passage;
    if (front.t == back.t || !isMet(front.t, back.t)) return;
    const std::array<double, 4> values = valuesOfTetrahedron(cell);
    const double value0 = constant ? values[0] : front.mean(values),
                 value1 = constant ? values[0] : back.mean(values);
    const Cubic linear{{value0, mix(value0, value1, 1 / 3.0), mix(value0, value1, 2 / 3.0), value1}};
    parts.push_back({front.t, back.t, value0, value1, {{front.t, back.t, linear}}});
  };
  const auto alongOther = [&](size_t cell) {
    const BentCell bent = cornersOf(others_[cell]);
    const OfCorners values = valuesOfOther(cell);
    const auto [low, high] = std::minmax_element(values.begin(), values.begin() + shapeOf(bent.type).points);
    const CellOnRay on(bent, ray);
    for (const CellPassage& passage : on.passages()) {
      if (passage.in.t == passage.out.t || !isMet(passage.in.t, passage.out.t)) continue;
      Part part{passage.in.t, passage.out.t, passage.in.mean(values), passage.out.mean(values), {}};
      if (constant) {
        part.spans.push_back(
            {passage.in.t, passage.out.t, Cubic{{values[0], values[0], values[0], values[0]}}});
        parts.push_back(std::move(part));
        continue;
      }
      for (const CellStretch& one : on.stretches(passage, values, kTolerance * (*high - *low)))
        if (isMet(one.t0, one.t1)) part.spans.push_back({one.t0, one.t1, one.value});
      parts.push_back(std::move(part));
    }
  };
  tree_->traverse(
      ray, range.lo, [&] { return range.hi; },
      [&](uint32_t index) {
        if (index < tetrahedra_.size()) {
          alongTetrahedron(index);
        } else {
          alongOther(index - tetrahedra_.size());
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

std::vector<glm::dvec3> MeshField::gradients() const {
  std::vector<glm::dvec3> sums(points_.size(), glm::dvec3(0));
  std::vector<double> volumes(points_.size(), 0);
  const auto addAt = [&](uint32_t point, const std::array<uint32_t, 3>& others) {
    std::array<glm::dvec3, 3> edge;
    glm::dvec3 rise;
    for (int i = 0; i < 3; i++) {
      edge[size_t(i)] = points_[others[size_t(i)]] - points_[point];
      rise[i] = values_[others[size_t(i)]] - values_[point];
    }
    const auto& [b, c, d] = edge;
    const double volume = glm::dot(b, glm::cross(c, d));
    volumes[point] += std::abs(volume);
    sums[point] += (volume < 0 ? -1.0 : 1.0) *
                   (rise.x * glm::cross(c, d) + rise.y * glm::cross(d, b) + rise.z * glm::cross(b, c));
  };
  std::array<std::vector<std::array<uint8_t, 4>>, kCellTypes> corners;
  for (const CellType type : kAllCellTypes) corners[size_t(type)] = cornersWithNeighbours(type);
  const auto addCell = [&](CellType type, const uint32_t* points) {
    for (const auto& [corner, b, c, d] : corners[size_t(type)])
      addAt(points[corner], {points[b], points[c], points[d]});
  };
  for (const Corners& cell : tetrahedra_) addCell(CellType::Tetrahedron, cell.data());
  for (const Other& cell : others_) addCell(cell.type, cell.points.data());
  for (size_t p = 0; p < sums.size(); p++)
    if (volumes[p] > 0) sums[p] /= volumes[p];
  return sums;
}

MeshSurface MeshField::surface(const std::function<double(uint32_t)>& levelOf, LevelKind kind) const {
  const auto slopeAt = [&](uint32_t point) {
    return kind == LevelKind::Values ? gradients_[point] : glm::dvec3(0);
  };
  std::vector<LevelCell> tetrahedra;
  for (size_t cell = 0; cell < tetrahedra_.size(); cell++) {
    std::array<double, 4> levels;
    for (size_t i = 0; i < 4; i++) levels[i] = levelOf(tetrahedra_[cell][i]);
    if (!isPassed(levels)) continue;
    tetrahedra.push_back({cornersOf(tetrahedra_[cell]), levels, valuesOfTetrahedron(cell)});
    for (size_t i = 0; i < 4; i++) tetrahedra.back().gradients[i] = slopeAt(tetrahedra_[cell][i]);
  }
  std::vector<LevelBentCell> others;
  for (size_t cell = 0; cell < others_.size(); cell++) {
    OfCorners levels{};
    const size_t n = shapeOf(others_[cell].type).points;
    for (size_t i = 0; i < n; i++) levels[i] = levelOf(others_[cell].points[i]);
    if (!isPassed(std::span(levels).first(n))) continue;
    others.push_back({cornersOf(others_[cell]), levels, valuesOfOther(cell)});
    for (size_t i = 0; i < n; i++) others.back().gradients[i] = slopeAt(others_[cell].points[i]);
  }
  return MeshSurface(std::move(tetrahedra), std::move(others), kind);
}

}  // namespace gxy::reference

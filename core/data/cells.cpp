// SPDX-License-Identifier: Apache-2.0
#include "core/data/cells.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "core/data/polygon.h"

namespace gxy {

void appendLine(std::span<const uint32_t> points, GeometryBlock& block) {
  const size_t n = points.size();
  for (size_t i = 0; i + 1 < n; ++i) {
    block.segments.push_back({points[i], points[i + 1]});
    block.neighbours.push_back({points[i > 0 ? i - 1 : 0], points[std::min(i + 2, n - 1)]});
  }
}

void appendTriangles(DrawnCellType type, std::span<const uint32_t> points, GeometryBlock& block) {
  const auto add = [&](size_t a, size_t b, size_t c) {
    block.triangles.push_back({points[a], points[b], points[c]});
  };
  if (type == DrawnCellType::TriangleStrip) {
    for (size_t i = 0; i + 2 < points.size(); ++i) add(i + i % 2, i + 1 - i % 2, i + 2);
  } else if (points.size() == 3) {
    add(0, 1, 2);
  } else {
    std::vector<uint32_t> around(points.begin(), points.end());
    if (type == DrawnCellType::Pixel && around.size() == 4) std::swap(around[2], around[3]);
    std::vector<glm::dvec3> corners;
    for (const uint32_t point : around) corners.push_back(block.points[point]);
    std::vector<std::array<uint32_t, 3>> cut;
    triangulate(corners, cut);
    for (const auto& [a, b, c] : cut) block.triangles.push_back({around[a], around[b], around[c]});
  }
}

void splitByCell(GeometryBlock& block, GeometryKind kind, std::span<const int64_t> cells,
                 const std::function<void(GeometryBlock&, int64_t)>& give) {
  constexpr auto kNone = std::numeric_limits<int64_t>::min();
  GeometryBlock split;
  split.fields = emptyLike(block.fields);
  std::vector<int64_t> cellOf(block.points.size(), kNone);  // by point: the cell that used it last
  std::vector<uint32_t> number(block.points.size());
  for (size_t p = 0; p < cells.size(); ++p) {
    const auto own = [&](uint32_t& point) {
      if (cellOf[point] != cells[p]) {
        cellOf[point] = cells[p];
        number[point] = uint32_t(split.points.size());
        split.points.push_back(block.points[point]);
        if (!block.normals.empty()) split.normals.push_back(block.normals[point]);
        if (!block.radiusValues.empty()) split.radiusValues.push_back(block.radiusValues[point]);
        appendFields(split.fields, block.fields, point);
        give(split, cells[p]);
      }
      point = number[point];
    };
    if (kind == GeometryKind::PathLines) {
      for (uint32_t& point : block.segments[p]) own(point);
      for (uint32_t& point : block.neighbours[p]) own(point);
    } else {
      for (uint32_t& point : block.triangles[p]) own(point);
    }
  }
  block.points = std::move(split.points);
  block.normals = std::move(split.normals);
  block.values = std::move(split.values);
  block.colors = std::move(split.colors);
  block.radiusValues = std::move(split.radiusValues);
  block.fields = std::move(split.fields);
}

}  // namespace gxy

// SPDX-License-Identifier: Apache-2.0
#include "core/io/drawn_cells.h"

#include <vtkCellType.h>
#include <vtkDataSetAttributes.h>
#include <vtkIdList.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <limits>
#include <numeric>

#include "core/data/polygon.h"

namespace gxy {
namespace {

constexpr unsigned char kNotThere = vtkDataSetAttributes::REFINEDCELL | vtkDataSetAttributes::HIDDENCELL;
constexpr unsigned char kPointsNotDrawn =
    vtkDataSetAttributes::DUPLICATEPOINT | vtkDataSetAttributes::HIDDENPOINT;

std::span<const vtkIdType> spanOf(vtkIdList* ids) {
  return {ids->GetPointer(0), size_t(ids->GetNumberOfIds())};
}

/// Returns the points of a line in the order along it.
std::vector<uint32_t> along(int type, std::span<const vtkIdType> ids) {
  if (type == VTK_QUADRATIC_EDGE && ids.size() == 3)
    return {uint32_t(ids[0]), uint32_t(ids[2]), uint32_t(ids[1])};
  return {ids.begin(), ids.end()};
}

void addPolyline(GeometryBlock& block, const std::vector<uint32_t>& ids) {
  const size_t n = ids.size();
  for (size_t i = 0; i + 1 < n; ++i) {
    block.segments.push_back({ids[i], ids[i + 1]});
    block.neighbours.push_back({ids[i > 0 ? i - 1 : 0], ids[std::min(i + 2, n - 1)]});
  }
}

}  // namespace

bool isDrawn(vtkUnsignedCharArray* pointGhosts, vtkIdType point) {
  return !pointGhosts || !(pointGhosts->GetValue(point) & kPointsNotDrawn);
}

bool isFlat(int type) {
  const CellShape* shape = shapeOf(type);
  return type == VTK_TRIANGLE || type == VTK_QUAD || type == VTK_POLYGON || type == VTK_TRIANGLE_STRIP ||
         type == VTK_PIXEL || (shape && !shape->solid);
}

bool isLine(int type) { return type == VTK_LINE || type == VTK_POLY_LINE || type == VTK_QUADRATIC_EDGE; }

bool isSolid(int type) {
  const CellShape* shape = shapeOf(type);
  return shape && shape->solid;
}

DrawnCells::DrawnCells(vtkPointSet* set, GeometryKind kind, const TakeMemory& toTake, Flaws& flaws)
    : set_(set),
      list_(set),
      kind_(kind),
      ghosts_(set->GetCellGhostArray()),
      ghostPoints_(set->GetPointGhostArray()),
      ids_(vtkSmartPointer<vtkIdList>::New()) {
  int64_t faces = 0;
  for (vtkIdType cell = 0; cell < list_.count(); ++cell) {
    const int type = list_.type(cell);
    const bool solid = isSolid(type);
    if (kind == GeometryKind::PathLines ? !isLine(type) : !isFlat(type) && !solid) {
      ++unused_;
      continue;
    }
    primitives_ += primitivesOf(cell, type, flaws);
    if (solid) faces += int64_t(shapeOf(type)->faces.size());
  }
  if (faces == 0) return;
  const bool allThere = !ghosts_ && !ghostPoints_;
  if (toTake) toTake(faces * kBytesPerFace);
  outer_ = outerFaces(set, allThere, [this](vtkIdType cell) { return isThere(cell); });
  for (const OuterFace& outer : outer_)
    primitives_ += trianglesOf(shapeOf(list_.type(outer.cell))->faces[size_t(outer.face)]);
}

bool DrawnCells::isThere(vtkIdType cell) const {
  if (ghosts_ && (ghosts_->GetValue(cell) & kNotThere)) return false;
  if (!ghostPoints_) return true;
  list_.points(cell, ids_);
  const auto ids = spanOf(ids_);
  return std::none_of(ids.begin(), ids.end(), [&](vtkIdType id) {
    return ghostPoints_->GetValue(id) & vtkDataSetAttributes::HIDDENPOINT;
  });
}

/// Whether a cell duplicates another piece's. It is not drawn here, but its faces hide those of the cells
/// beside it.
bool DrawnCells::isOthers(vtkIdType cell) const {
  return ghosts_ && (ghosts_->GetValue(cell) & vtkDataSetAttributes::DUPLICATECELL);
}

size_t DrawnCells::primitivesOf(vtkIdType cell, int type, Flaws& flaws) {
  list_.points(cell, ids_);
  const size_t points = size_t(ids_->GetNumberOfIds()), fewer = kind_ == GeometryKind::PathLines ? 1 : 2;
  const auto place = [&] { return "cell " + std::to_string(cell); };
  if (const CellShape* shape = shapeOf(type)) {
    if (points == size_t(shape->points) && shape->solid) return 0;  // The constructor counts its outer faces.
    if (points == size_t(shape->points)) return trianglesOf(shape->faces[0]);
    flaws.add("a cell whose number of points is not that of its type is left out", place);
    return 0;
  }
  if (points <= fewer)
    flaws.add(fewer == 1 ? "a line of fewer than 2 points is left out"
                         : "a face of fewer than 3 corners is left out",
              place);
  return points <= fewer ? 0 : points - fewer;
}

void DrawnCells::addFlat(GeometryBlock& block, int type) const {
  const auto ids = spanOf(ids_);
  const auto add = [&](size_t a, size_t b, size_t c) {
    block.triangles.push_back({uint32_t(ids[a]), uint32_t(ids[b]), uint32_t(ids[c])});
  };
  if (const CellShape* shape = shapeOf(type)) {
    if (ids.size() == size_t(shape->points)) appendFace(set_, shape->faces[0], ids, block.triangles);
  } else if (type == VTK_TRIANGLE_STRIP) {
    for (size_t i = 0; i + 2 < ids.size(); ++i) add(i + i % 2, i + 1 - i % 2, i + 2);
  } else if (ids.size() == 3) {
    add(0, 1, 2);
  } else {
    std::vector<glm::dvec3> corners;
    std::vector<vtkIdType> around(ids.begin(), ids.end());
    if (type == VTK_PIXEL) std::swap(around[2], around[3]);
    for (vtkIdType id : around) {
      const double* p = set_->GetPoint(id);
      corners.push_back({p[0], p[1], p[2]});
    }
    std::vector<std::array<uint32_t, 3>> cut;
    triangulate(corners, cut);
    for (const auto& [a, b, c] : cut)
      block.triangles.push_back({uint32_t(around[a]), uint32_t(around[b]), uint32_t(around[c])});
  }
}

void DrawnCells::addTo(GeometryBlock& block, std::vector<vtkIdType>* cells) const {
  auto outer = outer_.begin();
  for (vtkIdType cell = 0; cell < list_.count(); ++cell) {
    const int type = list_.type(cell);
    const auto first = outer;
    while (outer != outer_.end() && outer->cell == cell) ++outer;
    if (isOthers(cell) || !isThere(cell)) continue;
    list_.points(cell, ids_);
    if (kind_ == GeometryKind::PathLines) {
      if (isLine(type)) addPolyline(block, along(type, spanOf(ids_)));
    } else if (isSolid(type)) {
      for (auto face = first; face != outer; ++face)
        appendFace(set_, shapeOf(type)->faces[size_t(face->face)], spanOf(ids_), block.triangles);
    } else if (isFlat(type)) {
      addFlat(block, type);
    }
    if (cells)
      cells->resize(kind_ == GeometryKind::PathLines ? block.segments.size() : block.triangles.size(), cell);
  }
}

void splitByCell(GeometryBlock& block, GeometryKind kind, const std::vector<vtkIdType>& cells,
                 const std::function<void(GeometryBlock&, vtkIdType)>& give) {
  constexpr auto kNone = std::numeric_limits<vtkIdType>::min();
  GeometryBlock split;
  std::vector<vtkIdType> cellOf(block.points.size(), kNone);  // by point: the cell that used it last
  std::vector<uint32_t> number(block.points.size());
  for (size_t p = 0; p < cells.size(); ++p) {
    const auto own = [&](uint32_t& point) {
      if (cellOf[point] != cells[p]) {
        cellOf[point] = cells[p];
        number[point] = uint32_t(split.points.size());
        split.points.push_back(block.points[point]);
        if (!block.normals.empty()) split.normals.push_back(block.normals[point]);
        if (!block.radiusValues.empty()) split.radiusValues.push_back(block.radiusValues[point]);
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
}

}  // namespace gxy

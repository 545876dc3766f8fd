// SPDX-License-Identifier: Apache-2.0
#include "core/io/drawn_cells.h"

#include <vtkCellType.h>
#include <vtkDataSetAttributes.h>
#include <vtkIdList.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>

#include "core/data/cells.h"

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

}  // namespace

bool isDrawn(vtkUnsignedCharArray* pointGhosts, vtkIdType point) {
  return !pointGhosts || !(pointGhosts->GetValue(point) & kPointsNotDrawn);
}

bool isFlat(int type) {
  const DrawnCellShape* shape = shapeOf(type);
  return becomesTriangles(type) || (shape && !shape->solid);
}

bool isLine(int type) { return becomesLines(type) || type == VTK_QUADRATIC_EDGE; }

bool isSolid(int type) {
  const DrawnCellShape* shape = shapeOf(type);
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
  if (const DrawnCellShape* shape = shapeOf(type)) {
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

void DrawnCells::addFlat(GeometryBlock& block, int type, std::vector<uint32_t>& points) const {
  const auto ids = spanOf(ids_);
  if (const DrawnCellShape* shape = shapeOf(type)) {
    if (ids.size() == size_t(shape->points)) appendFace(set_, shape->faces[0], ids, block.triangles);
  } else {
    points.assign(ids.begin(), ids.end());
    appendTriangles(DrawnCellType(type), points, block);
  }
}

void DrawnCells::addTo(GeometryBlock& block, std::vector<int64_t>* cells) const {
  auto outer = outer_.begin();
  std::vector<uint32_t> points;
  for (vtkIdType cell = 0; cell < list_.count(); ++cell) {
    const int type = list_.type(cell);
    const auto first = outer;
    while (outer != outer_.end() && outer->cell == cell) ++outer;
    if (isOthers(cell) || !isThere(cell)) continue;
    list_.points(cell, ids_);
    if (kind_ == GeometryKind::PathLines) {
      if (isLine(type)) appendLine(along(type, spanOf(ids_)), block);
    } else if (isSolid(type)) {
      for (auto face = first; face != outer; ++face)
        appendFace(set_, shapeOf(type)->faces[size_t(face->face)], spanOf(ids_), block.triangles);
    } else if (isFlat(type)) {
      addFlat(block, type, points);
    }
    if (cells)
      cells->resize(kind_ == GeometryKind::PathLines ? block.segments.size() : block.triangles.size(), cell);
  }
}

}  // namespace gxy

// SPDX-License-Identifier: Apache-2.0
// The cells of a point set by number, including cells of polygonal data with too few points, for which
// vtkPolyData gives no access by number. Used inside core/io only, by files that include VTK.
#pragma once
#include <vtkCellArray.h>
#include <vtkCellType.h>
#include <vtkIdList.h>
#include <vtkPointSet.h>
#include <vtkPolyData.h>

#include <array>

#include "core/io/file.h"

namespace gxy {

/// The set must outlive the list. One thread at a time may use it.
class CellList {
 public:
  explicit CellList(vtkPointSet* set) : set_(set) {
    if (const auto mesh = vtkPolyData::SafeDownCast(set))
      kinds_ = {mesh->GetVerts(), mesh->GetLines(), mesh->GetPolys(), mesh->GetStrips()};
  }

  vtkIdType count() const { return set_->GetNumberOfCells(); }

  int type(vtkIdType cell) const {
    if (!kinds_[0]) return set_->GetCellType(cell);
    const size_t kind = kindOf(cell);
    const vtkIdType points = kinds_[kind]->GetCellSize(cell);
    constexpr int kMany[] = {VTK_POLY_VERTEX, VTK_POLY_LINE, VTK_POLYGON, VTK_TRIANGLE_STRIP};
    if (kind == 0 && points == 1) return VTK_VERTEX;
    if (kind == 1 && points == 2) return VTK_LINE;
    if (kind == 2 && points == 3) return VTK_TRIANGLE;
    return kind == 2 && points == 4 ? VTK_QUAD : kMany[kind];
  }

  /// Gets the points of a cell. Calls ReadWatch's check for every 65536th cell.
  void points(vtkIdType cell, vtkIdList* ids) const {
    if (cell % 65536 == 0) ReadWatch::check();
    if (!kinds_[0]) return set_->GetCellPoints(cell, ids);
    const size_t kind = kindOf(cell);
    kinds_[kind]->GetCellAtId(cell, ids);
  }

 private:
  /// Returns the array that contains a cell. `cell` becomes its number in that array.
  size_t kindOf(vtkIdType& cell) const {
    size_t kind = 0;
    for (; kind < 3 && cell >= kinds_[kind]->GetNumberOfCells(); ++kind)
      cell -= kinds_[kind]->GetNumberOfCells();
    return kind;
  }

  vtkPointSet* set_;
  std::array<vtkCellArray*, 4> kinds_{};  ///< polygonal data's, in the order of cell numbers; else null
};

}  // namespace gxy

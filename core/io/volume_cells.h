// SPDX-License-Identifier: Apache-2.0
// The cells of a grid by number, as unstructured volumes take them. Used inside core/io only, by files that include VTK.
#pragma once
#include <vtkStructuredGrid.h>

#include <array>
#include <cstdint>

#include "core/io/cell_list.h"

namespace gxy {

/// Cells of a structured grid are hexahedra between its points (i, j, k), or flat if it has one point along an axis. VTK's own access to
/// them takes away those of hidden points, which here are cells without data as they are in unstructured grids. The set must outlive the
/// list. One thread at a time may use it.
class VolumeCells {
 public:
  explicit VolumeCells(vtkPointSet* set) : list_(set) {
    const auto lattice = vtkStructuredGrid::SafeDownCast(set);
    if (!lattice) return;
    int n[3];
    lattice->GetDimensions(n);
    size_t dimension = 0;
    for (size_t a = 0; a < 3; a++) {
      n_[a] = n[a];
      dimension += n[a] > 1;
    }
    constexpr std::array<int, 4> kOfDimension{VTK_VERTEX, VTK_LINE, VTK_QUAD, VTK_HEXAHEDRON};
    latticeType_ = kOfDimension[dimension];
  }

  vtkIdType count() const { return list_.count(); }

  int type(vtkIdType cell) const { return latticeType_ ? latticeType_ : list_.type(cell); }

  /// Gets the points of a cell. Of flat cells of a structured grid there are none. Calls ReadWatch's check for every 65536th cell.
  void points(vtkIdType cell, vtkIdList* ids) const {
    if (!latticeType_) return list_.points(cell, ids);
    if (cell % 65536 == 0) ReadWatch::check();
    ids->Reset();
    if (latticeType_ != VTK_HEXAHEDRON) return;
    const vtkIdType i = cell % (n_[0] - 1), j = cell / (n_[0] - 1) % (n_[1] - 1),
                    k = cell / ((n_[0] - 1) * (n_[1] - 1));
    for (const vtkIdType above : {0, 1})
      for (const vtkIdType corner : {0, 1, 2, 3}) {
        const vtkIdType x = corner == 1 || corner == 2, y = corner >= 2;
        ids->InsertNextId(i + x + n_[0] * (j + y + n_[1] * (k + above)));
      }
  }

 private:
  CellList list_;
  int latticeType_ = 0;  ///< of all cells of a structured grid; 0 for other sets
  std::array<vtkIdType, 3> n_{};
};

}  // namespace gxy

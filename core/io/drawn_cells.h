// SPDX-License-Identifier: Apache-2.0
// The cells of a set that are drawn, as the primitives that they become. Used inside core/io only, by files that see VTK.
#pragma once
#include <vtkPointSet.h>

#include <vector>

#include "core/data/geometry.h"
#include "core/io/cell_faces.h"
#include "core/io/cell_list.h"
#include "core/io/flaws.h"
#include "core/io/geometry_file.h"

namespace gxy {

/// Points that are no particles: another piece's and hidden ones. Cells of hidden points are not drawn.
bool isDrawn(vtkUnsignedCharArray* pointGhosts, vtkIdType point);

/// Whether cells of a type become triangles by themselves, or segments.
bool isFlat(int vtkType);
bool isLine(int vtkType);
/// Whether cells of a type have an outer surface.
bool isSolid(int vtkType);

/// The cells of a set that become path lines or triangles: all of that kind but those that VTK does not draw either (another
/// piece's, those that finer ones stand for, hidden ones and those of hidden points). The set is kept by its owner.
class DrawnCells {
 public:
  /// `toTake`, if any, is told what comparing the faces of solid cells takes. `flaws` is told of cells of too few points.
  DrawnCells(vtkPointSet* set, GeometryKind kind, const TakeMemory& toTake, Flaws& flaws);

  size_t primitives() const { return primitives_; }  ///< the most that there can be
  uint64_t unused() const { return unused_; }        ///< cells of other kinds

  /// Adds the primitives, in the order of cells, and to `cells`, if there is one, the cell of each.
  void addTo(GeometryBlock& block, std::vector<vtkIdType>* cells) const;

 private:
  bool isThere(vtkIdType cell) const;
  bool isOthers(vtkIdType cell) const;
  size_t primitivesOf(vtkIdType cell, int type, Flaws& flaws);
  void addFlat(GeometryBlock& block, int type) const;

  vtkPointSet* const set_;
  const CellList list_;
  const GeometryKind kind_;
  vtkUnsignedCharArray *const ghosts_, *const ghostPoints_;
  vtkSmartPointer<vtkIdList> ids_;  ///< of the cell that is looked at
  std::vector<OuterFace> outer_;
  size_t primitives_ = 0;
  uint64_t unused_ = 0;
};

/// Gives each primitive of a block points of its cell's own (those of one cell share them), one colour a cell: for each point added,
/// give(split, cell) adds the value or colour of its cell. `cells`: of each primitive, in runs.
void splitByCell(GeometryBlock& block, GeometryKind kind, const std::vector<vtkIdType>& cells,
                 const std::function<void(GeometryBlock& split, vtkIdType cell)>& give);

}  // namespace gxy

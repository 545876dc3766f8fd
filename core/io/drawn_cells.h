// SPDX-License-Identifier: Apache-2.0
// Turns the cells of a point set into primitives. Used inside core/io only, by files that include VTK.
#pragma once
#include <vtkPointSet.h>

#include <vector>

#include "core/data/geometry.h"
#include "core/io/cell_faces.h"
#include "core/io/cell_list.h"
#include "core/io/flaws.h"
#include "core/io/geometry_file.h"

namespace gxy {

/// Whether a point is drawn as a particle: it is neither hidden nor a duplicate of another piece's point.
bool isDrawn(vtkUnsignedCharArray* pointGhosts, vtkIdType point);

/// Whether each cell of a type becomes triangles, or segments.
bool isFlat(int vtkType);
bool isLine(int vtkType);
/// Whether cells of a type have an outer surface.
bool isSolid(int vtkType);

/// The cells of a set that become path lines or triangles. Left out are cells that VTK does not draw either:
/// duplicates of another piece's cells, refined cells, hidden cells and cells with hidden points. The set
/// must outlive the object.
class DrawnCells {
 public:
  /// `toTake`, if not empty, is called with the bytes that comparing the faces of solid cells takes. `flaws`
  /// gets cells with too few points.
  DrawnCells(vtkPointSet* set, GeometryKind kind, const TakeMemory& toTake, Flaws& flaws);

  size_t primitives() const { return primitives_; }  ///< an upper bound
  uint64_t unused() const { return unused_; }        ///< number of cells of other kinds

  /// Appends the primitives in the order of cells; the points are in the block. If `cells` is not null, appends the cell of each
  /// primitive to it.
  void addTo(GeometryBlock& block, std::vector<int64_t>* cells) const;

 private:
  bool isThere(vtkIdType cell) const;
  bool isOthers(vtkIdType cell) const;
  size_t primitivesOf(vtkIdType cell, int type, Flaws& flaws);
  /// `points` is memory for the cell's.
  void addFlat(GeometryBlock& block, int type, std::vector<uint32_t>& points) const;

  vtkPointSet* const set_;
  const CellList list_;
  const GeometryKind kind_;
  vtkUnsignedCharArray *const ghosts_, *const ghostPoints_;
  vtkSmartPointer<vtkIdList> ids_;  ///< points of the current cell
  std::vector<OuterFace> outer_;
  size_t primitives_ = 0;
  uint64_t unused_ = 0;
};

}  // namespace gxy

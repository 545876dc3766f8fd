// SPDX-License-Identifier: Apache-2.0
// The cells that a ray crosses, and the field along it in each.
#pragma once
#include "core/reference/cubic.h"
#include "core/reference/field.h"
#include "core/reference/ray.h"

namespace gxy::reference {

/// Steps through the cells of a grid along a ray from t = 0 on, in order. The t at which the ray crosses face
/// i of an axis is one function of (ray, axis, i), so neighbouring cells agree on it to the bit; cells that
/// the ray only grazes (an edge, a corner) are left out. A ray inside a face belongs to the cell above it.
///
///     for (CellWalk walk(grid, ray); walk.inside(); walk.advance()) ...
class CellWalk {
 public:
  CellWalk(const Grid& grid, const Ray& ray);

  bool inside() const { return inside_; }
  void advance();

  const Index3& cell() const { return cell_; }
  double entry() const { return entry_; }  ///< t, >= 0
  double exit() const { return exit_; }    ///< t, > entry()
  bool last() const { return exit_ >= end_; }

  /// Where the ray is at t = entry() or exit(), in the cell's own [0,1]^3; exactly 0 or 1 on faces.
  glm::dvec3 local(double t) const;

 private:
  double face(int axis, int64_t i) const { return (double(i) - origin_[axis]) / direction_[axis]; }
  void start();
  void findExit();

  Index3 cells_;                   ///< number of cells
  glm::dvec3 origin_, direction_;  ///< of the ray, in grid indices
  Index3 cell_{};
  double entry_ = 0, exit_ = 0, end_ = 0;
  bool inside_ = false;
};

/// The field along the ray between two points of a cell, given in the cell's own coordinates (the blossoms of
/// the trilinear form).
Cubic alongRay(const CellCorners& corners, glm::dvec3 from, glm::dvec3 to);

}  // namespace gxy::reference

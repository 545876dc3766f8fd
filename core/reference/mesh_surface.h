// SPDX-License-Identifier: Apache-2.0
// Isosurfaces and slices of unstructured volumes, along rays.
#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "core/reference/bvh.h"
#include "core/reference/tetrahedron.h"

namespace gxy::reference {

/// A cell with a level, which is linear in it: value - isovalue, or the distance to the plane of a slice.
struct LevelCell {
  Tetrahedron corners;
  std::array<double, 4> levels, values;  ///< at the corners
};

/// Whether the surface passes a cell with these levels at its corners.
bool isPassed(const std::array<double, 4>& levels);

/// Where a ray meets the surface in a cell.
struct MeshCrossing {
  double t;
  double value;
  uint32_t cell;
};

/// The surface that bounds the places with a level > 0 from those with a level <= 0, inside the cells alone. A ray crosses it in a cell
/// if exactly one of the levels where it enters and leaves the cell is > 0. If two cells have the corners of their common face in the
/// same order, no ray near it misses the surface or crosses it twice. Where two parts of the surface touch, a ray crosses both.
/// Immutable; safe to use from any thread.
class MeshSurface {
 public:
  /// Takes the cells that the surface passes.
  explicit MeshSurface(std::vector<LevelCell> cells);

  /// The crossing in one of the cells.
  std::optional<MeshCrossing> crossing(uint32_t cell, const Ray& ray) const;
  /// All crossings in `range`, by (t, cell).
  std::vector<MeshCrossing> along(const Ray& ray, Interval range = {}) const;

  /// The unit vector towards higher levels; `flat` if the levels of the cell have no gradient.
  glm::dvec3 upwards(uint32_t cell, glm::dvec3 flat) const;
  /// The value `aside` from a crossing, not beyond those at the corners of its cell.
  double valueNear(const MeshCrossing& crossing, glm::dvec3 aside) const;

  const LevelCell& cell(uint32_t i) const { return cells_[i]; }
  size_t cells() const { return cells_.size(); }
  /// Of the cells.
  const Bvh& tree() const { return *tree_; }

 private:
  std::vector<LevelCell> cells_;
  std::optional<Bvh> tree_;
};

}  // namespace gxy::reference

// SPDX-License-Identifier: Apache-2.0
// How points move in a cell of a vector field, in the cell's reference coordinates.
#pragma once
#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>

#include "core/analysis/mesh_reader.h"

namespace gxy {

/// The vectors of one cell of a mesh with three components. If x(q) is the cell's map from reference coordinates to the world and v(q) the
/// velocity that its shape functions have there, then places move by dq/dt = (dx/dq)^-1 v(q). That is smooth in the cell and a little
/// beyond, so a step of an integration needs nothing but this cell, and no place is ever searched for.
class CellMotion {
 public:
  /// `sign` is 1, or -1 for motion against the field.
  CellMotion(const Mesh& mesh, const MeshBlock& block, uint32_t cell, double sign);

  CellType type() const { return corners_.type(); }
  const CellCorners& corners() const { return corners_; }
  /// Whether all vectors are finite, and the cell's own one where the data are those of cells.
  bool hasData() const { return hasData_; }
  /// The length of the largest differences of its vectors' components.
  double spread() const { return spread_; }

  glm::dvec3 worldAt(glm::dvec3 place) const;
  glm::dvec3 velocityAt(glm::dvec3 place) const;  ///< world units per unit of time
  double speedAt(glm::dvec3 place) const;
  /// The velocity in reference coordinates; nothing where the map has no inverse.
  std::optional<glm::dvec3> rateAt(glm::dvec3 place) const;

 private:
  CellCorners corners_;
  std::array<glm::dvec3, 8> velocity_;
  bool hasData_;
  double spread_;
  /// Of a tetrahedron, whose map is linear: the rates at its corners.
  std::optional<std::array<glm::dvec3, 4>> rates_;
};

/// A number made of the places of a cell's points. Two cells of a mesh hardly ever have the same one.
uint64_t keyOf(const MeshBlock& block, uint32_t cell);

}  // namespace gxy

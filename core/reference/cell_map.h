// SPDX-License-Identifier: Apache-2.0
// The maps of cells from reference coordinates to space.
#pragma once
#include <array>
#include <glm/vec3.hpp>
#include <optional>
#include <span>

#include "core/data/mesh.h"
#include "core/reference/cell_face.h"

namespace gxy::reference {

/// The shape functions of a cell, by corner, and their derivatives in reference coordinates.
struct ShapeFunctions {
  OfCorners weight{};
  std::array<glm::dvec3, 8> slope{};

  double mean(const OfCorners& values) const;
  glm::dvec3 mean(std::span<const glm::dvec3> points) const;
};

/// Evaluates the shape functions of a cell. They are those of VTK's linear cells, in coordinates in which maps have
/// no poles:
/// - tetrahedron: (a, b, c) with 1 - a - b - c, a, b and c barycentric;
/// - hexahedron: (u, v, w), trilinear in the unit cube;
/// - wedge: (a, b, w) with 1 - a - b, a and b barycentric in its triangles, and w from the first to the second one;
/// - pyramid: (u r, v r, r), where r is 1 in the base and 0 at the top, and (u, v) is the place in the base from which a line to the top
///   goes through the point.
ShapeFunctions shapeAt(CellType type, glm::dvec3 place);

/// The reference coordinates of a corner.
glm::dvec3 placeOfCorner(CellType type, size_t corner);

/// Where a map takes the value of a point.
struct MapInverse {
  glm::dvec3 place;
  double noise;  ///< about how far rounding moves the place
};

/// Inverts the map that takes the cell's corners to `points`: by Newton's method from `guess`, with steps that are halved until they come
/// nearer. Returns none if it does not end at the point, inside the cell or up to `slack` outside of it, in reference coordinates.
std::optional<MapInverse> invert(CellType type, std::span<const glm::dvec3> points, glm::dvec3 target,
                                 glm::dvec3 guess, double slack = 1e-9);

/// The derivatives of a map by reference coordinates.
class Jacobian {
 public:
  Jacobian(const ShapeFunctions& shape, std::span<const glm::dvec3> points);

  /// Whether it has an inverse.
  bool isRegular() const;
  /// The step in reference coordinates of a step in space.
  glm::dvec3 inReference(glm::dvec3 step) const;
  /// The gradient in space of what has these derivatives by reference coordinates.
  glm::dvec3 inSpace(glm::dvec3 derivatives) const;
  /// An upper bound of the lengths of inReference() of unit vectors.
  double inverseNorm() const;

 private:
  std::array<glm::dvec3, 3> column_, across_;
  double determinant_;
};

/// The derivatives by reference coordinates of what has these values at the corners.
glm::dvec3 derivativesOf(const ShapeFunctions& shape, const OfCorners& values);

}  // namespace gxy::reference

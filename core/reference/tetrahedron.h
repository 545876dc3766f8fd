// SPDX-License-Identifier: Apache-2.0
// Where a ray goes through a tetrahedron.
#pragma once
#include <algorithm>
#include <array>
#include <glm/vec3.hpp>
#include <optional>
#include <span>

#include "core/data/box.h"
#include "core/reference/ray.h"

namespace gxy::reference {

using Tetrahedron = std::array<glm::dvec3, 4>;

/// The point where a ray goes through a face.
struct FacePoint {
  double t;
  std::array<double, 4>
      weights;  ///< barycentric, of the corners; never negative, and 0 for the corner that is not on the face

  /// What is linear in the cell and has these values at its corners. It is not beyond those of the face, as rounding may put it.
  double mean(const std::array<double, 4>& corners) const {
    double sum = 0, low = kInfinity, high = -kInfinity;
    for (size_t i = 0; i < 4; i++) {
      if (weights[i] == 0) continue;
      sum += weights[i] * corners[i];
      low = std::min(low, corners[i]);
      high = std::max(high, corners[i]);
    }
    return std::clamp(sum, low, high);
  }
};

/// Returns the two points where a ray's line goes through the faces of a tetrahedron, by ascending t; none where it misses the cell.
/// A ray through a vertex, an edge or along a face is taken as one that is moved by an infinitesimal distance, so it goes through
/// exactly those cells around it that fill the space without overlap. If two cells have the corners of their common face in the same
/// order, t and means have the same bits on both sides of it.
std::optional<std::array<FacePoint, 2>> passageThrough(const Tetrahedron& corners, const Ray& ray);

/// The box of a cell, widened beyond the rounding errors with which rays are compared with it.
Box boxAround(std::span<const glm::dvec3> corners);

}  // namespace gxy::reference

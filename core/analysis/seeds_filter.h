// SPDX-License-Identifier: Apache-2.0
// The filter Seeds: points in plain shapes, where lines begin or values are taken.
#pragma once
#include <array>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "core/analysis/filter.h"

namespace gxy {

struct Seeds {
  enum class Shape { Grid, Line, Box, Sphere, Points };
  Shape shape = Shape::Grid;
  std::optional<Box> box;                  ///< Grid and Box; none: the box of the input
  std::array<int, 3> dimensions{8, 8, 8};  ///< Grid
  std::optional<glm::dvec3> from, to;      ///< Line; none: the ends of the diagonal of the input's box
  std::optional<glm::dvec3> center;        ///< Sphere; none: the middle of the input's box
  std::optional<double> radius;            ///< Sphere; none: a quarter of the shortest side of that box
  int count = 100;                         ///< Line, Box, Sphere
  int seed = 0;                            ///< Box, Sphere
  std::vector<glm::dvec3> points;          ///< Points

  static FilterInfo info();
  static std::vector<KeyRow<Seeds>> properties();
  FilterResult run(FilterRun& run) const;

  /// The number of points, and point number `i` of them. `domain` is the box of the input. Throws Error for a shape that cannot be.
  uint64_t number() const;
  glm::dvec3 point(uint64_t i, const Box& domain) const;

 private:
  glm::dvec3 inUnitBall(uint64_t i) const;
};

}  // namespace gxy

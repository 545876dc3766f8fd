// SPDX-License-Identifier: Apache-2.0
// One scalar of a volume, in true values and double.
#pragma once
#include <array>
#include <memory>
#include <optional>

#include "core/data/bricks.h"

namespace gxy::reference {

/// The eight samples of a cell, x fastest.
using CellCorners = std::array<double, 8>;

/// The trilinear interpolation of eight corners at w in [0,1]^3. It is exact on faces, edges and corners, so
/// two cells that share a face see the same value on it.
double trilinear(const CellCorners& corners, glm::dvec3 w);

/// A scalar field: one component of a volume, or the magnitude of all its components, taken at the samples.
/// Immutable; safe to use from any thread; keeps the volume alive.
class Field {
 public:
  /// Throws Error unless the volume's partition 0 holds the whole grid and `component` exists.
  Field(std::shared_ptr<const Volume> volume, std::optional<int> component);

  const Grid& grid() const { return volume_->grid; }
  double smallestSpacing() const;

  /// The true value at a grid point; NaN where the sample is NaN or infinite, and outside the grid.
  double sample(int64_t i, int64_t j, int64_t k) const;

  /// The corners of a cell; none when one of them has no data.
  std::optional<CellCorners> corners(const Index3& cell) const;

  /// The field at a world point; none outside the grid or in a cell without data. A point within rounding of
  /// the grid's border counts as inside.
  std::optional<double> value(glm::dvec3 world) const;

  /// The gradient per world unit: central differences at the grid points, interpolated trilinearly.
  /// Differences are one-sided on the border and next to points without data, and zero where neither
  /// neighbour has data. Zero if less than 1e-5 of the largest difference at the cell's points is left, since
  /// a normal of that would be one of rounding errors.
  glm::dvec3 smoothGradient(glm::dvec3 world) const;

  /// The gradient of the trilinear interpolant itself in a cell, zero where it holds no data. Per world unit.
  glm::dvec3 cellGradient(const Index3& cell, glm::dvec3 world) const;

 private:
  struct Place {
    Index3 cell;
    glm::dvec3 fraction;
    bool inside;
  };
  Place locate(glm::dvec3 world) const;
  double stored(int64_t index) const;
  double difference(Index3 point, int axis) const;

  std::shared_ptr<const Volume> volume_;
  Bricks bricks_;  ///< layout of the volume's only block
  const std::byte* samples_;
  int component_;  ///< -1: the magnitude
};

}  // namespace gxy::reference

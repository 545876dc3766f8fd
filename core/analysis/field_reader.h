// SPDX-License-Identifier: Apache-2.0
// Values of a volume at points between its samples.
#pragma once
#include <array>
#include <glm/vec3.hpp>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "core/data/bricks.h"
#include "core/data/partitioning.h"
#include "core/data/volume.h"

namespace gxy {

/// A place in a grid: the global index of a cell, and where in the cell, from 0 to 1 on each axis.
struct GridPlace {
  Index3 cell{0, 0, 0};
  glm::dvec3 fraction{0};
};

/// Reads a volume, which is trilinear in each cell. Each cell belongs to one partition, the one that contains its middle. All ranks
/// compute the same owners and, where they have the samples, the same values to the bit. Any thread may use it. It keeps references to its
/// arguments.
class FieldReader {
 public:
  FieldReader(const Volume& volume, const Partitioning& partitioning);

  /// Returns the place of a world point. A point on a face belongs to the upper cell, at the end of the grid to the last. Returns
  /// nothing outside the data's box (closed, within 1e-9 cells), and for points that are not finite.
  std::optional<GridPlace> place(glm::dvec3 world) const;
  glm::dvec3 worldOf(const GridPlace& place) const;
  int partitionOf(const Index3& cell) const;
  /// Returns the value of a component, or the magnitude of all for -1: that of the samples, between which it is trilinear, as in
  /// pictures. NaN in a cell with a sample that is NaN or infinite. The partition is one of this rank and its block contains the cell.
  double value(int partition, const GridPlace& place, int component) const;
  /// Returns the gradient of what value() returns, per world unit: that of the polynomial of the place's cell. NaN as there.
  glm::dvec3 gradient(int partition, const GridPlace& place, int component) const;

 private:
  using Corners = std::array<double, 8>;
  /// The values at a cell's corners, x fastest; all NaN in a cell without data.
  Corners corners(int partition, const Index3& cell, int component) const;

  struct Block {
    const VolumeBlock* samples;
    Bricks bricks;
  };

  const Volume& volume_;
  const Partitioning& partitioning_;
  const Box box_;
  std::map<int, Block> blocks_;
};

/// Checks a component that a user names of a volume with so many: of one it may be absent, of several then the magnitude is meant. Returns
/// the number for FieldReader::value(). Throws Error that names the dataset.
int componentOf(int components, const std::string& dataset, std::optional<int> component);

}  // namespace gxy

// SPDX-License-Identifier: Apache-2.0
// Values of an unstructured volume at points.
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/data/mesh.h"
#include "core/reference/cell_map.h"

namespace gxy {

/// The corners of a cell.
class CellCorners {
 public:
  CellCorners(const MeshBlock& block, uint32_t cell);

  CellType type() const { return type_; }
  std::span<const glm::dvec3> points() const { return {points_.data(), shapeOf(type_).points}; }
  /// Returns where its map takes the value of a world point (reference::invert()), or nothing for a point that is outside by more than
  /// `slack` in reference coordinates.
  std::optional<glm::dvec3> placeOf(glm::dvec3 world, double slack = 1e-9) const;

 private:
  CellType type_;
  std::array<glm::dvec3, 8> points_;
};

/// A place in a cell of a partition of this rank.
struct MeshPlace {
  const MeshBlock* block = nullptr;
  uint32_t cell = 0;
  reference::ShapeFunctions shape;  ///< there
  glm::dvec3 reference;             ///< its coordinates in the cell
};

/// Returns the value of a component of a volume, or the magnitude of all for -1, as VTK's linear cells have it: that of the shape
/// functions. Of data of cells it is made of their averages at points. NaN in a cell with a point whose value is NaN or infinite, or with
/// such a value of its own. The place is in a block of the volume.
double valueAt(const Mesh& mesh, const MeshPlace& place, int component);
/// Returns its gradient in the cell, in world units. NaN where valueAt() is, or where the cell has no volume.
glm::dvec3 gradientAt(const Mesh& mesh, const MeshPlace& place, int component);

/// Whether a point is in the box of a mesh, or may be outside of it by its rounding alone. Not for NaN.
bool isInBox(const Box& box, glm::dvec3 point);

/// Finds the cells of points: the map of a cell's shape functions is inverted by Newton's method in double precision. It has a tree over
/// the boxes of the cells of this rank. Any thread may use it. It keeps references to the blocks of the mesh.
class MeshReader {
 public:
  /// Builds the trees; `check` is called now and then and may throw.
  explicit MeshReader(
      const Mesh& mesh, const std::function<void()>& check = [] {});
  ~MeshReader();

  /// About the memory that the trees for a mesh take on this rank, in bytes.
  static int64_t bytesFor(const Mesh& mesh);

  /// Returns the place of a world point that lies in a partition of this rank. If the point is in several cells, as on a face, it is the
  /// cell with the lowest number, which is the same one on any partitioning. Returns nothing for a point in no cell.
  std::optional<MeshPlace> place(int partition, glm::dvec3 world) const;
  /// Returns the cells of a partition of this rank whose boxes come as near to a world point as `margin` on each axis, ascending. Their
  /// order is the same on any partitioning.
  std::vector<uint32_t> cellsNear(int partition, glm::dvec3 world, double margin) const;

 private:
  class Tree;

  std::map<int, std::unique_ptr<const Tree>> trees_;  ///< by partition
};

}  // namespace gxy

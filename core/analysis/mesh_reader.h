// SPDX-License-Identifier: Apache-2.0
// Values of an unstructured volume at points.
#pragma once
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <map>
#include <memory>
#include <optional>

#include "core/data/mesh.h"
#include "core/reference/cell_map.h"

namespace gxy {

/// A place in a cell of a partition of this rank.
struct MeshPlace {
  const MeshBlock* block = nullptr;
  uint32_t cell = 0;
  reference::ShapeFunctions shape;  ///< there
};

/// Finds the cells of points, and reads the volume there as VTK's linear cells have it: places and values in a cell are those of its
/// shape functions, whose map is inverted by Newton's method in double precision. It has a tree over the boxes of the cells of this
/// rank. Any thread may use it. It keeps a reference to the mesh.
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
  /// Returns the value of a component, or the magnitude of all for -1. Of data of cells it is made of their averages at points. NaN in a
  /// cell with a point whose value is NaN or infinite, or with such a value of its own.
  double value(const MeshPlace& place, int component) const;

 private:
  class Tree;

  const Mesh& mesh_;
  std::map<int, std::unique_ptr<const Tree>> trees_;  ///< by partition
};

}  // namespace gxy

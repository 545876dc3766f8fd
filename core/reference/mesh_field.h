// SPDX-License-Identifier: Apache-2.0
// One scalar of an unstructured volume, in true values and double, along rays.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "core/data/mesh.h"
#include "core/reference/bvh.h"
#include "core/reference/mesh_surface.h"
#include "core/reference/ray.h"
#include "core/scene/scene.h"

namespace gxy::reference {

/// The part of a ray's line in one tetrahedron, t0 < t1. The value is linear between both ends.
struct MeshSpan {
  double t0, t1;
  double value0, value1;
};

/// A scalar field on tetrahedra: one component of a mesh, or the magnitude of all its components, taken at the points. Each cell is
/// met by itself, so the order and the neighbours of cells have no effect. Immutable; safe to use from any thread.
class MeshField {
 public:
  /// Copies the cells of all blocks, each cell once even if several blocks have it. Throws Error for cells other than tetrahedra, for
  /// a component that the mesh has not, and for a block with too few values.
  MeshField(const Mesh& mesh, std::optional<int> component);

  /// Returns the parts of the ray in all cells that have data and that it meets in `range`, by ascending t0. They are not cut at the
  /// ends of `range`. For rays through vertices, edges and along faces see passageThrough().
  std::vector<MeshSpan> along(const Ray& ray, Interval range) const;

  /// The surface on which the value is the isovalue. Levels are > 0 where values are higher.
  MeshSurface isosurface(double isovalue) const;
  /// The part of a plane in the cells that have data. Levels are > 0 on the side of the normal.
  MeshSurface slice(const Plane& plane) const;

  size_t cells() const { return cells_.size(); }  ///< with data
  const Box& box() const { return box_; }         ///< Mesh::box
  double typicalLength() const { return typicalLength_; }

 private:
  using Cell = std::array<uint32_t, 4>;
  Tetrahedron cornersOf(const Cell& cell) const;
  std::array<double, 4> valuesOf(const Cell& cell) const;

  std::vector<glm::dvec3> points_;
  std::vector<double> values_;
  std::vector<Cell> cells_;  ///< those with data; their points ascend
  std::optional<Bvh> tree_;
  Box box_;
  double typicalLength_;
};

}  // namespace gxy::reference

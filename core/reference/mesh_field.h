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
#include "core/reference/ray.h"

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
  /// ends of `range`. A ray through a vertex, an edge or along a face is taken as one that is moved by an infinitesimal distance. So
  /// it meets exactly the cells around it that fill the space without overlap.
  std::vector<MeshSpan> along(const Ray& ray, Interval range) const;

  size_t cells() const { return cells_.size(); }  ///< with data
  const Box& box() const { return box_; }         ///< Mesh::box
  double typicalLength() const { return typicalLength_; }

 private:
  using Cell = std::array<uint32_t, 4>;
  std::optional<MeshSpan> across(const Cell& cell, const Ray& ray) const;

  std::vector<glm::dvec3> points_;
  std::vector<double> values_;
  std::vector<Cell> cells_;  ///< those with data
  std::optional<Bvh> tree_;
  Box box_;
  double typicalLength_;
};

}  // namespace gxy::reference

// SPDX-License-Identifier: Apache-2.0
// One scalar of an unstructured volume, in true values and double, along rays.
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/data/mesh.h"
#include "core/reference/bent_cell.h"
#include "core/reference/bvh.h"
#include "core/reference/cubic.h"
#include "core/reference/mesh_surface.h"
#include "core/reference/ray.h"
#include "core/scene/scene.h"

namespace gxy::reference {

/// A part of a ray's line in one cell, t0 < t1. The value there is a cubic of (t - t0) / (t1 - t0).
struct MeshSpan {
  double t0, t1;
  Cubic value;
};

/// A scalar field on cells: one component of a mesh, or the magnitude of all its components, taken at the points. It is linear in a
/// tetrahedron, and what BentCell says in other cells. Of a mesh whose data are those of cells it may be constant in each cell instead;
/// isosurfaces are then nevertheless those of the values at points. Cells whose own value is not finite have no data. Each cell is met by itself, so the order and the neighbours of cells have no
/// effect. Immutable; safe to use from any thread.
class MeshField {
 public:
  /// Copies the cells of all blocks, each cell once even if several blocks have it. `cells` is of no effect if the data are those of
  /// points. Throws Error for a component that the mesh has not, and for a block with too few values.
  MeshField(const Mesh& mesh, std::optional<int> component, CellsShown cells = CellsShown::Flat);

  /// Returns the parts of the ray in all cells that have data and that it meets in `range`, by the t at which it enters the cell. They
  /// are not cut at the ends of `range`. A tetrahedron has one part, in which the value is linear. Other cells have one or several: the
  /// cubics differ from the field by no more than 1e-7 of the range of the cell's values. For rays through vertices, edges and along
  /// faces see passageThrough() and meet().
  std::vector<MeshSpan> along(const Ray& ray, Interval range) const;

  /// The surface on which the value is the isovalue. Levels are > 0 where values are higher. The gradients at its corners are means of those around.
  MeshSurface isosurface(double isovalue) const;
  /// The part of a plane in the cells that have data. Levels are > 0 on the side of the normal.
  MeshSurface slice(const Plane& plane) const;

  size_t cells() const { return tetrahedra_.size() + others_.size(); }  ///< with data
  const Box& box() const { return box_; }                               ///< Mesh::box
  double typicalLength() const { return typicalLength_; }

 private:
  using Corners = std::array<uint32_t, 4>;
  /// Of a hexahedron, wedge or pyramid.
  struct Other {
    CellType type;
    std::array<uint32_t, 8> points{};
  };
  /// Cells with their values: 0 if the data are those of points.
  struct Cells {
    std::vector<Corners> tetrahedra;
    std::vector<Other> others;
    std::vector<double> tetrahedronValues, otherValues;
  };
  void addCells(const Mesh& mesh, const MeshBlock& block, std::optional<int> component, uint32_t firstPoint,
                Cells& cells) const;
  MeshSurface surface(const std::function<double(uint32_t point)>& levelOf, LevelKind kind) const;
  std::vector<glm::dvec3> gradients() const;
  bool haveData(std::span<const uint32_t> points, double own) const;
  Tetrahedron cornersOf(const Corners& cell) const;
  BentCell cornersOf(const Other& cell) const;
  /// What is shown at the corners of a cell, but by isosurfaces.
  std::array<double, 4> valuesOfTetrahedron(size_t cell) const;
  OfCorners valuesOfOther(size_t cell) const;

  std::vector<glm::dvec3> points_;
  std::vector<double> values_;
  /// At each point the mean of the gradients in all tetrahedra that the point and three of its neighbours along the edges of a cell make,
  /// weighed by volume; 0 where they have none.
  std::vector<glm::dvec3> gradients_;
  std::vector<Corners> tetrahedra_;        ///< those with data; their points ascend
  std::vector<Other> others_;              ///< those with data
  std::vector<double> tetrahedronValues_;  ///< of cells that are constant; else empty
  std::vector<double> otherValues_;
  std::optional<Bvh> tree_;  ///< tetrahedra first
  Box box_;
  double typicalLength_;
};

}  // namespace gxy::reference

// SPDX-License-Identifier: Apache-2.0
// Isosurfaces and slices of unstructured volumes, along rays.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/reference/bent_cell.h"
#include "core/reference/bvh.h"
#include "core/reference/tetrahedron.h"

namespace gxy::reference {

/// A tetrahedron with a level, which is linear in it: value - isovalue, or the distance to the plane of a slice.
struct LevelCell {
  Tetrahedron corners;
  std::array<double, 4> levels, values;   ///< at the corners
  std::array<glm::dvec3, 4> gradients{};  ///< there, of values, of which normals are made; 0 on slices
};

/// The same for a hexahedron, wedge or pyramid.
struct LevelBentCell {
  BentCell cell;
  OfCorners levels, values;
  std::array<glm::dvec3, 8> gradients{};
};

/// Whether the surface passes a cell with these levels at its corners.
bool isPassed(std::span<const double> levels);

/// Where a ray meets the surface in a cell.
struct MeshCrossing {
  double t;
  double value;
  uint32_t cell;
  glm::dvec3 position{0};  ///< on the ray
  glm::dvec3 place{0};     ///< in the reference coordinates of shapeAt(); not of a tetrahedron
};

/// What levels are: values less the isovalue, or distances to a plane, which are linear in space.
enum class LevelKind { Values, Distances };

/// The surface that bounds the places with a level > 0 from those with a level <= 0, inside the cells alone. A ray crosses it in a cell
/// an odd number of times if exactly one of the levels where it enters and leaves the cell is > 0; that is once in a tetrahedron, and on
/// distances to a plane. In other cells values may cross the level up to any even number of times more. If two cells have the corners of
/// their common face in the same order, no ray near it misses the surface or crosses it twice. Where two parts of the surface touch, a
/// ray crosses both. Immutable; safe to use from any thread.
class MeshSurface {
 public:
  /// Takes the cells that the surface passes. They are numbered from 0, tetrahedra first.
  MeshSurface(std::vector<LevelCell> tetrahedra, std::vector<LevelBentCell> others, LevelKind kind);

  /// The crossings in one of the cells, by t.
  std::vector<MeshCrossing> crossings(uint32_t cell, const Ray& ray) const;
  /// All crossings in `range`, by (t, cell).
  std::vector<MeshCrossing> along(const Ray& ray, Interval range = {}) const;

  /// The unit vector towards higher levels `aside` from a crossing; `flat` if the levels have no gradient there.
  glm::dvec3 upwards(const MeshCrossing& crossing, glm::dvec3 flat, glm::dvec3 aside = glm::dvec3(0)) const;
  /// The unit vector of the mean of the gradients at the corners of the cell, `aside` from a crossing; `flat` if that is 0.
  glm::dvec3 smoothUpwards(const MeshCrossing& crossing, glm::dvec3 flat, glm::dvec3 aside) const;
  /// The value `aside` from a crossing, not beyond those at the corners of its cell.
  double valueNear(const MeshCrossing& crossing, glm::dvec3 aside) const;

  /// The largest magnitude of a coordinate of a cell's corners.
  double farthest(uint32_t cell) const;
  size_t cells() const { return tetrahedra_.size() + others_.size(); }
  /// Of the cells.
  const Bvh& tree() const { return *tree_; }

 private:
  bool isBent(uint32_t cell) const { return cell >= tetrahedra_.size(); }
  const LevelBentCell& bent(uint32_t cell) const { return others_[cell - tetrahedra_.size()]; }
  std::vector<MeshCrossing> crossingsOfBent(uint32_t cell, const Ray& ray) const;

  std::vector<LevelCell> tetrahedra_;
  std::vector<LevelBentCell> others_;
  LevelKind kind_;
  std::optional<Bvh> tree_;
};

}  // namespace gxy::reference

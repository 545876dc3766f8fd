// SPDX-License-Identifier: Apache-2.0
// Particles, path lines and triangle meshes as they are stored: each primitive on one rank.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/data/box.h"
#include "core/data/geometry.h"

namespace gxy {

/// The primitives that this rank owns of a geometry. Each primitive has one owner, which need not own the part of space where
/// it lies. distribute() copies primitives into the partitions that they touch, once their radii are known. Everything but
/// `block` is the same on every rank. The structure is immutable once it is complete, and any thread may read it.
struct OwnedGeometry {
  std::string name;
  GeometryKind kind = GeometryKind::Particles;
  GeometryBlock block;   ///< primitives that can be drawn; their ids are global
  bool colored = false;  ///< points have colours instead of values
  std::string array;     ///< what the values or colours are called; empty: unknown, or there are none
  std::vector<PointFieldInfo> fields;  ///< further ones of points, of which operators may show another
  Box box;                             ///< of all points, world
  Box middle;                          ///< of particles: the box without outliers; else the box
  double spacing = 0;  ///< mean distance between neighbouring points, world; 0: there are too few
  Range range;         ///< of all values
  std::optional<Range> radiusRange;  ///< of the scalars that give radii, if these are not the values
  uint64_t primitives = 0;           ///< on all ranks
  uint64_t droppedPrimitives = 0;    ///< with non-finite coordinates, or degenerate
};

}  // namespace gxy

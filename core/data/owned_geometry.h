// SPDX-License-Identifier: Apache-2.0
// Particles, path lines and triangle meshes as they are stored: each primitive on one rank.
#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "core/data/box.h"
#include "core/data/geometry.h"

namespace gxy {

/// A rank's primitives of a set that all ranks hold together, each on one rank, wherever it lies in space. distribute() copies
/// them into the partitions that they touch once it is known how thick they are. Everything but `block` is the same on every
/// rank. Immutable once complete; safe to read from any thread.
struct OwnedGeometry {
  std::string name;
  GeometryKind kind = GeometryKind::Particles;
  GeometryBlock block;   ///< primitives that can be drawn; their ids are global
  bool colored = false;  ///< points have colours instead of values
  Box box;               ///< of all points, world
  Box middle;            ///< of particles: the box without outliers; else the box
  double spacing = 0;    ///< mean distance between neighbouring points, world; 0: there are too few
  Range range;           ///< of all values
  std::optional<Range> radiusRange;  ///< of the scalars that give radii, if these are not the values
  uint64_t primitives = 0;           ///< on all ranks
  uint64_t droppedPrimitives = 0;    ///< with non-finite coordinates, or degenerate
};

}  // namespace gxy

// SPDX-License-Identifier: Apache-2.0
// A geometry file becomes the blocks of a rank's partitions.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "core/comm/collectives.h"
#include "core/data/geometry.h"
#include "core/data/partitioning.h"
#include "core/data/replicate.h"
#include "core/io/geometry_file.h"

namespace gxy {

/// What a rank has read, before it is brought to its partitions. Everything but `block` and `leftOut` is the same on every
/// rank.
struct LoadedGeometry {
  std::string name;
  GeometryKind kind = GeometryKind::Particles;
  GeometryBlock block;      ///< usable primitives only; ids are global, in file order
  bool colored = false;     ///< points have colours instead of values
  bool everywhere = false;  ///< the format has no pieces, so every rank has read all
  Box box;
  Box middle;          ///< of points: the box without outliers (point_spread.h); else the box
  double spacing = 0;  ///< mean distance between neighbouring points; 0: there are too few
  Range range;
  std::optional<Range> radiusRange;  ///< of the scalars that give radii, if these are not the values
  uint64_t primitives = 0, dropped = 0;
  LeftOut leftOut;  ///< of the files that this rank has read
};

/// Collective over `ranks`. Each rank reads its share of the pieces of a .pvtu, .pvtp or .part, else all of
/// the file. Unusable primitives (a coordinate that is not finite, triangles without area, repeated points of
/// lines) are dropped and counted.
/// Values are of the same array in all pieces. If `wanted` names it, each piece must have it; else it is the one that a .pvtu
/// or .pvtp declares, or that is chosen of the first piece with points. Each piece must also have the array of radii, if
/// `wanted` names one. Normals, and values or colours that are not named, are used only if all pieces have them.
/// On rank 0 `warnings` receives what was flawed or is not used in any file; null: they are logged. `toTake`, if any, is told
/// what this rank takes for each file before it does: what the file's arrays take, then what they become. If any rank
/// fails, all throw the same Error.
LoadedGeometry loadGeometry(const std::string& path, GeometryKind kind, const ValuesWanted& wanted,
                            Collectives& ranks, const TakeMemory& toTake = {},
                            std::vector<std::string>* warnings = nullptr);

/// Collective. Brings primitives to every partition that they, `radius` thick, touch.
std::shared_ptr<Geometry> distribute(const LoadedGeometry& loaded, const Partitioning& partitioning,
                                     const RadiusOf& radius, Collectives& ranks);

}  // namespace gxy

// SPDX-License-Identifier: Apache-2.0
// A geometry file becomes the blocks of a rank's partitions.
#pragma once
#include <string>
#include <vector>

#include "core/comm/collectives.h"
#include "core/data/owned_geometry.h"
#include "core/data/partitioning.h"
#include "core/io/geometry_file.h"
#include "core/io/left_out.h"

namespace gxy {

/// The result of reading a geometry file on one rank.
struct LoadedGeometry {
  OwnedGeometry geometry;  ///< ids are in file order
  bool onRoot = false;     ///< the format has no pieces, so rank 0 has read all primitives
  LeftOut leftOut;         ///< of the files that this rank has read
};

/// Collective over `ranks`. Each rank reads its share of the pieces of a .pvtu, .pvtp, .pvts, .pvtr or .part, else rank 0
/// reads all of the file. Unusable primitives (a coordinate that is not finite, triangles without area, repeated points of
/// lines) are dropped and counted.
/// Values are of the same array in all pieces. If `wanted` names it, each piece must have it; else it is the one that a .pvtu
/// or .pvtp declares, or that is chosen of the first piece with points. Each piece must also have the array of radii, if
/// `wanted` names one, and those of `wanted.fields`, with as many components. Normals, and values or colours that are not named, are used only if all pieces have them.
/// On rank 0 `warnings` receives what was flawed or is not used in any file; null: they are logged. `toTake`, if any, is told
/// what this rank takes for each file before it does: what the file's arrays take, then what they become. If any rank
/// fails, all throw the same Error.
LoadedGeometry loadGeometry(const std::string& path, GeometryKind kind, const ValuesWanted& wanted,
                            Collectives& ranks, const TakeMemory& toTake = {},
                            std::vector<std::string>* warnings = nullptr);

/// Collective. Computes the box, the ranges of values, of radii and of fields, `middle` and `spacing` of geometry whose block and numbers
/// of primitives are complete. Ranks with points have the same fields; those without get them. If any rank fails, all throw the same Error.
void measureGeometry(LoadedGeometry& loaded, Collectives& ranks);

/// Collective. Gives each primitive one owner. If rank 0 has read all primitives, each rank gets those that keepHome()
/// gives to it; otherwise the rank that has read a primitive owns it. If any rank fails, all throw the same Error.
OwnedGeometry ownedGeometry(LoadedGeometry loaded, const Partitioning& partitioning, Collectives& ranks);

}  // namespace gxy

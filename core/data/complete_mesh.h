// SPDX-License-Identifier: Apache-2.0
// From the cells that ranks have read or received to a mesh that can be rendered: statistics over all ranks, encoding, blocks.
#pragma once
#include <cstdint>
#include <functional>
#include <vector>

#include "core/comm/collectives.h"
#include "core/data/mesh.h"
#include "core/data/mesh_blocks.h"
#include "core/data/partitioning.h"
#include "core/data/scalar.h"

namespace gxy {

/// Cells of one rank whose values are stored as those of all ranks are.
struct EncodedMesh {
  MeshPiece piece;
  double shift = 0, scale = 1;  ///< as in Mesh
  std::vector<Range> ranges;    ///< as in Mesh, on all ranks
  Box box;                      ///< as in Mesh, on all ranks
};

/// Collective. `piece` lacks its values, which are `values`, the components of a point together. They are stored as float, as encodingOf()
/// says of `type` and of the values of all ranks. All ranks give the same type and components. `toTake`, if not empty, is told the bytes
/// of stored values before they are taken, and may refuse them by throwing Error. If any rank fails, all throw the same Error.
EncodedMesh encodedMesh(MeshPiece piece, ScalarType type, std::vector<double> values, Collectives& ranks,
                        const std::function<void(int64_t)>& toTake = {});

/// Collective. The cells go into every partition that they touch. Fills all but the mesh's name, and of its report what distribute()
/// counts. `toTake`: as in distribute(). If any rank fails, all throw the same Error. There may be no cells.
Mesh completeMesh(EncodedMesh read, const Partitioning& partitioning, Collectives& ranks,
                  const std::function<void(int64_t)>& toTake = {});

}  // namespace gxy

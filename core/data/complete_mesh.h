// SPDX-License-Identifier: Apache-2.0
// From the cells that ranks have read or received to a mesh that can be rendered: statistics over all ranks, encoding, blocks.
#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <vector>

#include "core/comm/collectives.h"
#include "core/data/mesh.h"
#include "core/data/mesh_blocks.h"
#include "core/data/mesh_values.h"
#include "core/data/partitioning.h"
#include "core/data/scalar.h"

namespace gxy {

/// Is told the bytes of something before they are taken, and may refuse them by throwing Error. An empty function refuses nothing.
using ToTake = std::function<void(int64_t)>;

/// Values of one rank that are stored as those of all ranks are. All but `stored` is as in Mesh, on all ranks.
struct EncodedValues {
  std::vector<float> stored;
  int components = 1;
  bool ofCells = false;
  double shift = 0, scale = 1;
  std::vector<Range> ranges;
};

/// Collective. Stores `values`, the components of a point together, as float, as encodingOf() says of `type` and of the values of all
/// ranks. All ranks give the same type and components. `leftOut`: 1 for each point or cell that counts for no range; empty if all do. If any
/// rank fails, all throw the same Error.
EncodedValues encodedValues(ScalarType type, int components, bool ofCells, const std::vector<double>& values,
                            std::span<const uint8_t> leftOut, Collectives& ranks, const ToTake& toTake = {});

/// Cells of one rank whose values are stored as those of all ranks are.
struct EncodedMesh {
  MeshPiece piece;
  double shift = 0, scale = 1;  ///< as in Mesh
  std::vector<Range> ranges;    ///< as in Mesh, on all ranks
  Box box;                      ///< as in Mesh, on all ranks
};

/// Collective. As encodedValues(), for a piece that lacks its values. If its data are those of cells, `values` are those of all of its cells,
/// by type; those of duplicates count for no range.
EncodedMesh encodedMesh(MeshPiece piece, ScalarType type, std::vector<double> values, Collectives& ranks,
                        const ToTake& toTake = {});

/// What meshes on the same points and cells have in common on one rank.
struct MeshLayout {
  std::map<int, MeshBlock> blocks;  ///< by partition, without values
  MeshBlockCounts counts;
  ValueRoutes routes;
  Box box;
  /// 1 for each point of the piece that only duplicates have, and for each duplicate (CellSources). Empty if there are none.
  std::vector<uint8_t> pointsOfDuplicates, duplicates;
};
/// Memory of the blocks in bytes, without the rest.
int64_t bytesOf(const MeshLayout& layout);

/// Collective. The cells go into every partition that they touch. Fills all but the mesh's name, and of its report what distribute()
/// counts. There may be no cells. `layout`, if not null, becomes that of further meshes on the same points and cells, whose values are
/// at points, or of cells if those of `read` are. `toTake`: as in distribute(). If any rank fails, all throw the same Error.
Mesh completeMesh(EncodedMesh read, const Partitioning& partitioning, Collectives& ranks,
                  const ToTake& toTake = {}, MeshLayout* layout = nullptr);

/// Collective. Returns the mesh with other values at the same points or of the same cells, which the piece of this rank had when the layout was
/// made, in the same order. It shares all but the values with other meshes of the layout, and is what completeMesh() would make anew.
Mesh completeMesh(EncodedValues values, const MeshLayout& layout, const Partitioning& partitioning,
                  Collectives& ranks, const ToTake& toTake = {});

}  // namespace gxy

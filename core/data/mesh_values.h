// SPDX-License-Identifier: Apache-2.0
// Which points of a mesh, as it was read or received, the points of its blocks are. By it, the values of another field or step on the same
// points and cells find their places, and nothing else of the blocks has to be made anew.
#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <vector>

#include "core/comm/collectives.h"
#include "core/data/mesh_blocks.h"
#include "core/data/partitioning.h"

namespace gxy {

/// Of one block: the points of the piece that it was made of.
struct PointSources {
  struct Source {
    uint32_t from, to;  ///< point of the piece, and of the block
    /// It is another point of the files than the one before it here, which is at the same place, and is counted in this partition.
    bool merged;
  };
  std::vector<Source> sources;  ///< ascending by points of the block, and then by numbers in the files
  std::vector<uint8_t> isHere;  ///< by point of the block: whether it is counted in this partition
  uint64_t pointsOfPiece = 0;
};

/// Returns the values of a block from those of its piece: of several points at one place those of the first. Counts differingPoints,
/// with `differing`, and noDataPoints.
std::vector<float> valuesOfBlock(const PointSources& sources, std::span<const float> values, int components,
                                 int partition, MeshBlockCounts& counts);

/// Of all blocks of a rank.
struct ValueRoutes {
  struct Sent {
    int partition;
    std::vector<uint32_t> points;  ///< of what this rank has read
  };
  std::vector<std::vector<Sent>> sent;  ///< by rank
  std::map<int, PointSources> taken;    ///< by partition of this rank
};
int64_t bytesOf(const ValueRoutes& routes);

/// Collective. Returns the blocks with other values, all else being shared. `values` are stored values at the points that this rank has read,
/// in the same order as when distribute() made `blocks` and `routes`. Of `counts`, which are those of distribute(), the counts that depend on
/// values become those of the new ones. `toTake` as in distribute(). If any rank fails, all throw the same Error.
std::map<int, MeshBlock> distributeValues(const std::map<int, MeshBlock>& blocks, const ValueRoutes& routes,
                                          std::span<const float> values, int components,
                                          const Partitioning& partitioning, MeshBlockCounts& counts,
                                          Collectives& ranks,
                                          const std::function<void(int64_t)>& toTake = {});

}  // namespace gxy

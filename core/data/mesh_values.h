// SPDX-License-Identifier: Apache-2.0
// Which points and cells of a mesh, as it was read or received, those of its blocks are. By it, the values of another field or step on the
// same points and cells find their places, and nothing else of the blocks has to be made anew.
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "core/comm/advance.h"
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

/// Of one block: the cells of the piece that it was made of.
struct CellSources {
  struct Source {
    uint32_t from;     ///< cell of the piece: first its tetrahedra, then its pyramids, wedges and hexahedra
    uint32_t to;       ///< cell of `served` if that is there, else of the block
    bool isDuplicate;  ///< as in MeshPiece
  };
  /// Points and cells before those leave that are there as duplicates only.
  struct Served {
    std::vector<glm::dvec3> points;
    MeshCells cells;
    std::vector<uint32_t> keptPoints;  ///< those of the block, ascending
  };
  std::vector<Source> sources;   ///< ascending by `to`
  std::optional<Served> served;  ///< if there are such cells
  uint64_t cellsOfPiece = 0;
};

/// Of one block. Points have those that cells have which are no duplicates.
struct BlockSources {
  PointSources points;
  std::optional<CellSources> cells;  ///< if the piece has data of cells
};

/// Returns the values of a block from those of its piece: of several points at one place those of the first. Counts differingPoints,
/// with `differing`, and noDataPoints.
std::vector<float> valuesOfBlock(const PointSources& sources, std::span<const float> values, int components,
                                 int partition, MeshBlockCounts& counts);

/// Gives a block, of which all else is known, the values of its cells and the averages at its points (averagesAtPoints()), from those of the
/// cells of its piece. There are sources of cells. Of several cells with the same points the lowest value is kept, and those of duplicates only where
/// there are no others. Counts noDataCells and differingCells, and `differing` as MeshBlockCounts says.
void giveCellValues(
    MeshBlock& block, const BlockSources& sources, std::span<const float> values, int components,
    const Partitioning& partitioning, int partition, MeshBlockCounts& counts,
    const Advance& advance = [](double) {});

/// Of all blocks of a rank.
struct ValueRoutes {
  struct Sent {
    int partition;
    std::vector<uint32_t> points;                         ///< of what this rank has read
    std::array<std::vector<uint32_t>, kCellTypes> cells;  ///< likewise, by type, numbered as in CellSources
  };
  std::vector<std::vector<Sent>> sent;  ///< by rank
  std::map<int, BlockSources> taken;    ///< by partition of this rank
};
int64_t bytesOf(const ValueRoutes& routes);

/// Collective. Returns the blocks with other values, all else being shared. `values` are stored values at the points that this rank has read,
/// or of the cells (as in CellSources) if `ofCells`, in the same order as when distribute() made `blocks` and `routes`. Values of cells need
/// that its piece had such, too. Of `counts`, which are those of distribute(), the counts that depend on
/// values become those of the new ones. `toTake` as in distribute(). If any rank fails, all throw the same Error.
std::map<int, MeshBlock> distributeValues(const std::map<int, MeshBlock>& blocks, const ValueRoutes& routes,
                                          std::span<const float> values, int components, bool ofCells,
                                          const Partitioning& partitioning, MeshBlockCounts& counts,
                                          Collectives& ranks,
                                          const std::function<void(int64_t)>& toTake = {});

}  // namespace gxy

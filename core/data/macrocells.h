// SPDX-License-Identifier: Apache-2.0
// Summaries of macrocells, per block and merged over the partitions that cut a macrocell.
//
// After an import or update, each rank calls summarizeBlock() for every local block, gives the ranks that have
// the same macrocells its borderSummaries(), and calls mergeSummaries() with the records that it gets and its own. The result then does not depend on how the volume is cut, if every
// cell is in some partition and blocks have at least one ghost layer. So both sides of a border skip and
// subdivide alike.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "core/comm/advance.h"
#include "core/data/volume.h"

namespace gxy {

/// A box of macrocells: the global index of its first one, and its size.
struct MacrocellBox {
  Index3 first{0, 0, 0}, count{0, 0, 0};
  bool contains(const Index3& macrocell) const {
    for (int a = 0; a < 3; ++a)
      if (macrocell[a] < first[a] || macrocell[a] >= first[a] + count[a]) return false;
    return true;
  }
  bool meets(const MacrocellBox& other) const {
    for (int a = 0; a < 3; ++a)
      if (other.first[a] >= first[a] + count[a] || first[a] >= other.first[a] + other.count[a]) return false;
    return true;
  }
};

/// Returns the macrocells that have cells in a block of this extent; none for an empty extent.
MacrocellBox macrocellsOf(const Extent& extent);

/// Computes firstMacrocell, macrocells and summaries of a block from its own samples, which are in bricks (bricks.h; stored type
/// int8 to uint16, or float). The magnitude of a point is the square root of the sum of squares of its stored components, in
/// float, from left to right; it has no data if one component has none. Throws Error for another stored type, if the samples do
/// not fit the extent, or if the block has summaries already. A block is unusable after `advance` has thrown.
void summarizeBlock(
    VolumeBlock& block, ScalarType stored, int components, const Advance& advance = [](double) {});

/// Does the same for a block whose samples come x fastest: puts them into bricks first.
void completeBlock(
    VolumeBlock& block, ScalarType stored, int components, const Advance& advance = [](double) {});

/// One block's summary of a macrocell that other blocks may contain too. It is plain data, sent between ranks
/// as it is.
struct BorderSummary {
  Index3 macrocell;  ///< global index
  int32_t summary;   ///< index into VolumeBlock::summaries
  int32_t noData;    ///< 0 or 1
  float min, max, steep, bend;
  bool operator==(const BorderSummary&) const = default;
};

/// Returns, for every complete local block, the summaries of macrocells that another block may contain too,
/// ordered by block, macrocell and summary.
std::vector<BorderSummary> borderSummaries(const Volume& volume);

/// Widens the summaries of all local blocks by records, in any order. Those of macrocells that no local block has change nothing. Throws Error for a
/// record that no volume of this shape can have made.
void mergeSummaries(Volume& volume, std::span<const BorderSummary> records);

}  // namespace gxy

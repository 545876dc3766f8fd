// SPDX-License-Identifier: Apache-2.0
// Summaries of macrocells, per block and merged over the partitions that cut a macrocell.
//
// After an import or update, each rank calls summarizeBlock() for every local block, exchanges its
// borderSummaries() with all ranks (an all-gather of plain structs), and calls mergeSummaries() with the
// records of all ranks, its own included. The result then does not depend on how the volume is cut, if every
// cell is in some partition and blocks have at least one ghost layer. So both sides of a border skip and
// subdivide alike.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "core/comm/advance.h"
#include "core/data/volume.h"

namespace gxy {

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

/// Widens the summaries of all local blocks by the records of all ranks, in any order. Throws Error for a
/// record that no volume of this shape can have made.
void mergeSummaries(Volume& volume, std::span<const BorderSummary> records);

}  // namespace gxy

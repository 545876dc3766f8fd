// SPDX-License-Identifier: Apache-2.0
// Summaries of macrocells: per block, and merged across the partitions that cut a macrocell.
//
// After an import or update: completeBlock() every local block, exchange the borderSummaries() of all ranks (an
// all-gather of plain structs), and mergeSummaries() with all of them, own ones included. The result is the
// summary of the whole volume, however it is cut, as long as every cell is in some partition and blocks have at least one
// ghost layer; both sides of a border decide alike.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "core/comm/advance.h"
#include "core/data/volume.h"

namespace gxy {

/// Fills firstMacrocell, macrocells and summaries of a block from its own samples (x fastest; stored type: int8 to uint16,
/// or float), and puts these into bricks. The magnitude of a point is sqrt of the sum of squares of the stored components, in
/// float, left to right; a point is "no data" for the magnitude if one component is. Throws Error if the
/// samples do not fit the extent, or the block is complete. Nothing can be done with a block whose `advance` has thrown.
void completeBlock(
    VolumeBlock& block, ScalarType stored, int components, const Advance& advance = [](double) {});

/// What one block knows of one macrocell that other blocks may hold too; plain data, sent between ranks as it
/// is.
struct BorderSummary {
  Index3 macrocell;  ///< global index
  int32_t summary;   ///< index into VolumeBlock::summaries
  int32_t noData;    ///< 0 or 1
  float min, max, steep, bend;
  bool operator==(const BorderSummary&) const = default;
};

/// Of every complete local block, the macrocells of which it lacks samples. Order: block, macrocell,
/// summary.
std::vector<BorderSummary> borderSummaries(const Volume& volume);

/// Widens the summaries of all local blocks by those records (of all ranks, in any order) that concern them.
/// Throws Error for a record that no volume of this shape can have made.
void mergeSummaries(Volume& volume, std::span<const BorderSummary> records);

}  // namespace gxy

// SPDX-License-Identifier: Apache-2.0
// Isosurface plans: which macrocells an isovalue may pass through, and which of their cells.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/comm/advance.h"
#include "core/data/volume.h"

namespace gxy {

/// The number of words that hold the bits of one macrocell's cells.
inline constexpr size_t kIsoWords = size_t(kMacrocellSize * kMacrocellSize * kMacrocellSize / 32);
/// The most words of a plan: kernels address a table in bytes, in 31 bits.
inline constexpr size_t kMostIsoWords = size_t(1) << 29;

/// Returns one word per macrocell of the block (x fastest), and then the bits of cells, 64 bytes for each
/// macrocell that has some. A word w means:
/// - w > 0: an isovalue (stored units) lies in the macrocell's range, and w is the index of the first word of
///   its bits. Bit x + 8 y + 64 z, counted from the lowest of the first word, is of cell (x, y, z). It is set
///   if an isovalue lies in the range of the cell's corners, and clear if not or if the block lacks a corner.
/// - w = -k, k <= 3: the macrocell lies in an aligned cube of 2^k macrocells a side. No isovalue lies in the
///   range of any of those that the block has.
///
/// `summaries` are the macrocells' ranges, merged over partitions so that all agree. `component` < 0 asks for
/// the magnitude, in float. Macrocells whose bits do not fit into `mostWords` share 16 words of set bits.
/// Takes the time of one pass over the macrocells that have bits; `advance` may be called from several
/// threads. Throws Error where the samples do not fit the extent.
std::vector<int32_t> isoMask(
    const VolumeBlock& block, ScalarType stored, int components, int component,
    std::span<const Macrocell> summaries, std::span<const float> isovalues, size_t mostWords = kMostIsoWords,
    const Advance& advance = [](double) {});

/// Whether some cell of macrocell `index` lies between the points of `extent` and has its bit set.
/// `firstCell` is the macrocell's first cell on the grid.
bool hasIsoCell(std::span<const int32_t> plan, size_t index, const Index3& firstCell, const Extent& extent);

/// The number of cells whose bit is clear, in the macrocells that have bits. The plan is of `macrocells`
/// macrocells.
uint64_t cellsWithoutIsovalue(std::span<const int32_t> plan, size_t macrocells);

/// Whether an isovalue lies in the range of some macrocell. If none does, there is no isosurface and no plan
/// is needed.
bool anyIsosurface(std::span<const Macrocell> summaries, std::span<const float> isovalues);

}  // namespace gxy

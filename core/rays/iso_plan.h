// SPDX-License-Identifier: Apache-2.0
// Where isosurfaces may be: per macrocell, and per cell of those that an isovalue passes through.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/comm/advance.h"
#include "core/data/volume.h"

namespace gxy {

/// Words that hold the bits of one macrocell's cells.
inline constexpr size_t kIsoWords = size_t(kMacrocellSize * kMacrocellSize * kMacrocellSize / 32);
/// Kernels address a table in bytes, in 31 bits.
inline constexpr size_t kMostIsoWords = size_t(1) << 29;

/// One word per macrocell of the block (x fastest), then the bits of cells, 64 bytes per macrocell that has some:
///   > 0  an isovalue (stored units) lies in the macrocell's range (`summaries`: merged, so that all partitions agree);
///        the index of its first word of bits. Bit x + 8 y + 64 z, from the lowest of the first word on, is of
///        cell (x, y, z): set if an isovalue lies in the range of its corners, clear if it does not or the block
///        lacks one of them
///   -k   no isovalue lies in the range of any macrocell that the block has of the aligned cube of 2^k of them, k <= 3
/// `component` < 0: the magnitude, in float. Macrocells beyond `mostWords` share 16 words of set bits. Takes the time
/// of one pass over the macrocells that have bits. Throws Error where the samples do not fit the extent.
std::vector<int32_t> isoPlan(
    const VolumeBlock& block, ScalarType stored, int components, int component,
    std::span<const Macrocell> summaries, std::span<const float> isovalues, size_t mostWords = kMostIsoWords,
    const Advance& advance = [](double) {});

/// Whether a cell of macrocell `index`, whose first cell on the grid is `firstCell`, lies between the points of an extent and
/// has its bit set.
bool hasIsoCell(std::span<const int32_t> plan, size_t index, const Index3& firstCell, const Extent& extent);

/// The cells without a bit in the macrocells that have some, of a plan for `macrocells` of them.
uint64_t cellsWithoutIsovalue(std::span<const int32_t> plan, size_t macrocells);

/// Whether an isovalue lies in the range of a macrocell: where none does there is no isosurface, and no plan is needed.
bool anyIsosurface(std::span<const Macrocell> summaries, std::span<const float> isovalues);

}  // namespace gxy

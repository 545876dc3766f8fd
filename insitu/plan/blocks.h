// SPDX-License-Identifier: Apache-2.0
// The blocks of a grid that the ranks of a simulation own.
#pragma once
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "core/data/extents.h"

namespace gxy::insitu {

/// A box of grid points that a rank of the simulation owns. `index` is its place among the blocks of that rank.
struct Block {
  int rank = 0;
  int index = 0;
  Extent extent;
  bool operator==(const Block&) const = default;
};

/// Finds the blocks that have points in an extent. It takes O(log n + k) where blocks are about of one size. k are the blocks that
/// overlap the extent along one axis: the one on which blocks begin at the most different places.
class BlockSearch {
 public:
  explicit BlockSearch(std::vector<Block> blocks);

  /// Calls visit(number, common points) for each block that has points in `extent`. Numbers are places in blocks().
  template <class Visit>
  void overlapping(const Extent& extent, Visit visit) const {
    const auto [first, last] = candidates(extent);
    for (size_t i = first; i < last; i++)
      if (const Extent common = intersection(blocks_[i].extent, extent); common.count() > 0) visit(i, common);
  }
  std::span<const Block> blocks() const { return blocks_; }

 private:
  std::pair<size_t, size_t> candidates(const Extent& extent) const;

  size_t axis_ = 0;
  std::vector<Block> blocks_;      ///< sorted along the axis
  std::vector<int64_t> furthest_;  ///< by block: the furthest end of it and those before it
};

/// Throws Error unless each point of a grid is in exactly one block. The message names two blocks that overlap, or a box of
/// points that no block has.
void checkCover(const BlockSearch& search, const Index3& points);

}  // namespace gxy::insitu

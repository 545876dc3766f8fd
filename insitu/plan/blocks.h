// SPDX-License-Identifier: Apache-2.0
// The blocks of a grid that the ranks of a simulation own.
#pragma once
#include <cstdint>
#include <span>
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

/// Finds the blocks that have points in an extent, by a tree of boxes. For n blocks that do not overlap this takes O(log n + k), with
/// k the blocks that are found.
class BlockSearch {
 public:
  explicit BlockSearch(std::vector<Block> blocks);

  /// Calls visit(number, common points) for each block that has points in `extent`, until it returns false. Numbers are places
  /// in blocks(). Returns whether it was never false.
  template <class Visit>
  bool overlapping(const Extent& extent, Visit visit) const {
    return blocks_.empty() || overlapping(0, extent, visit);
  }
  std::span<const Block> blocks() const { return blocks_; }

 private:
  static constexpr size_t kLeaf = 4;  ///< blocks of a leaf, at most
  /// The blocks from `first` to `last` lie in `bounds`. The left child is the next node.
  struct Node {
    Extent bounds;
    size_t first = 0, last = 0;
    size_t right = 0;  ///< 0: a leaf
  };
  void build(size_t first, size_t last);

  template <class Visit>
  bool overlapping(size_t node, const Extent& extent, Visit& visit) const {
    const Node& n = nodes_[node];
    if (intersection(n.bounds, extent).count() == 0) return true;
    if (n.right > 0) return overlapping(node + 1, extent, visit) && overlapping(n.right, extent, visit);
    for (size_t i = n.first; i < n.last; i++)
      if (const Extent common = intersection(blocks_[i].extent, extent); common.count() > 0)
        if (!visit(i, common)) return false;
    return true;
  }

  std::vector<Block> blocks_;
  std::vector<Node> nodes_;
};

/// Throws Error unless each point of a grid is in exactly one block. The message names two blocks that overlap, or a box of
/// points that no block has.
void checkCover(const BlockSearch& search, const Index3& points);

}  // namespace gxy::insitu

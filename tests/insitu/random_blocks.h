// SPDX-License-Identifier: Apache-2.0
// Random decompositions of a grid's points.
#pragma once
#include <algorithm>
#include <vector>

#include "core/comm/random.h"
#include "insitu/plan/blocks.h"

namespace gxy::insitu {

inline Index3 randomPoints(Random& random) {
  return {2 + int64_t(random.below(20)), 2 + int64_t(random.below(20)), 2 + int64_t(random.below(20))};
}

inline Extent randomBox(Random& random, const Index3& points) {
  Extent box;
  for (size_t a = 0; a < 3; a++) {
    box.first[a] = int64_t(random.below(uint64_t(points[a])));
    box.points[a] = 1 + int64_t(random.below(uint64_t(points[a] - box.first[a])));
  }
  return box;
}

/// Cuts the grid at random places, and gives each part to one of `ranks` ranks. Parts of one point and ranks without a part
/// occur.
inline std::vector<Block> randomBlocks(Random& random, const Index3& points, int ranks) {
  std::vector<Extent> parts{{{0, 0, 0}, points}};
  for (int cuts = int(random.below(uint64_t(ranks) * 2)); cuts > 0; cuts--) {
    const size_t i = random.below(parts.size());
    const size_t axis = random.below(3);
    if (parts[i].points[axis] < 2) continue;
    Extent upper = parts[i];
    const int64_t cut = 1 + int64_t(random.below(uint64_t(parts[i].points[axis] - 1)));
    parts[i].points[axis] = cut;
    upper.first[axis] += cut;
    upper.points[axis] -= cut;
    parts.push_back(upper);
  }
  std::vector<Block> blocks;
  std::vector<int> next(size_t(ranks), 0);
  for (const Extent& part : parts) {
    const int rank = int(random.below(uint64_t(ranks)));
    blocks.push_back({rank, next[size_t(rank)]++, part});
  }
  return blocks;
}

}  // namespace gxy::insitu

// SPDX-License-Identifier: Apache-2.0
#include "insitu/plan/redistribution.h"

#include <algorithm>
#include <tuple>

namespace gxy::insitu {

std::vector<Piece> piecesFor(int owner, const Grid& grid, const Partitioning& partitioning,
                             const BlockSearch& search) {
  std::vector<Piece> pieces;
  for (const int p : partitioning.owned(owner)) {
    const Extent owned = ownedPoints(grid, partitioning, p);
    if (owned.count() == 0) continue;
    search.overlapping(owned, [&](size_t number, const Extent& common) {
      const Block& block = search.blocks()[number];
      pieces.push_back({block.rank, block.index, owner, p, common});
      return true;
    });
  }
  std::sort(pieces.begin(), pieces.end(), [](const Piece& a, const Piece& b) {
    return std::tuple(a.rank, a.block, a.partition) < std::tuple(b.rank, b.block, b.partition);
  });
  return pieces;
}

std::vector<std::vector<Destination>> destinations(int ranks, const Grid& grid,
                                                   const Partitioning& partitioning, int owners,
                                                   const BlockSearch& blocks) {
  std::vector<std::vector<Destination>> all(static_cast<size_t>(ranks));
  for (int owner = 0; owner < owners; owner++)
    for (Piece& piece : piecesFor(owner, grid, partitioning, blocks)) {
      auto& list = all[size_t(piece.rank)];
      if (list.empty() || list.back().owner != owner) list.push_back({owner, {}});
      list.back().pieces.push_back(std::move(piece));
    }
  return all;
}

}  // namespace gxy::insitu

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
      pieces.push_back({block.rank, block.index, owner, p, common, 0});
      return true;
    });
  }
  std::sort(pieces.begin(), pieces.end(), [](const Piece& a, const Piece& b) {
    return std::tuple(a.rank, a.block, a.partition) < std::tuple(b.rank, b.block, b.partition);
  });
  return pieces;
}

std::vector<Piece> piecesFor(int owner, const Layout& layout) {
  std::vector<Piece> all;
  for (size_t m = 0; m < layout.meshes.size(); m++) {
    const Mesh& mesh = layout.meshes[m];
    if (mesh.kind == Mesh::Kind::Grid) {
      for (Piece& piece : piecesFor(owner, mesh.grid, layout.partitioning, layout.blocks[m])) {
        piece.mesh = int(m);
        all.push_back(std::move(piece));
      }
      continue;
    }
    for (size_t r = 0; r < layout.homes.size(); r++)
      if (layout.homes[r] == owner) all.push_back({int(r), 0, owner, -1, {}, int(m)});
  }
  return all;
}

std::vector<std::vector<Destination>> destinations(int ranks, int owners, const Layout& layout) {
  std::vector<std::vector<Destination>> all(static_cast<size_t>(ranks));
  for (int owner = 0; owner < owners; owner++)
    for (Piece& piece : piecesFor(owner, layout)) {
      auto& list = all[size_t(piece.rank)];
      if (list.empty() || list.back().owner != owner) list.push_back({owner, {}});
      list.back().pieces.push_back(std::move(piece));
    }
  return all;
}

}  // namespace gxy::insitu

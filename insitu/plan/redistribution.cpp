// SPDX-License-Identifier: Apache-2.0
#include "insitu/plan/redistribution.h"

#include <algorithm>
#include <set>
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

std::optional<Partitioning> partitionsOf(const Grid& grid, std::span<const Block> blocks, int ranks,
                                         int owners) {
  double cells = 1;  // of the lattice that the faces make, which each rank has a table of
  for (size_t a = 0; a < 3; a++) {
    std::set<int64_t> faces;
    for (const Block& block : blocks) faces.insert(block.extent.first[a]);
    cells *= double(faces.size());
  }
  constexpr double kFew = 1 << 16, kForEach = 64;
  if (cells > kFew + kForEach * double(blocks.size())) return std::nullopt;
  const Box domain = grid.box();
  // Cells are cut at their faces, between their centres.
  const double before = grid.rim ? 0.5 : 0;
  std::vector<Box> boxes;
  std::vector<int32_t> ownersOfBoxes;
  for (const Block& block : blocks) {
    Box box = domain;
    for (int a = 0; a < 3; a++) {
      const int64_t first = block.extent.first[size_t(a)], end = first + block.extent.points[size_t(a)];
      if (first > 0) box.lo[a] = grid.origin[a] + grid.spacing[a] * (double(first) - before);
      if (end < grid.points[size_t(a)]) box.hi[a] = grid.origin[a] + grid.spacing[a] * (double(end) - before);
    }
    if (!(box.lo.x < box.hi.x && box.lo.y < box.hi.y && box.lo.z < box.hi.z)) continue;
    boxes.push_back(box);
    ownersOfBoxes.push_back(int32_t(int64_t(block.rank) * owners / ranks));
  }
  return Partitioning::fromBoxes(boxes, std::move(ownersOfBoxes));
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

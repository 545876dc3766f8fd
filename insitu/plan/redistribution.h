// SPDX-License-Identifier: Apache-2.0
// Which samples go from which rank of a simulation to which rank of Galaxy.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/comm/transport.h"
#include "core/data/partitioning.h"
#include "insitu/plan/blocks.h"
#include "insitu/plan/description.h"

namespace gxy::insitu {

/// What travels together from a rank of the simulation to a rank of Galaxy: the points that a block of a grid and a partition
/// have in common, x fastest; or all particles or cells of the rank.
struct Piece {
  int rank = 0;       ///< of the simulation
  int block = 0;      ///< place among the blocks of that rank; 0 for particles and cells
  int owner = 0;      ///< the rank of Galaxy that gets it: the owner of the partition
  int partition = 0;  ///< -1 for particles and cells, which may lie anywhere
  Extent points;      ///< empty for particles and cells
  int mesh = 0;
  bool operator==(const Piece&) const = default;
};

/// What decides where samples go. What it refers to must outlive it.
struct Layout {
  std::span<const Mesh> meshes;
  std::span<const BlockSearch> blocks;  ///< by mesh; of grids
  std::span<const int>
      homes;  ///< by rank of the simulation: the rank of Galaxy that gets its particles and cells
  const Partitioning& partitioning;
};

/// Returns the pieces of a grid for the partitions that rank `owner` owns, in the order of rank, block and partition. A point that
/// no partition owns (ownedPoints()) is in no piece, since Galaxy does not keep it.
std::vector<Piece> piecesFor(int owner, const Grid& grid, const Partitioning& partitioning,
                             const BlockSearch& blocks);
/// Returns the pieces of all meshes for rank `owner`, mesh by mesh. Each rank of Galaxy calls it for itself.
std::vector<Piece> piecesFor(int owner, const Layout& layout);

/// Returns a partitioning of the grid whose partitions are the blocks, so that no sample goes to another rank of Galaxy than the one
/// that takes its rank's place: rank r of n goes to r * owners / n. The blocks have all points of the grid (checkCover()). Points of a
/// block without cells, at the end of the grid, are in the partition of the cells beside them. Returns none if blocks lie so
/// irregularly that the faces of all of them together would cut the grid into far more boxes than there are blocks.
std::optional<Partitioning> partitionsOf(const Grid& grid, std::span<const Block> blocks, int ranks,
                                         int owners);

/// A rank of Galaxy that a rank of the simulation sends to, and what: the pieces in the order in which they are sent.
struct Destination {
  int owner = 0;
  std::vector<Piece> pieces;
  bool operator==(const Destination&) const = default;
};

/// Returns, by rank of the simulation, where its points go. `owners`: the number of ranks of Galaxy.
std::vector<std::vector<Destination>> destinations(int ranks, int owners, const Layout& layout);

}  // namespace gxy::insitu

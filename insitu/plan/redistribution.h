// SPDX-License-Identifier: Apache-2.0
// Which samples go from which rank of a simulation to which rank of Galaxy.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "core/comm/transport.h"
#include "core/data/partitioning.h"
#include "insitu/plan/blocks.h"

namespace gxy::insitu {

/// The points that a block of the simulation and a partition of Galaxy have in common. They travel together, x fastest.
struct Piece {
  int rank = 0;   ///< of the simulation
  int block = 0;  ///< place among the blocks of that rank
  int owner = 0;  ///< the rank of Galaxy that owns the partition
  int partition = 0;
  Extent points;
  bool operator==(const Piece&) const = default;
};

/// Returns the pieces of the partitions that rank `owner` owns, in the order of rank, block and partition. Each rank of Galaxy
/// calls it for itself. A point that no partition owns (ownedPoints()) is in no piece, since Galaxy does not keep it.
std::vector<Piece> piecesFor(int owner, const Grid& grid, const Partitioning& partitioning,
                             const BlockSearch& blocks);

/// A rank of Galaxy that a rank of the simulation sends to, and what: the pieces in the order in which they are sent.
struct Destination {
  int owner = 0;
  std::vector<Piece> pieces;
  bool operator==(const Destination&) const = default;
};

/// Returns, by rank of the simulation, where its points go.
std::vector<std::vector<Destination>> destinations(int ranks, const Grid& grid,
                                                   const Partitioning& partitioning, int owners,
                                                   const BlockSearch& blocks);

}  // namespace gxy::insitu

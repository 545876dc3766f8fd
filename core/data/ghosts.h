// SPDX-License-Identifier: Apache-2.0
// Ghosts of volumes that a simulation has computed: each partition gets them from the partitions that own these points.
// (Volumes that are read from files get them from there.)
//
//   1. Every rank makes a GhostPlan, once for a grid and a partitioning.
//   2. For each step, every rank fills the points that its partitions own, and calls exchangeGhosts().
//   3. Every rank calls completeBricks() (complete_volume.h), with statistics of its points if these are needed.
#pragma once
#include <map>
#include <span>
#include <vector>

#include "core/comm/collectives.h"
#include "core/data/partitioning.h"
#include "core/data/volume.h"

namespace gxy {

/// Says which points the partitions of one rank give to other partitions, and which they get. The owner of a point gives it
/// to every partition whose block contains it. A plan depends on the grid and on how it is cut only, so one plan serves all
/// steps of a simulation. It is immutable after construction; any thread may read it.
class GhostPlan {
 public:
  /// Points that partition `from` owns and that the block of partition `to` contains.
  struct Piece {
    int from = 0, to = 0;
    Extent points;
    bool operator==(const Piece&) const = default;
  };

  /// Makes the plan of `rank` for blocks with the extents extentOf(grid, box, ghosts). This takes time in proportion to the
  /// number of all partitions, and to the neighbours of this rank's. Every rank throws the same Error if some point of the grid
  /// belongs to no partition, if the owner of a partition is not below `ranks`, or if `ghosts` is negative.
  GhostPlan(const Grid& grid, const Partitioning& partitioning, int ghosts, int rank, int ranks);

  int rank() const { return rank_; }
  int ranks() const { return int(sent_.size()); }
  /// The extents of the blocks of this rank, by partition. Partitions that do not touch the grid have no block.
  const std::map<int, Extent>& blocks() const { return blocks_; }

  /// The pieces that go from partitions of this rank to those of `rank`, ordered by `from` and then by `to`. The plan of `rank`
  /// has the same ones in receivedFrom(). Of its own rank, a plan has the pieces between the rank's own partitions.
  std::span<const Piece> sentTo(int rank) const { return sent_[size_t(rank)]; }
  /// The pieces that go from partitions of `rank` to those of this rank, in the same order.
  std::span<const Piece> receivedFrom(int rank) const { return received_[size_t(rank)]; }

 private:
  int rank_;
  std::map<int, Extent> blocks_;
  std::vector<std::vector<Piece>> sent_, received_;  ///< by the other rank
};

/// Collective. Gives all blocks their ghosts. Each volume has the blocks of the plan, with samples of type `volume.stored` in
/// bricks (bricks.h). Before the call, the points of ownedPoints() have their samples; the call fills all others. The volumes may differ
/// in type and number of components. All ranks give the same ones in the same order. A rank sends one message to each other
/// rank, for all volumes together; it is empty if no partition there needs points of this rank. If any rank fails, all throw the
/// same Error, and the points that are not owned are undefined.
void exchangeGhosts(std::span<Volume* const> volumes, const GhostPlan& plan, Collectives& ranks);

}  // namespace gxy

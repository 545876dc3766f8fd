// SPDX-License-Identifier: Apache-2.0
#include "core/data/ghosts.h"

#include <algorithm>
#include <string>
#include <tuple>
#include <utility>

#include "core/comm/error.h"
#include "core/data/bricks.h"
#include "core/data/extents.h"
#include "core/data/replicate.h"

namespace gxy {
namespace {

using Piece = GhostPlan::Piece;
using Volumes = std::span<Volume* const>;

/// The points of a partition: those that it owns, and all that its block contains.
struct PartitionPoints {
  Extent owned, block;
};

std::vector<PartitionPoints> allPoints(const Grid& grid, const Partitioning& partitioning, int ghosts) {
  std::vector<PartitionPoints> points;
  for (int p = 0; p < partitioning.partitions(); ++p)
    points.push_back({ownedPoints(grid, partitioning, p), extentOf(grid, partitioning.box(p), ghosts)});
  return points;
}

/// Throws Error unless each point of the grid has an owner.
void checkCoverage(const Grid& grid, std::span<const PartitionPoints> partitions) {
  const Extent first{{0, 0, 0}, {1, 1, 1}};
  int64_t owned = 0;
  bool firstIsOwned = false;
  for (const PartitionPoints& points : partitions) {
    owned += points.owned.count();
    firstIsOwned |= intersection(points.owned, first).count() > 0;
  }
  if (owned == Extent{{0, 0, 0}, grid.points}.count()) return;
  // No point has two owners, and all points that have one form a box. So if there is a point without an owner, the first
  // or the last point of the grid has none.
  std::string point = "(0, 0, 0)";
  if (firstIsOwned)
    point = "(" + std::to_string(grid.points[0] - 1) + ", " + std::to_string(grid.points[1] - 1) + ", " +
            std::to_string(grid.points[2] - 1) + ")";
  throw Error("ghosts: no partition owns point " + point + " of the grid, expected partitions that cover it");
}

void checkOwners(const Partitioning& partitioning, int ranks) {
  for (int p = 0; p < partitioning.partitions(); ++p)
    if (partitioning.owner(p) >= ranks)
      throw Error("ghosts: partition " + std::to_string(p) + " is owned by rank " +
                  std::to_string(partitioning.owner(p)) + ", expected fewer than " + std::to_string(ranks));
}

/// Returns partitions, ascending. Among them are all whose blocks contain points that `partition` owns, and all that own
/// points of its block.
std::vector<int> neighbours(const Grid& grid, const Partitioning& partitioning, int partition, int ghosts) {
  // A block reaches less than ghosts + 1 cells beyond its partition's box, and the points that a partition owns reach less than
  // one cell beyond it. One cell more is for rounding.
  const double cells = double(ghosts) + 3;
  Box near = partitioning.box(partition);
  near.lo -= cells * grid.spacing;
  near.hi += cells * grid.spacing;
  return partitionsTouched(partitioning, near, 0);
}

void addPiece(std::vector<Piece>& pieces, int from, int to, std::span<const PartitionPoints> points) {
  const Extent both = intersection(points[size_t(from)].owned, points[size_t(to)].block);
  if (both.count() > 0) pieces.push_back({from, to, both});
}

size_t bytesPerPoint(const Volume& volume) { return bytesOf(volume.stored) * size_t(volume.components); }

/// Throws Error unless the plan is this rank's and each volume has the plan's blocks.
void checkBlocks(Volumes volumes, const GhostPlan& plan, const Collectives& ranks) {
  if (plan.rank() != ranks.rank() || plan.ranks() != ranks.size())
    throw Error("ghosts: the plan is for rank " + std::to_string(plan.rank()) + " of " +
                std::to_string(plan.ranks()) + ", expected rank " + std::to_string(ranks.rank()) + " of " +
                std::to_string(ranks.size()));
  for (const Volume* volume : volumes) {
    for (const auto& [partition, extent] : plan.blocks()) {
      const std::string where =
          "ghosts: volume '" + volume->name + "', partition " + std::to_string(partition) + ": ";
      const auto block = volume->blocks.find(partition);
      if (block == volume->blocks.end() || block->second.extent != extent)
        throw Error(where + "there is no block with the extent of the plan");
      const size_t bytes = block->second.samples.size(),
                   expected = Bricks(extent.points).count() * bytesPerPoint(*volume);
      if (bytes != expected)
        throw Error(where + "the block has " + std::to_string(bytes) + " bytes of samples, expected " +
                    std::to_string(expected));
    }
  }
}

/// Calls use(volume, piece, first, bytes) for the samples of each piece of each volume, in the order of a message. In the
/// message they are the `bytes` bytes from byte `first` on. Returns the size of the message.
template <class Use>
size_t forSamples(Volumes volumes, std::span<const Piece> pieces, Use use) {
  size_t first = 0;
  for (Volume* volume : volumes) {
    for (const Piece& piece : pieces) {
      const size_t bytes = size_t(piece.points.count()) * bytesPerPoint(*volume);
      use(*volume, piece, first, bytes);
      first += bytes;
    }
  }
  return first;
}

size_t messageSize(Volumes volumes, std::span<const Piece> pieces) {
  return forSamples(volumes, pieces, [](const Volume&, const Piece&, size_t, size_t) {});
}

void copyLocally(Volumes volumes, std::span<const Piece> pieces, const Collectives& ranks) {
  Bytes samples;
  forSamples(volumes, pieces, [&](Volume& volume, const Piece& piece, size_t, size_t bytes) {
    ranks.check();
    const VolumeBlock& from = volume.blocks.at(piece.from);
    VolumeBlock& to = volume.blocks.at(piece.to);
    samples.resize(bytes);
    copyFromBricks(from.samples, from.extent, piece.points, samples, bytesPerPoint(volume));
    storeInBricks(to.samples, to.extent, piece.points, 0, samples, bytesPerPoint(volume));
  });
}

Bytes pack(Volumes volumes, std::span<const Piece> pieces, const Collectives& ranks) {
  Bytes message(messageSize(volumes, pieces));
  forSamples(volumes, pieces, [&](const Volume& volume, const Piece& piece, size_t first, size_t bytes) {
    ranks.check();
    const VolumeBlock& from = volume.blocks.at(piece.from);
    copyFromBricks(from.samples, from.extent, piece.points, std::span(message).subspan(first, bytes),
                   bytesPerPoint(volume));
  });
  return message;
}

void unpack(const Bytes& message, Volumes volumes, std::span<const Piece> pieces, const Collectives& ranks) {
  forSamples(volumes, pieces, [&](Volume& volume, const Piece& piece, size_t first, size_t bytes) {
    ranks.check();
    VolumeBlock& to = volume.blocks.at(piece.to);
    storeInBricks(to.samples, to.extent, piece.points, 0, std::span(message).subspan(first, bytes),
                  bytesPerPoint(volume));
  });
}

}  // namespace

GhostPlan::GhostPlan(const Grid& grid, const Partitioning& partitioning, int ghosts, int rank, int ranks)
    : rank_(rank), sent_(size_t(ranks)), received_(size_t(ranks)) {
  if (ghosts < 0) throw Error("ghosts: " + std::to_string(ghosts) + " layers, expected 0 or more");
  checkOwners(partitioning, ranks);
  const std::vector<PartitionPoints> points = allPoints(grid, partitioning, ghosts);
  checkCoverage(grid, points);
  for (const int mine : partitioning.owned(rank)) {
    const Extent& block = points[size_t(mine)].block;
    if (block.count() == 0) continue;
    blocks_.emplace(mine, block);
    for (const int other : neighbours(grid, partitioning, mine, ghosts)) {
      if (other == mine) continue;
      const auto owner = size_t(partitioning.owner(other));
      addPiece(sent_[owner], mine, other, points);
      addPiece(received_[owner], other, mine, points);
    }
  }
  const auto order = [](const Piece& piece) { return std::tuple(piece.from, piece.to); };
  for (auto& pieces : received_)
    std::sort(pieces.begin(), pieces.end(),
              [&](const Piece& a, const Piece& b) { return order(a) < order(b); });
}

void exchangeGhosts(std::span<Volume* const> volumes, const GhostPlan& plan, Collectives& ranks) {
  const int rank = ranks.rank(), size = ranks.size();
  std::vector<Bytes> messages(static_cast<size_t>(size));
  agree(ranks, [&] {
    checkBlocks(volumes, plan, ranks);
    for (int r = 0; r < size; ++r)
      if (r != rank) messages[size_t(r)] = pack(volumes, plan.sentTo(r), ranks);
  });
  std::vector<Bytes> received = ranks.allToAll(std::move(messages));
  agree(ranks, [&] {
    copyLocally(volumes, plan.sentTo(rank), ranks);
    for (int r = 0; r < size; ++r) {
      if (r == rank) continue;
      const Bytes message = std::move(received[size_t(r)]);
      const size_t expected = messageSize(volumes, plan.receivedFrom(r));
      if (message.size() != expected)
        throw Error("ghosts: rank " + std::to_string(r) + " has sent " + std::to_string(message.size()) +
                    " bytes of samples, expected " + std::to_string(expected));
      unpack(message, volumes, plan.receivedFrom(r), ranks);
    }
  });
}

}  // namespace gxy

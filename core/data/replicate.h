// SPDX-License-Identifier: Apache-2.0
// Replication: copies each primitive into every partition that it touches, so that no border cuts a primitive.
//
//   1. Every rank has a part of the primitives, each primitive is on one rank only.
//   2. Every rank calls packForOwners(), which makes one message for each rank, for as many primitives at a time as may be
//      under way. The ranks exchange the messages all-to-all.
//   3. Every rank gives what it has received to its ReceivedBlocks, which make its blocks of all that has come.
#pragma once
#include <functional>
#include <limits>
#include <map>
#include <span>
#include <vector>

#include "core/comm/transport.h"
#include "core/data/geometry.h"
#include "core/data/partitioning.h"

namespace gxy {

/// Returns the radius, in world units, at a point with this radiusValue(). A result that is not > 0 counts as 0.
using RadiusOf = std::function<double(double value)>;

/// Returns the distance, in world units, by which a primitive's box is inflated in addition to its radius. It
/// is the sum of 16 ulp of float in render space, where the domain's longest side is 1 and hits are computed,
/// and 8 ulp of double at the domain's largest coordinate.
double borderSlack(const Partitioning& partitioning);

/// Returns the partitions, ascending, whose closed boxes meet `box` inflated by radius and slack. Partitions
/// at the domain's ends reach outwards without limit, so everything outside the domain belongs to them.
std::vector<int> partitionsTouched(const Partitioning& partitioning, const Box& box, double radius);

/// Some of a block's primitives: those from number `first` on, before number `last`, or up to the block's last one.
struct PrimitiveSpan {
  size_t first = 0, last = std::numeric_limits<size_t>::max();
};

/// Returns one message for each rank, including this one, with the primitives of `read` in `span` that touch the rank's
/// partitions. A segment comes with its neighbours' points. A segment or particle is as thick as the largest
/// radius at its points; a triangle has no radius. Coordinates must be finite (dropUnusable()). Throws Error
/// for an invalid block, which it looks at when `span` has its first primitive, or if a partition's owner is not below `ranks`.
std::vector<Bytes> packForOwners(
    const GeometryBlock& read, GeometryKind kind, const Partitioning& partitioning, const RadiusOf& radius,
    int ranks, const Advance& advance = [](double) {}, PrimitiveSpan span = {});

/// The primitives that have come for the partitions of a rank. The partitioning must outlive it.
class ReceivedBlocks {
 public:
  ReceivedBlocks(GeometryKind kind, const Partitioning& partitioning, int rank);

  /// Takes one message of each rank, in any order. Throws Error for a malformed one.
  void take(std::span<const Bytes> messages);

  /// Returns the blocks of all partitions of the rank, including empty ones, as merged() makes them of all that has come. It is
  /// called once, after the last take().
  std::map<int, GeometryBlock> merged(const Advance& advance = [](double) {});

 private:
  const GeometryKind kind_;
  const int rank_;
  std::map<int, std::vector<GeometryBlock>> parts_;  ///< by partition
};

/// Returns the primitives of a block whose home is each of so many ranks, ascending. The home of a primitive is the owner of
/// the partition that contains its first point, or is nearest to it outside the domain. So each primitive has one home.
std::vector<std::vector<uint32_t>> homesOf(
    const GeometryBlock& block, GeometryKind kind, const Partitioning& partitioning, int ranks,
    const Advance& advance = [](double) {});

}  // namespace gxy

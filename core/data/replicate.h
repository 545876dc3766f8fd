// SPDX-License-Identifier: Apache-2.0
// Replication: copies each primitive into every partition that it touches, so that no border cuts a primitive.
//
//   1. Every rank reads a part of the primitives, each primitive on one rank only. (Or every rank reads the whole
//      file and calls keepHome().)
//   2. Every rank calls packForOwners(), which makes one message for each rank. The ranks exchange them all-to-all.
//   3. Every rank calls unpackReceived().
#pragma once
#include <functional>
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

/// Returns one message for each rank, including this one, with the primitives of `read` that touch the rank's
/// partitions. A segment comes with its neighbours' points. A segment or particle is as thick as the largest
/// radius at its points; a triangle has no radius. Coordinates must be finite (dropUnusable()). Throws Error
/// for an invalid block, or if a partition's owner is not below `ranks`.
std::vector<Bytes> packForOwners(
    const GeometryBlock& read, GeometryKind kind, const Partitioning& partitioning, const RadiusOf& radius,
    int ranks, const Advance& advance = [](double) {});

/// Returns the blocks of all partitions of `rank`, including empty ones, from the messages of all ranks in
/// any order. The blocks are as merged() makes them. Throws Error for a malformed message.
std::map<int, GeometryBlock> unpackReceived(
    GeometryKind kind, const Partitioning& partitioning, int rank, std::span<const Bytes> received,
    const Advance& advance = [](double) {});

/// From a block that every rank has read in full, returns the primitives whose home is this rank. The home of
/// a primitive is the owner of the partition that contains its first point, or is nearest to it outside the
/// domain. So each primitive has one home.
GeometryBlock keepHome(
    const GeometryBlock& read, GeometryKind kind, const Partitioning& partitioning, int rank,
    const Advance& advance = [](double) {});

}  // namespace gxy

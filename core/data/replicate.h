// SPDX-License-Identifier: Apache-2.0
// Replication: every primitive in every partition that it touches, so that no border cuts one.
//
//   every rank reads its part, each primitive on one rank only   (or all of a file, then keepHome())
//   packForOwners() on every rank -> one message per rank -> all-to-all -> unpackReceived() on every rank
#pragma once
#include <functional>
#include <map>
#include <span>
#include <vector>

#include "core/comm/transport.h"
#include "core/data/geometry.h"
#include "core/data/partitioning.h"

namespace gxy {

/// The radius (world units) at a point with this radiusValue(). What is not > 0 counts as 0.
using RadiusOf = std::function<double(double value)>;

/// By how much a primitive's box is inflated, besides its radius: 16 ulp of float in render space, where the
/// domain's longest side is 1 and where hits are computed, and 8 ulp of double at the domain's largest
/// coordinate.
double borderSlack(const Partitioning& partitioning);

/// The partitions whose closed boxes meet `box` inflated by radius and slack, ascending. Partitions at the
/// domain's ends reach outwards without limit: whatever lies outside belongs to them.
std::vector<int> partitionsTouched(const Partitioning& partitioning, const Box& box, double radius);

/// One message for each rank (own rank included): the primitives of `read` that touch its partitions, a
/// segment together with its neighbours' points. Segments and particles are as thick as the largest radius at
/// their points, triangles have none. Coordinates must be finite (dropUnusable). Throws Error for an invalid
/// block, or if a partition's owner is not below `ranks`.
std::vector<Bytes> packForOwners(
    const GeometryBlock& read, GeometryKind kind, const Partitioning& partitioning, const RadiusOf& radius,
    int ranks, const Advance& advance = [](double) {});

/// The blocks of all partitions of `rank` (empty ones included), from the messages of all ranks in any order;
/// see merged() for what they look like. Throws Error for a malformed message.
std::map<int, GeometryBlock> unpackReceived(
    GeometryKind kind, const Partitioning& partitioning, int rank, std::span<const Bytes> received,
    const Advance& advance = [](double) {});

/// Of a block that every rank has read in full, the primitives at home on this rank: those whose first point
/// lies in (or, outside the domain, nearest to) one of its partitions. Each primitive has one home.
GeometryBlock keepHome(
    const GeometryBlock& read, GeometryKind kind, const Partitioning& partitioning, int rank,
    const Advance& advance = [](double) {});

}  // namespace gxy

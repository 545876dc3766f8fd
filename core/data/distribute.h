// SPDX-License-Identifier: Apache-2.0
// Geometry goes from the ranks that own its primitives to the partitions that these touch, and from the rank that has read it
// to those that are to own it. So many primitives are under way at a time that messages take some megabytes.
#pragma once
#include <memory>

#include "core/comm/collectives.h"
#include "core/data/geometry.h"
#include "core/data/owned_geometry.h"
#include "core/data/partitioning.h"
#include "core/data/replicate.h"

namespace gxy {

/// Collective. Copies primitives into every partition that they touch with this radius (world units), and returns those of the
/// partitions of this rank. Tells ranks.done() how far it is. If any rank fails, all throw the same Error.
std::shared_ptr<Geometry> distribute(const OwnedGeometry& owned, const Partitioning& partitioning,
                                     const RadiusOf& radius, Collectives& ranks);

/// Collective. Rank 0 has all primitives in a valid block, the other ranks have none. Returns the primitives whose home is this
/// rank (homesOf()), in the order that they have in the block. If any rank fails, all throw the same Error.
GeometryBlock keepHome(const GeometryBlock& all, GeometryKind kind, const Partitioning& partitioning,
                       Collectives& ranks);

}  // namespace gxy

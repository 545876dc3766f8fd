// SPDX-License-Identifier: Apache-2.0
// Brings all of a dataset to one rank: for a file, or for a client.
#pragma once
#include <cstdint>
#include <functional>
#include <span>

#include "core/comm/collectives.h"
#include "core/data/owned_geometry.h"
#include "core/data/volume.h"

namespace gxy {

/// The type of values that are gathered: that in which they are stored, or Float64 where values are shift + scale * stored.
ScalarType gatheredType(const Volume& volume);
/// Points per axis of what is gathered, without the rim of the grid.
Index3 gatheredPoints(const Grid& grid);
/// Bytes of one slice of it, all points of one z.
int64_t gatheredSliceBytes(const Volume& volume);

/// Collective. Gathers the values of a volume on rank 0, as many slices at a time as fit in `bytes`, at least one. There take() gets each
/// of these parts in order: the number of its first slice, and its values, x fastest, components together. Ranks need the memory of
/// two such parts. Throws Error on all ranks if check() or take() throws, or if a point belongs to no partition.
void gatherSlices(const Volume& volume, const Partitioning& partitioning, Collectives& ranks, int64_t bytes,
                  const std::function<void(int64_t first, std::span<const std::byte> values)>& take);

/// Collective. Returns all primitives, by ascending id, on rank 0, and nothing on other ranks. Rank 0 needs about three times the memory of
/// all primitives. Throws Error on all ranks if one does not fit into messages.
GeometryBlock gatherGeometry(const OwnedGeometry& geometry, Collectives& ranks);

}  // namespace gxy

// SPDX-License-Identifier: Apache-2.0
// How data are cut when nobody says how.
#pragma once
#include <array>
#include <memory>

#include "core/data/partitioning.h"
#include "core/data/volume.h"

namespace gxy {

/// Cuts the box of all data that are shown together into blocks near to cubes, dealt out evenly to `ranks`.
/// The cuts lie on the points of `grid` (of the first volume, or null) if it fills the box. `wanted`: partitions
/// along each axis; {n, 0, 0}: n in all; {0, 0, 0}: one for each rank, or as many as keep each below 2^28 points,
/// but fewer where a small grid cannot be cut into so many. A flat or empty box is given some thickness.
std::shared_ptr<const Partitioning> automaticPartitioning(const Box& data, const Grid* grid,
                                                          std::array<int, 3> wanted, int ranks);

}  // namespace gxy

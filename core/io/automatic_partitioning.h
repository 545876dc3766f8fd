// SPDX-License-Identifier: Apache-2.0
// The default partitioning of data.
#pragma once
#include <array>
#include <memory>

#include "core/data/partitioning.h"
#include "core/data/volume.h"

namespace gxy {

/// Cuts the box of all data that are shown together into blocks that are nearly cubes, distributed evenly
/// over `ranks` ranks. `grid` is the grid of the first volume, or null; if it fills the box, the cuts lie on
/// its points. `wanted` is the number of partitions along each axis. {n, 0, 0} means n in all. {0, 0, 0}
/// means one for each rank, or as many as keep each below 2^28 points, or fewer if a small grid cannot be cut
/// into so many. A flat or empty box gets some thickness. Throws Error if the grid cannot be cut as wanted.
std::shared_ptr<const Partitioning> automaticPartitioning(const Box& data, const Grid* grid,
                                                          std::array<int, 3> wanted, int ranks);

}  // namespace gxy

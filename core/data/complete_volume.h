// SPDX-License-Identifier: Apache-2.0
// From samples to a volume that can be rendered: statistics over all ranks, encoding, bricks, macrocells.
#pragma once
#include <cstdint>
#include <functional>

#include "core/comm/collectives.h"
#include "core/data/partitioning.h"
#include "core/data/volume.h"

namespace gxy {

/// Collective. Completes a volume whose blocks (of the partitions of this rank that touch its grid, extents as extentOf()
/// gives them) hold samples of type `volume.stored`, x fastest: fills ranges, noDataSamples, and summaries merged over all
/// ranks, stores the samples as encodingOf() says of the whole field (`stored`, `shift` and `scale` may change), and puts
/// them into bricks. If any rank fails, all throw the same Error. Memory: for types that change, once more the block that
/// is being converted.
void completeVolume(Volume& volume, const Partitioning& partitioning, Collectives& ranks);

/// The same for a volume that has only some components of a field: values of a field with `fieldComponents` are stored as
/// if all of them were here. `stored` is called with the number of points that were stored since its last call; it may be
/// empty.
void completeVolume(Volume& volume, const Partitioning& partitioning, Collectives& ranks, int fieldComponents,
                    const std::function<void(int64_t)>& stored);

}  // namespace gxy

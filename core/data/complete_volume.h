// SPDX-License-Identifier: Apache-2.0
// From samples to a volume that can be rendered: statistics over all ranks, encoding, bricks, macrocells.
#pragma once
#include <cstdint>
#include <functional>
#include <optional>

#include "core/comm/collectives.h"
#include "core/data/partitioning.h"
#include "core/data/volume.h"

namespace gxy {

/// How another volume is stored.
struct StoredLike {
  Encoding encoding;
  bool rangesOfStored = false;
};

/// Collective. Completes a volume whose samples have just been read or computed. It has a block, of the extent that extentOf()
/// gives, for each partition of this rank that touches its grid; the samples are of type `volume.stored`, x fastest. Points that blocks
/// have in common have the same samples in all of them. Fills
/// `ranges`, `noDataSamples` and the blocks' summaries, which are those of all ranks together. Stores the samples as
/// encodingOf() says of the whole field, so `stored`, `shift` and `scale` may change, and puts them into bricks. A type that
/// changes takes the memory of one more block meanwhile. If any rank fails, all throw the same Error.
void completeVolume(Volume& volume, const Partitioning& partitioning, Collectives& ranks);

/// Does the same for a volume that has some of the `fieldComponents` components of a field: they are stored as they would be
/// beside the others. `stored`, if it is not empty, is told how many points were stored since its last call. Where the encoding
/// of `like` suffices(), the samples are stored so.
void completeVolume(Volume& volume, const Partitioning& partitioning, Collectives& ranks, int fieldComponents,
                    const std::function<void(int64_t)>& stored,
                    const std::optional<StoredLike>& like = std::nullopt);

/// Whether completeBricks() must be told the statistics of a field. The ranges of others come from the summaries.
bool needsStatistics(const Volume& volume, const Partitioning& partitioning);

/// Collective. Does the same for a volume whose samples are in bricks already (bricks.h), with zeros as padding. Where
/// needsStatistics(), `mine` are the statistics of the points that the partitions of this rank own (ownedPoints).
void completeBricks(Volume& volume, const Partitioning& partitioning, Collectives& ranks,
                    FieldStatistics mine, int fieldComponents,
                    const std::function<void(int64_t)>& stored = {},
                    const std::optional<StoredLike>& like = std::nullopt);

}  // namespace gxy

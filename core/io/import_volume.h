// SPDX-License-Identifier: Apache-2.0
// A volume file becomes the blocks of a rank's partitions.
#pragma once
#include <memory>
#include <optional>
#include <string>

#include "core/comm/collectives.h"
#include "core/data/complete_volume.h"
#include "core/data/partitioning.h"
#include "core/data/volume.h"
#include "core/io/left_out.h"
#include "core/io/volume_file.h"

namespace gxy {

/// The grid of a volume file, on every rank; read by rank 0 only. What a partitioning is made of before an
/// import. On rank 0 the file's warnings are added to `warnings`; null: they are logged.
Grid gridOf(const std::string& path, const std::string& array, Collectives& ranks,
            std::vector<std::string>* warnings = nullptr);

/// Collective over `ranks`. Reads, for each partition that this rank owns, the samples it needs and `ghosts` layers more,
/// and completes the volume (complete_volume.h). The volume is named after the file and the array. Tells ranks.done() what of
/// this rank's points has been read and stored. If any rank fails, all throw the same Error. Of the components of the array
/// only `components`, which ascend, are kept if there are any; their values are stored as they are beside the others. What is
/// left out is added to `leftOut`.
std::shared_ptr<Volume> importVolume(const std::string& path, const std::string& array,
                                     const Partitioning& partitioning, int ghosts, Collectives& ranks,
                                     std::vector<int> components = {}, LeftOut* leftOut = nullptr);
/// The same of a file that every rank has opened. All blocks are read in one pass (SampleSource::read). `like`: how samples of a wide
/// type are stored where that suffices() (completeVolume()).
std::shared_ptr<Volume> importVolume(VolumeFile file, const Partitioning& partitioning, int ghosts,
                                     Collectives& ranks, std::vector<int> components = {},
                                     LeftOut* leftOut = nullptr,
                                     const std::optional<StoredLike>& like = std::nullopt);

}  // namespace gxy

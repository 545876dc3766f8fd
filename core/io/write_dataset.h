// SPDX-License-Identifier: Apache-2.0
// Writes a dataset that is spread over all ranks to one file.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/comm/collectives.h"
#include "core/data/dataset.h"

namespace gxy {

/// The most bytes of slices of a volume that are gathered at once, if one slice is not larger.
inline constexpr int64_t kSlabBytes = 8 << 20;

/// Returns the extensions of files that hold a volume of any sort, or geometry of this kind.
std::vector<std::string> extensionsFor(const std::optional<GeometryKind>& kind);

/// Throws Error, with the names that are expected, unless a file of this name can hold a dataset of this kind. `what` names the dataset in
/// the message.
void checkFileFor(const std::optional<GeometryKind>& kind, const std::string& file, const std::string& what);

/// Likewise for this dataset: a volume on a uniform grid and an unstructured one are in files of different kinds.
void checkFileFor(const Dataset& dataset, const std::string& file, const std::string& what);

/// Returns an upper bound of the memory that writeDataset() takes on a rank. `root`: on rank 0.
int64_t gatheringBytes(const Dataset& dataset, bool root);

/// Returns what the values of a dataset are called in files.
std::string arrayName(const Dataset& dataset);

/// Collective. Gathers a dataset on rank 0, which writes it to `path`, in the format of the path's extension: a volume a few slices at a
/// time, geometry and unstructured volumes as a whole (write_volume.h and write_geometry.h say what is written). Other ranks do not use `path`. Throws Error on
/// all ranks if the file cannot be written, or ranks.check() throws; then the file is not complete.
void writeDataset(const Dataset& dataset, Collectives& ranks, const std::string& path);

}  // namespace gxy

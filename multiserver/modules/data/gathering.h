// SPDX-License-Identifier: Apache-2.0
// What verbs that gather a dataset on rank 0 have in common.
#pragma once
#include <cstdint>
#include <string>

#include "core/data/dataset.h"

namespace gxy {

/// The most bytes of slices of a volume that are gathered at once, if one slice is not larger.
inline constexpr int64_t kSlabBytes = 8 << 20;

/// Returns an upper bound of the memory that gathering a dataset takes on a rank, slabs of kSlabBytes at a time. `root`: on rank 0.
int64_t gatheringBytes(const Dataset& dataset, bool root);

/// The name of a dataset's array in files and messages.
std::string arrayName(const Dataset& dataset);

}  // namespace gxy

// SPDX-License-Identifier: Apache-2.0
// Merges the ranges and boxes of data that lie on several ranks.
#pragma once
#include <span>

#include "core/comm/collectives.h"
#include "core/data/box.h"

namespace gxy {

/// Collective. Replaces each range by its union over all ranks; every rank gives the same number of ranges.
void mergeRanges(Collectives& ranks, std::span<Range> ranges);

/// Collective. Replaces the box by its union over all ranks.
void mergeBox(Collectives& ranks, Box& box);

}  // namespace gxy

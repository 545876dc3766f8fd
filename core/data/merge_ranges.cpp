// SPDX-License-Identifier: Apache-2.0
#include "core/data/merge_ranges.h"

namespace gxy {

void mergeRanges(Collectives& ranks, std::span<Range> ranges) {
  for (const auto& theirs : gatherValues<Range>(ranks, ranges))
    for (size_t i = 0; i < theirs.size(); ++i) ranges[i].extend(theirs[i]);
}

void mergeBox(Collectives& ranks, Box& box) {
  for (const auto& theirs : gatherValues<Box>(ranks, std::span<const Box>(&box, 1))) box.extend(theirs[0]);
}

}  // namespace gxy

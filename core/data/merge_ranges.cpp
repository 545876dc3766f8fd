// SPDX-License-Identifier: Apache-2.0
#include "core/data/merge_ranges.h"

namespace gxy {

void mergeRanges(Collectives& ranks, std::span<Range> ranges) {
  reduceValues(ranks, ranges, [](Range a, const Range& b) {
    a.extend(b);
    return a;
  });
}

void mergeBox(Collectives& ranks, Box& box) {
  reduceValues(ranks, std::span(&box, 1), [](Box a, const Box& b) {
    a.extend(b);
    return a;
  });
}

}  // namespace gxy

// SPDX-License-Identifier: Apache-2.0
#include "core/data/extents.h"

#include <algorithm>
#include <cstring>

namespace gxy {

Extent intersection(const Extent& a, const Extent& b) {
  Extent both;
  for (size_t i = 0; i < 3; ++i) {
    both.first[i] = std::max(a.first[i], b.first[i]);
    const int64_t end = std::min(a.first[i] + a.points[i], b.first[i] + b.points[i]);
    both.points[i] = end - both.first[i];
    if (both.points[i] <= 0) return {};
  }
  return both;
}

void copyBox(const Extent& box, std::span<const std::byte> source, const Extent& from,
             std::span<std::byte> target, const Extent& to, size_t bytesPerPoint) {
  const auto offset = [&](const Extent& e, int64_t j, int64_t k) {
    const int64_t row = (k - e.first[2]) * e.points[1] + (j - e.first[1]);
    return size_t(row * e.points[0] + box.first[0] - e.first[0]) * bytesPerPoint;
  };
  if (box.count() == 0) return;
  // Rows that are consecutive in both are copied as one.
  const bool rows = box.points[0] == from.points[0] && box.points[0] == to.points[0];
  const int64_t together = rows ? box.points[1] : 1;
  for (int64_t k = box.first[2]; k < box.first[2] + box.points[2]; ++k)
    for (int64_t j = box.first[1]; j < box.first[1] + box.points[1]; j += together)
      std::memcpy(target.data() + offset(to, j, k), source.data() + offset(from, j, k),
                  size_t(box.points[0] * together) * bytesPerPoint);
}

}  // namespace gxy

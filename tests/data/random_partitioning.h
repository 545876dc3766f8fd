// SPDX-License-Identifier: Apache-2.0
// Seeded partitionings for property tests: k-d cuts of a box at arbitrary places.
#pragma once
#include <random>
#include <vector>

#include "core/data/partitioning.h"

namespace gxy::test {

/// Cuts the largest box, again and again, at a random place, until there are `parts`; ranks own boxes at
/// random, so some may own none.
inline Partitioning randomPartitioning(std::mt19937& random, const Box& domain, int parts, int ranks) {
  std::vector<Box> boxes{domain};
  const auto volume = [](const Box& b) { return (b.hi.x - b.lo.x) * (b.hi.y - b.lo.y) * (b.hi.z - b.lo.z); };
  while (int(boxes.size()) < parts) {
    const auto largest = std::max_element(boxes.begin(), boxes.end(),
                                          [&](const Box& a, const Box& b) { return volume(a) < volume(b); });
    const int axis = int(random() % 3);
    const double cut = std::uniform_real_distribution<>(0.2, 0.8)(random);
    Box upper = *largest;
    upper.lo[axis] = largest->hi[axis] = upper.lo[axis] + cut * (upper.hi[axis] - upper.lo[axis]);
    boxes.push_back(upper);
  }
  std::vector<int32_t> owners(boxes.size());
  for (int32_t& o : owners) o = int32_t(random() % unsigned(ranks));
  return Partitioning::fromBoxes(boxes, owners);
}

}  // namespace gxy::test

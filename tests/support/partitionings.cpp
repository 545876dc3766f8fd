// SPDX-License-Identifier: Apache-2.0
#include "tests/support/partitionings.h"

#include <algorithm>

#include "core/comm/random.h"

namespace gxy::test {

namespace {

double volumeOf(const Box& b) { return (b.hi.x - b.lo.x) * (b.hi.y - b.lo.y) * (b.hi.z - b.lo.z); }

}  // namespace

Cut whole(const Box& domain) { return {"one partition", 1, Partitioning::single(domain)}; }

Cut lattice(const Box& domain, std::array<int, 3> parts, int ranks) {
  std::array<std::vector<double>, 3> faces;
  std::string name;
  for (int a = 0; a < 3; a++) {
    faces[a] = evenFaces(domain.lo[a], domain.hi[a], parts[a], 0);
    name += (a ? "x" : "") + std::to_string(parts[a]);
  }
  return {name + " on " + std::to_string(ranks) + " ranks", ranks, Partitioning::lattice(faces, ranks)};
}

Cut kdCut(const Box& domain, int parts, int ranks, uint64_t seed) {
  Random random(seed);
  std::vector<Box> boxes{domain};
  while (int(boxes.size()) < parts) {
    auto largest = std::max_element(boxes.begin(), boxes.end(),
                                    [](const Box& a, const Box& b) { return volumeOf(a) < volumeOf(b); });
    const int axis = int(random.below(3));
    Box upper = *largest;
    const double place = 0.2 + 0.6 * double(random.below(1000)) / 1000;
    upper.lo[axis] = largest->hi[axis] = upper.lo[axis] + place * (upper.hi[axis] - upper.lo[axis]);
    boxes.push_back(upper);
  }
  std::vector<int32_t> owners;
  for (size_t p = 0; p < boxes.size(); p++) owners.push_back(int32_t(random.below(uint64_t(ranks))));
  return {"k-d " + std::to_string(parts) + " seed " + std::to_string(seed) + " on " + std::to_string(ranks) +
              " ranks",
          ranks, Partitioning::fromBoxes(boxes, owners)};
}

Cut octants(const Box& domain, glm::dvec3 corner, int ranks) {
  std::array<std::vector<double>, 3> faces;
  for (int a = 0; a < 3; a++) faces[a] = {domain.lo[a], corner[a], domain.hi[a]};
  std::vector<int32_t> cells, owners;
  for (int p = 0; p < 8; p++) {
    cells.push_back(p);
    owners.push_back(p % ranks);
  }
  return {"octants at " + std::to_string(corner.x) + ", " + std::to_string(corner.y) + ", " +
              std::to_string(corner.z) + " on " + std::to_string(ranks) + " ranks",
          ranks, Partitioning(faces, cells, owners)};
}

std::vector<Cut> manyCuts(const Box& domain, uint64_t seed) {
  std::vector<Cut> cuts;
  cuts.push_back(lattice(domain, {2, 1, 1}, 2));
  cuts.push_back(lattice(domain, {1, 3, 1}, 3));
  cuts.push_back(lattice(domain, {2, 2, 2}, 1));
  cuts.push_back(lattice(domain, {2, 2, 2}, 8));
  cuts.push_back(lattice(domain, {3, 3, 3}, 4));
  cuts.push_back(lattice(domain, {1, 1, 2}, 4));  // Two ranks own nothing.
  for (uint64_t i = 0; i < 4; i++) cuts.push_back(kdCut(domain, 5 + 5 * int(i), 1 + 2 * int(i), seed + i));
  return cuts;
}

}  // namespace gxy::test

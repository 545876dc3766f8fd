// SPDX-License-Identifier: Apache-2.0
// Ways to cut a domain, for tests that ask whether the cut shows.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "core/data/partitioning.h"

namespace gxy::test {

/// A partitioning for some number of ranks, with a name for messages.
struct Cut {
  std::string name;
  int ranks = 1;
  Partitioning partitioning;
};

/// The domain in one piece, on one rank.
Cut whole(const Box& domain);

/// i x j x k boxes of equal size, dealt out in runs.
Cut lattice(const Box& domain, std::array<int, 3> parts, int ranks);

/// Boxes from cutting the largest one at a seeded place, again and again; seeded owners, so ranks may own none.
Cut kdCut(const Box& domain, int parts, int ranks, uint64_t seed);

/// Eight boxes that meet at `corner`, dealt out in turn.
Cut octants(const Box& domain, glm::dvec3 corner, int ranks);

/// The list that invariance tests go through: 2 to 27 partitions, 1 to 8 ranks, ranks that own nothing.
std::vector<Cut> manyCuts(const Box& domain, uint64_t seed);

}  // namespace gxy::test

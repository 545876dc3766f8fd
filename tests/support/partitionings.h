// SPDX-License-Identifier: Apache-2.0
// Ways to cut a domain, for tests that check that pictures do not depend on the cut.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "core/data/partitioning.h"

namespace gxy::test {

/// A partitioning for a number of ranks, with a name for messages.
struct Cut {
  std::string name;
  int ranks = 1;
  Partitioning partitioning;
};

/// The domain in one piece, on one rank.
Cut whole(const Box& domain);

/// i x j x k boxes of equal size. Each rank owns consecutive ones.
Cut lattice(const Box& domain, std::array<int, 3> parts, int ranks);

/// Boxes made by repeatedly cutting the largest one at a seeded place. Owners are seeded too, so ranks may
/// own none.
Cut kdCut(const Box& domain, int parts, int ranks, uint64_t seed);

/// Eight boxes that meet at `corner`, owned by ranks in turn.
Cut octants(const Box& domain, glm::dvec3 corner, int ranks);

/// The cuts of invariance tests: 2 to 27 partitions, 1 to 8 ranks, and some ranks that own nothing.
std::vector<Cut> manyCuts(const Box& domain, uint64_t seed);

}  // namespace gxy::test

// SPDX-License-Identifier: Apache-2.0
// What killed_simulation publishes.
#pragma once
#include "tests/insitu/mini_simulation.h"
#include "tests/insitu/random_blocks.h"

namespace gxy::test {

inline Grid killedGrid() {
  Grid grid;
  grid.points = {20, 18, 16};
  grid.origin = {-1, 0.25, 2};
  grid.spacing = {0.125, 0.25, 0.5};
  return grid;
}

inline std::vector<MiniField> killedFields() {
  return {{"a", ScalarType::Float32, 1}, {"b", ScalarType::Int16, 3}};
}

inline std::vector<insitu::Block> killedBlocks(uint64_t seed, int ranks) {
  Random random(seed);
  return insitu::randomBlocks(random, killedGrid().points, ranks);
}

}  // namespace gxy::test

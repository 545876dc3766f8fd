// SPDX-License-Identifier: Apache-2.0
// Runs of a test that has several parameters, such that each two values of two parameters occur together in some run.
#pragma once
#include <cstdint>
#include <iterator>
#include <set>
#include <tuple>
#include <vector>

#include "core/comm/random.h"

namespace gxy::test {

/// Returns runs: a value, from 0 up, for each of two or more parameters. `values`: by parameter, how many it has. The same for the same seed. Each run
/// is the best of 30 that are drawn: the one with most pairs that have not occurred.
inline std::vector<std::vector<int>> pairwise(const std::vector<int>& values, uint64_t seed) {
  using Pair = std::tuple<size_t, int, size_t, int>;  // parameter and value, twice
  Random random(seed);
  std::set<Pair> left;
  for (size_t a = 0; a < values.size(); a++)
    for (size_t b = a + 1; b < values.size(); b++)
      for (int i = 0; i < values[a]; i++)
        for (int j = 0; j < values[b]; j++) left.emplace(a, i, b, j);
  const auto pairsOf = [](const std::vector<int>& run) {
    std::vector<Pair> pairs;
    for (size_t a = 0; a < run.size(); a++)
      for (size_t b = a + 1; b < run.size(); b++) pairs.emplace_back(a, run[a], b, run[b]);
    return pairs;
  };
  std::vector<std::vector<int>> runs;
  while (!left.empty()) {
    std::vector<int> best;
    size_t most = 0;
    for (int n = 0; n < 30; n++) {
      std::vector<int> run;
      for (const int v : values) run.push_back(int(random.below(uint64_t(v))));
      auto pair = left.begin();
      std::advance(pair, random.below(left.size()));
      const auto& [a, i, b, j] = *pair;
      run[a] = i, run[b] = j;
      size_t fresh = 0;
      for (const Pair& p : pairsOf(run)) fresh += left.count(p);
      if (fresh > most) most = fresh, best = run;
    }
    for (const Pair& p : pairsOf(best)) left.erase(p);
    runs.push_back(best);
  }
  return runs;
}

}  // namespace gxy::test

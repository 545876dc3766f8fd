// SPDX-License-Identifier: Apache-2.0
// Runs a filter on ranks that are threads, over volumes in memory.
#pragma once
#include <gtest/gtest.h>

#include <map>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "core/analysis/filter.h"
#include "tests/support/data_sets.h"
#include "tests/support/partitionings.h"
#include "tests/support/thread_ranks.h"

namespace gxy::test {

inline FilterServices freeServices() {
  FilterServices s;
  s.takeMemory = [](const std::string&, int64_t) { return LedgerEntry(); };
  return s;
}

/// A small grid whose spacing differs by axis.
inline Grid oddGrid(Index3 points) {
  Grid grid;
  grid.points = points;
  grid.origin = {-1, 2, 0.5};
  grid.spacing = {0.5, 0.25, 1};
  return grid;
}

/// A function that is linear in each coordinate.
inline double trilinear(glm::dvec3 p) { return 1 + 2 * p.x - p.y + 0.5 * p.z + p.x * p.y * p.z; }

/// The part of one rank of a dataset with one volume.
inline std::shared_ptr<Dataset> datasetOf(const WholeVolume& whole, const Cut& cut, int rank) {
  const auto made = std::make_shared<Dataset>();
  made->partitioning = std::make_shared<const Partitioning>(cut.partitioning);
  made->volume = test::cut(whole, cut.partitioning, cut.ranks)[size_t(rank)];
  return made;
}

/// A point that a filter has made.
struct MadePoint {
  glm::dvec3 point;
  float value = 0;
  bool operator==(const MadePoint& o) const {
    return point == o.point && (value == o.value || (value != value && o.value != o.value));
  }
};

/// What a filter has made on all ranks.
struct MadePoints {
  std::map<uint64_t, MadePoint> points;           ///< by id
  std::map<uint64_t, std::vector<float>> fields;  ///< all components of all further fields
  nlohmann::json told;                            ///< on rank 0
  std::string error;                              ///< of rank 0; the others had one if this is not empty
};

/// Runs `filter` on all ranks of `cut`. `inputsOf` returns the inputs on a rank.
template <class T, class InputsOf>
MadePoints made(const Cut& cut, const InputsOf& inputsOf, const std::string& properties) {
  MadePoints all;
  std::mutex mutex;
  ThreadRanks world(cut.ranks);
  const std::vector<std::string> errors = world.run([&](Collectives& ranks) {
    FilterRun run(ranks, inputsOf(ranks), freeServices());
    const FilterResult result = evaluate(*makeFilter<T>(), run, properties);
    const GeometryBlock& block = result.dataset->geometry->block;
    const std::lock_guard lock(mutex);
    for (size_t i = 0; i < block.ids.size(); i++)
      EXPECT_TRUE(
          all.points
              .emplace(block.ids[i], MadePoint{block.points[i], block.values.empty() ? 0 : block.values[i]})
              .second);
    for (size_t i = 0; i < block.ids.size() && !block.fields.empty(); i++)
      for (const PointField& f : block.fields)
        for (int c = 0; c < f.components; c++) all.fields[block.ids[i]].push_back(fieldValue(f, c, i));
    if (ranks.rank() == 0) all.told = result.told;
  });
  all.error = errors[0];
  for (const std::string& error : errors) EXPECT_EQ(error.empty(), all.error.empty()) << error;
  return all;
}

}  // namespace gxy::test

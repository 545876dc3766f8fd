// SPDX-License-Identifier: Apache-2.0
// Fields on ranks that are threads of the test, and what is derived of them, put together.
#pragma once
#include <cmath>
#include <cstring>
#include <functional>
#include <glm/vec3.hpp>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/analysis/evaluate.h"
#include "core/comm/error.h"
#include "core/data/bricks.h"
#include "core/data/complete_volume.h"
#include "tests/support/thread_ranks.h"

namespace gxy::test {

/// A field of a test. `value` gives a component at a point, by its index and world coordinates.
struct FieldSpec {
  std::string name;
  int components = 1;
  std::function<double(int component, const Index3& point, glm::dvec3 world)> value;
  ScalarType type = ScalarType::Float32;
};

template <class Use>
void forPoints(const Extent& extent, Use use) {
  for (int64_t z = 0; z < extent.points[2]; ++z)
    for (int64_t y = 0; y < extent.points[1]; ++y)
      for (int64_t x = 0; x < extent.points[0]; ++x)
        use(Index3{extent.first[0] + x, extent.first[1] + y, extent.first[2] + z});
}

/// The point whose data a point has: itself, or in a rim its neighbour.
inline Index3 inside(const Grid& grid, Index3 p) {
  if (grid.rim)
    for (size_t a = 0; a < 3; ++a) p[a] = std::clamp<int64_t>(p[a], 1, grid.points[a] - 2);
  return p;
}

inline glm::dvec3 worldOf(const Grid& grid, const Index3& p) {
  return grid.origin + grid.spacing * glm::dvec3(double(p[0]), double(p[1]), double(p[2]));
}

/// Collective. Makes a complete volume.
inline std::shared_ptr<const Volume> volumeOf(const FieldSpec& spec, const Grid& grid,
                                              const Partitioning& cut, Collectives& ranks) {
  auto volume = std::make_shared<Volume>();
  volume->name = spec.name;
  volume->grid = grid;
  volume->stored = spec.type;
  volume->components = spec.components;
  for (const int partition : cut.owned(ranks.rank())) {
    const Extent extent = extentOf(grid, cut.box(partition), kGhostLayers);
    if (extent.count() == 0) continue;
    VolumeBlock& block = volume->blocks[partition];
    block.extent = extent;
    block.samples.resize(size_t(extent.count()) * size_t(spec.components) * bytesOf(spec.type));
    std::byte* to = block.samples.data();
    forPoints(extent, [&](const Index3& point) {
      const Index3 from = inside(grid, point);
      for (int c = 0; c < spec.components; ++c)
        withType(spec.type, [&](auto t) {
          t = decltype(t)(spec.value(c, from, worldOf(grid, from)));
          std::memcpy(to, &t, sizeof t);
          to += sizeof t;
        });
    });
  }
  completeVolume(*volume, cut, ranks);
  return volume;
}

inline std::vector<FieldInput> inputsOf(std::span<const FieldSpec> specs, const Grid& grid,
                                        const Partitioning& cut, Collectives& ranks) {
  std::vector<FieldInput> inputs;
  const auto shared = std::make_shared<const Partitioning>(cut);
  for (const FieldSpec& spec : specs) inputs.push_back({spec.name, volumeOf(spec, grid, cut, ranks), shared});
  return inputs;
}

/// A derived field, put together of all ranks.
struct WholeField {
  std::vector<float> values;  ///< x fastest; the components of a point stand together
  int components = 0;
  int64_t noData = 0;
  std::vector<Range> ranges;
  int64_t noDataSamples = 0;
  ScalarType stored = ScalarType::Float32;
  std::vector<std::string> errors;  ///< by rank, empty where there was none
  int64_t wrongGhosts = 0;          ///< samples of blocks that are not those of their owners
  double shift = 0, scale = 1;
  Grid grid;

  double at(const Index3& p, int c = 0) const {
    return shift +
           scale *
               double(
                   values[size_t(((p[2] * grid.points[1] + p[1]) * grid.points[0] + p[0]) * components + c)]);
  }
};

inline float sampleAt(const VolumeBlock& block, ScalarType stored, size_t i) {
  return withType(stored, [&](auto t) {
    std::memcpy(&t, block.samples.data() + i * sizeof t, sizeof t);
    return float(t);
  });
}

/// Derives a field on as many ranks. Every NaN has the same bits, or counts as wrong ghosts.
inline WholeField derived(const std::string& text, std::span<const FieldSpec> specs, const Grid& grid,
                          const Partitioning& cut, int ranks, DeriveOptions options = {}) {
  WholeField whole;
  whole.grid = grid;
  std::vector<std::shared_ptr<Volume>> made(static_cast<size_t>(ranks));
  ThreadRanks threads(ranks);
  whole.errors = threads.run([&](Collectives& all) {
    const auto inputs = inputsOf(specs, grid, cut, all);
    const DerivedField field = derive(Expression(text), inputs, all, options);
    made[size_t(all.rank())] = field.volume;
    if (all.rank() > 0) return;
    whole.components = field.volume->components;
    whole.noData = field.noData;
    whole.ranges = field.volume->ranges;
    whole.noDataSamples = field.volume->noDataSamples;
    whole.stored = field.volume->stored;
    whole.shift = field.volume->shift;
    whole.scale = field.volume->scale;
  });
  for (const std::string& error : whole.errors)
    if (!error.empty()) return whole;
  const auto n = size_t(whole.components);
  whole.values.assign(size_t(grid.points[0] * grid.points[1] * grid.points[2]) * n, -12345);
  const auto placeOf = [&](const Index3& p) {
    return size_t((p[2] * grid.points[1] + p[1]) * grid.points[0] + p[0]) * n;
  };
  const auto forBlocks = [&](auto use) {
    for (const auto& volume : made)
      for (const auto& entry : volume->blocks)
        use(entry.first, entry.second, Bricks(entry.second.extent.points));
  };
  const auto local = [](const VolumeBlock& block, const Bricks& bricks, const Index3& p) {
    return bricks(p[0] - block.extent.first[0], p[1] - block.extent.first[1], p[2] - block.extent.first[2]);
  };
  forBlocks([&](int partition, const VolumeBlock& block, const Bricks& bricks) {
    forPoints(ownedPoints(grid, cut, partition), [&](const Index3& p) {
      for (size_t c = 0; c < n; ++c)
        whole.values[placeOf(p) + c] = sampleAt(block, whole.stored, local(block, bricks, p) * n + c);
    });
  });
  forBlocks([&](int, const VolumeBlock& block, const Bricks& bricks) {
    forPoints(block.extent, [&](const Index3& p) {
      for (size_t c = 0; c < n; ++c) {
        const float found = sampleAt(block, whole.stored, local(block, bricks, p) * n + c);
        whole.wrongGhosts += std::memcmp(&found, &whole.values[placeOf(p) + c], sizeof found) != 0;
      }
    });
  });
  return whole;
}

/// The same on one rank, in one partition.
inline WholeField derived(const std::string& text, std::span<const FieldSpec> specs, const Grid& grid,
                          DeriveOptions options = {}) {
  return derived(text, specs, grid, Partitioning::single(grid.box()), 1, options);
}

}  // namespace gxy::test

// SPDX-License-Identifier: Apache-2.0
// Makes a volume from another one, point by point.
#pragma once
#include <cstring>
#include <memory>
#include <string>
#include <type_traits>

#include "core/analysis/filter.h"
#include "core/comm/error.h"
#include "core/data/bricks.h"
#include "core/data/complete_volume.h"

namespace gxy {

/// Collective. Returns a dataset whose value at each point of the source's grid is f(value of the source): bytes if f
/// returns bool, else floats. The source has one component; otherwise all ranks throw Error. `f` must depend on its argument only.
template <class F>
FilterResult pointwise(FilterRun& run, const FilterSource& source, const std::string& name, F f) {
  using Made = std::conditional_t<std::is_same_v<decltype(f(0.0)), bool>, uint8_t, float>;
  const Dataset& from = *source.data;
  const auto volume = std::make_shared<Volume>();
  LedgerEntry memory;
  run.begin(0, 2, name);
  agree(run.ranks, [&] {
    if (from.volume->components != 1)
      throw Error(name + ": expected one component, found " + std::to_string(from.volume->components) +
                  " of " + inQuotes(source.name));
    volume->name = name;
    volume->grid = from.volume->grid;
    volume->stored = std::is_same_v<Made, uint8_t> ? ScalarType::UInt8 : ScalarType::Float32;
    int64_t bytes = 0, all = 0, done = 0;
    for (const auto& [partition, block] : from.volume->blocks) {
      bytes += int64_t(Bricks(block.extent.points).count() * sizeof(Made));
      all += block.extent.count();
    }
    memory = run.takeMemory("volume", bytes);
    for (const auto& [partition, one] : from.volume->blocks) {
      const VolumeBlock& block = one;
      VolumeBlock& made = volume->blocks[partition];
      made.extent = block.extent;
      made.samples.resize(size_t(block.extent.count()) * sizeof(Made));
      std::byte* to = made.samples.data();
      const Index3& n = block.extent.points;
      const Bricks bricks(n);  // Points of a complete block lie in bricks. Those of a new one come x fastest.
      withType(from.volume->stored, [&](auto stored) {
        for (int64_t z = 0; z < n[2]; z++) {
          run.ranks.check();
          run.ranks.done(double(done) / double(all));
          done += n[0] * n[1];
          for (int64_t y = 0; y < n[1]; y++)
            for (int64_t x = 0; x < n[0]; x++, to += sizeof(Made)) {
              std::memcpy(&stored, &block.samples[bricks(x, y, z) * sizeof stored], sizeof stored);
              const Made value = Made(f(from.volume->shift + from.volume->scale * double(stored)));
              std::memcpy(to, &value, sizeof value);
            }
        }
      });
    }
  });
  run.begin(1, 2, "summaries");
  completeVolume(*volume, *from.partitioning, run.ranks);
  return {run.made(volume, from.partitioning, std::move(memory)), {}};
}

}  // namespace gxy

// SPDX-License-Identifier: Apache-2.0
#include "core/data/complete_volume.h"

#include <cstring>
#include <span>
#include <utility>
#include <vector>

#include "core/data/extent_pieces.h"
#include "core/data/macrocells.h"
#include "core/data/merge_ranges.h"

namespace gxy {
namespace {

void mergeMacrocells(Volume& volume, Collectives& ranks) {
  const std::vector<BorderSummary> mine = borderSummaries(volume);
  Bytes bytes(mine.size() * sizeof(BorderSummary));
  if (!bytes.empty()) std::memcpy(bytes.data(), mine.data(), bytes.size());
  for (const Bytes& theirs : ranks.allGather(std::move(bytes))) {
    std::vector<BorderSummary> records(theirs.size() / sizeof(BorderSummary));
    if (!records.empty()) std::memcpy(records.data(), theirs.data(), records.size() * sizeof(BorderSummary));
    mergeSummaries(volume, records);
  }
}

/// Statistics of the points of `part`, in pieces between which the computation may be ended.
FieldStatistics statisticsOf(const VolumeBlock& block, ScalarType type, int components, const Extent& part,
                             const Collectives& ranks) {
  constexpr int64_t kPoints = 1 << 22;
  FieldStatistics statistics;
  forPieces(part, kPoints, [&](const Extent& piece) {
    ranks.check();
    statistics.merge(statisticsOf(block.samples, type, components, block.extent, piece));
  });
  return statistics;
}

/// Stores the samples of all blocks as encodingOf() says of a field with `fieldComponents` and stored values in `ranges`,
/// which are those of all ranks, and puts them into bricks.
void storeSamples(Volume& volume, int fieldComponents, const std::vector<Range>& ranges, Collectives& ranks,
                  const std::function<void(int64_t)>& stored) {
  Range values;
  for (int c = 0; c < volume.components; ++c) values.extend(ranges[size_t(c)]);
  const ScalarType type = volume.stored;
  const Encoding encoding = encodingOf(type, fieldComponents, values);
  volume.stored = encoding.stored;
  volume.shift += volume.scale * encoding.shift;
  volume.scale *= encoding.scale;
  agree(ranks, [&] {
    for (auto& [partition, block] : volume.blocks) {
      ranks.check();
      if (encoding != Encoding{type})
        block.samples = convert(block.samples, type, encoding, [&](double) { ranks.check(); });
      const int64_t points = block.extent.count();
      int64_t told = 0;
      const auto tellTo = [&](int64_t point) {
        const int64_t more = point - std::exchange(told, point);
        if (stored) stored(more);
      };
      completeBlock(block, encoding.stored, volume.components, [&](double fraction) {
        ranks.check();
        tellTo(int64_t(fraction * double(points)));
      });
      tellTo(points);
    }
  });
}

}  // namespace

void completeVolume(Volume& volume, const Partitioning& partitioning, Collectives& ranks) {
  completeVolume(volume, partitioning, ranks, volume.components, {});
}

void completeVolume(Volume& volume, const Partitioning& partitioning, Collectives& ranks, int fieldComponents,
                    const std::function<void(int64_t)>& stored) {
  FieldStatistics statistics;
  statistics.ranges.resize(size_t(volume.components) + (volume.components > 1));
  agree(ranks, [&] {
    for (const auto& [partition, block] : volume.blocks)
      statistics.merge(statisticsOf(block, volume.stored, volume.components,
                                    ownedPoints(volume.grid, partitioning, partition), ranks));
  });
  mergeRanges(ranks, statistics.ranges);
  volume.ranges = statistics.ranges;
  for (Range& range : volume.ranges)
    if (!range.empty())
      range = {volume.shift + volume.scale * range.min, volume.shift + volume.scale * range.max};
  volume.noDataSamples = int64_t(sumOfCounts(ranks, uint64_t(statistics.noDataSamples)));
  storeSamples(volume, fieldComponents, statistics.ranges, ranks, stored);
  mergeMacrocells(volume, ranks);
}

}  // namespace gxy

// SPDX-License-Identifier: Apache-2.0
#include "core/data/complete_volume.h"

#include <algorithm>
#include <cstring>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/comm/error.h"
#include "core/data/bricks.h"
#include "core/data/extent_pieces.h"
#include "core/data/macrocells.h"
#include "core/data/merge_ranges.h"

namespace gxy {
namespace {

/// The macrocells of a partition of another rank.
struct MacrocellsElsewhere {
  int rank;
  MacrocellBox box;
};

/// Those of partitions that have macrocells in common with this rank's blocks.
std::vector<MacrocellsElsewhere> macrocellsAround(const Volume& volume, const Partitioning& partitioning,
                                                  int rank) {
  std::vector<MacrocellsElsewhere> around;
  for (int p = 0; p < partitioning.partitions(); ++p) {
    if (partitioning.owner(p) == rank) continue;
    const MacrocellBox box = macrocellsOf(extentOf(volume.grid, partitioning.box(p), kGhostLayers));
    const bool meets = std::any_of(volume.blocks.begin(), volume.blocks.end(), [&](const auto& entry) {
      return box.meets({entry.second.firstMacrocell, entry.second.macrocells});
    });
    if (meets) around.push_back({partitioning.owner(p), box});
  }
  return around;
}

void mergeMacrocells(Volume& volume, const Partitioning& partitioning, Collectives& ranks) {
  const std::vector<BorderSummary> mine = borderSummaries(volume);
  const std::vector<MacrocellsElsewhere> around = macrocellsAround(volume, partitioning, ranks.rank());
  std::vector<Bytes> messages(size_t(ranks.size()));
  std::vector<const BorderSummary*> last(messages.size());  // in each message
  for (const BorderSummary& record : mine)
    for (const MacrocellsElsewhere& there : around) {
      const auto rank = size_t(there.rank);
      if (last[rank] == &record || !there.box.contains(record.macrocell)) continue;
      last[rank] = &record;
      const auto* bytes = reinterpret_cast<const std::byte*>(&record);
      messages[rank].insert(messages[rank].end(), bytes, bytes + sizeof record);
    }
  mergeSummaries(volume, mine);
  for (const Bytes& theirs : ranks.allToAll(std::move(messages))) {
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

/// Throws Error unless the block has as many samples as points, and was not completed.
void checkRows(const Volume& volume, const VolumeBlock& block) {
  const size_t points = size_t(block.extent.count()) * size_t(volume.components) * bytesOf(volume.stored);
  if (block.samples.size() != points || !block.summaries.empty())
    throw Error("volume " + volume.name + ": a block of " + std::to_string(block.samples.size()) + " bytes" +
                (block.summaries.empty() ? "" : " that is complete already") + ", expected " +
                std::to_string(points) + " bytes of samples, x fastest");
}

/// Throws Error unless there are statistics of this rank's points, if it has any.
void checkStatistics(const Volume& volume, const Partitioning& partitioning, const FieldStatistics& mine) {
  int64_t points = 0;
  for (const auto& [partition, block] : volume.blocks)
    points += ownedPoints(volume.grid, partitioning, partition).count();
  const size_t ranges = size_t(volume.components) + (volume.components > 1);
  if (points > 0 && mine.ranges.size() != ranges)
    throw Error("volume " + volume.name + ": statistics with " + std::to_string(mine.ranges.size()) +
                " ranges, expected " + std::to_string(ranges));
}

/// Changes the samples of all blocks from their type to the encoding.
void encode(Volume& volume, const Encoding& encoding, Collectives& ranks) {
  if (encoding == Encoding{volume.stored}) return;
  agree(ranks, [&] {
    for (auto& [partition, block] : volume.blocks) {
      block.samples = convert(block.samples, volume.stored, encoding, [&](double) { ranks.check(); });
      clearPadding(block.samples, block.extent.points, bytesOf(encoding.stored) * size_t(volume.components));
    }
  });
  volume.stored = encoding.stored;
  volume.shift += volume.scale * encoding.shift;
  volume.scale *= encoding.scale;
}

void summarize(Volume& volume, Collectives& ranks, const std::function<void(int64_t)>& stored) {
  agree(ranks, [&] {
    for (auto& [partition, block] : volume.blocks) {
      const int64_t points = block.extent.count();
      int64_t told = 0;
      const auto tellTo = [&](int64_t point) {
        const int64_t more = point - std::exchange(told, point);
        if (stored) stored(more);
      };
      summarizeBlock(block, volume.stored, volume.components, [&](double fraction) {
        ranks.check();
        tellTo(int64_t(fraction * double(points)));
      });
      tellTo(points);
    }
  });
}

/// Statistics of the scalars of this rank's blocks, from their summaries. The summaries of all ranks together are those of the
/// whole field, as the points that several blocks have in common are the same.
FieldStatistics statisticsOfSummaries(const Volume& volume) {
  FieldStatistics statistics;
  statistics.ranges.resize(1);
  for (const auto& [partition, block] : volume.blocks)
    for (const Macrocell& m : block.summaries[0]) {
      if (m.min <= m.max) statistics.ranges[0].extend({double(m.min), double(m.max)});
      statistics.noDataSamples += m.noData;
    }
  return statistics;
}

/// Statistics of the points that the partitions of this rank own.
FieldStatistics statisticsOfOwned(const Volume& volume, const Partitioning& partitioning,
                                  const Collectives& ranks) {
  const int64_t most = (int64_t(1) << 20) / volume.components;
  FieldStatistics statistics;
  Samples samples;
  const size_t bytes = bytesOf(volume.stored) * size_t(volume.components);
  for (const auto& entry : volume.blocks) {
    const VolumeBlock& block = entry.second;
    forPieces(ownedPoints(volume.grid, partitioning, entry.first), most, [&](const Extent& piece) {
      ranks.check();
      samples.resize(size_t(piece.count()) * bytes);
      copyFromBricks(block.samples, block.extent, piece, samples, bytes);
      statistics.merge(statisticsOf(samples, volume.stored, volume.components));
    });
  }
  return statistics;
}

}  // namespace

void completeVolume(Volume& volume, const Partitioning& partitioning, Collectives& ranks) {
  completeVolume(volume, partitioning, ranks, volume.components, {});
}

void completeVolume(Volume& volume, const Partitioning& partitioning, Collectives& ranks, int fieldComponents,
                    const std::function<void(int64_t)>& stored, const std::optional<StoredLike>& like) {
  FieldStatistics mine;
  agree(ranks, [&] {
    for (auto& [partition, block] : volume.blocks) {
      checkRows(volume, block);
      if (needsStatistics(volume, partitioning))
        mine.merge(statisticsOf(block, volume.stored, volume.components,
                                ownedPoints(volume.grid, partitioning, partition), ranks));
      putIntoBricks(block.samples, block.extent.points, bytesOf(volume.stored) * size_t(volume.components),
                    [&] { ranks.check(); });
    }
  });
  completeBricks(volume, partitioning, ranks, std::move(mine), fieldComponents, stored, like);
}

bool needsStatistics(const Volume& volume, const Partitioning& partitioning) {
  const Box& domain = partitioning.domain();
  const Box grid = volume.grid.box();
  bool covers = true;  // and blocks have no points outside the domain
  for (int a = 0; a < 3; ++a) covers = covers && domain.lo[a] <= grid.lo[a] && grid.hi[a] <= domain.hi[a];
  return isWide(volume.stored) || volume.components > 1 || !covers;
}

void completeBricks(Volume& volume, const Partitioning& partitioning, Collectives& ranks,
                    FieldStatistics mine, int fieldComponents, const std::function<void(int64_t)>& stored,
                    const std::optional<StoredLike>& like) {
  double shift = volume.shift, scale = volume.scale;  // of the samples that the ranges are of
  const auto mergeStatistics = [&] {
    mine.ranges.resize(size_t(volume.components) + (volume.components > 1));
    mergeRanges(ranks, mine.ranges);
  };
  bool known = needsStatistics(volume, partitioning);
  if (known) {
    agree(ranks, [&] { checkStatistics(volume, partitioning, mine); });
    mergeStatistics();
    Range values;
    for (int c = 0; c < volume.components; ++c) values.extend(mine.ranges[size_t(c)]);
    const bool isLike = like && suffices(like->encoding, volume.stored, fieldComponents, values);
    encode(volume, isLike ? like->encoding : encodingOf(volume.stored, fieldComponents, values), ranks);
    if (isLike && like->rangesOfStored) {
      volume.rangesOfStored = true;
      shift = volume.shift, scale = volume.scale;
      known = needsStatistics(volume, partitioning);
      if (known) agree(ranks, [&] { mine = statisticsOfOwned(volume, partitioning, ranks); });
      if (known) mergeStatistics();
    }
  }
  summarize(volume, ranks, stored);
  if (!known) {
    mine = statisticsOfSummaries(volume);
    mergeStatistics();
  }
  mine.noDataSamples = int64_t(sumOfCounts(ranks, uint64_t(mine.noDataSamples)));
  if (!known && mine.noDataSamples > 0) {
    // Summaries say only that there are such points. Most fields have none, so nothing is counted in most.
    agree(ranks, [&] { mine.noDataSamples = statisticsOfOwned(volume, partitioning, ranks).noDataSamples; });
    mine.noDataSamples = int64_t(sumOfCounts(ranks, uint64_t(mine.noDataSamples)));
  }
  if (!known) {
    const Encoding encoding = encodingOf(volume.stored, fieldComponents, mine.ranges[0]);
    if (encoding != Encoding{volume.stored}) {  // Few floats are so large or so small that they are scaled.
      encode(volume, encoding, ranks);
      for (auto& [partition, block] : volume.blocks) block.summaries.clear();
      summarize(volume, ranks, {});
    }
  }
  volume.ranges = mine.ranges;
  for (Range& range : volume.ranges)
    if (!range.empty()) range = {shift + scale * range.min, shift + scale * range.max};
  volume.noDataSamples = mine.noDataSamples;
  mergeMacrocells(volume, partitioning, ranks);
}

}  // namespace gxy

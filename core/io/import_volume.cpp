// SPDX-License-Identifier: Apache-2.0
#include "core/io/import_volume.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <utility>

#include "core/comm/error.h"
#include "core/data/bricks.h"
#include "core/data/macrocells.h"
#include "core/data/merge_ranges.h"
#include "core/io/volume_formats.h"

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

/// Stores the samples of all blocks as values of `type` in `ranges`, those of all ranks, want it, and completes the blocks.
/// `components` are those of the array that the volume's are of.
void storeSamples(
    Volume& volume, ScalarType type, int components, const std::vector<Range>& ranges, Collectives& ranks,
    const std::function<void(int64_t)>& count = [](int64_t) {}) {
  Range values;
  for (int c = 0; c < volume.components; ++c) values.extend(ranges[size_t(c)]);
  const Encoding encoding = encodingOf(type, components, values);
  volume.stored = encoding.stored;
  volume.shift += volume.scale * encoding.shift;
  volume.scale *= encoding.scale;
  agree(ranks, [&] {
    for (auto& [partition, block] : volume.blocks) {
      ranks.check();
      if (encoding != Encoding{type})
        block.samples = convert(block.samples, type, encoding, [&](double) { ranks.check(); });
      const int64_t points = block.extent.count();
      int64_t counted = 0;
      const auto countTo = [&](int64_t point) { count(point - std::exchange(counted, point)); };
      completeBlock(block, encoding.stored, volume.components, [&](double share) {
        ranks.check();
        countTo(int64_t(share * double(points)));
      });
      countTo(points);
    }
  });
  mergeMacrocells(volume, ranks);
}

/// As the call of the same name, in pieces between which it may end.
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

/// What a rank with these blocks has not kept of a file whose array has `components`.
LeftOut leftOutOf(const VolumeFile& file, int components, const Volume& volume) {
  LeftOut out{file.arrays.size() - 1, uint64_t(components - volume.components), file.source->piecesNotRead(),
              0};
  const auto points = uint64_t(wholeOf(file.grid).count());
  for (const ArrayInfo& a : file.arrays) out.bytes += points * bytesOf(a.type) * uint64_t(a.components);
  uint64_t read = 0;
  for (const auto& [partition, block] : volume.blocks) read += block.samples.size();
  out.bytes -= std::min(read, out.bytes);  // ghost layers are read more than once
  return out;
}

}  // namespace

Grid gridOf(const std::string& path, const std::string& array, Collectives& ranks,
            std::vector<std::string>* warnings) {
  Grid grid;
  agree(ranks, [&] {
    if (ranks.rank() != 0) return;
    const VolumeFile file = openVolume(path, array);
    grid = file.grid;
    for (const std::string& warning : file.warnings) {
      if (warnings)
        warnings->push_back(warning);
      else
        spdlog::warn("{}", warning);
    }
  });
  Bytes bytes(ranks.rank() == 0 ? sizeof(Grid) : 0);
  if (!bytes.empty()) std::memcpy(bytes.data(), &grid, sizeof grid);
  std::memcpy(&grid, ranks.allGather(std::move(bytes))[0].data(), sizeof grid);
  return grid;
}

std::shared_ptr<Volume> importVolume(const std::string& path, const std::string& array,
                                     const Partitioning& partitioning, int ghosts, Collectives& ranks,
                                     std::vector<int> components, LeftOut* leftOut) {
  VolumeFile file;
  agree(ranks, [&] { file = openVolume(path, array); });
  return importVolume(std::move(file), partitioning, ghosts, ranks, std::move(components), leftOut);
}

std::shared_ptr<Volume> importVolume(VolumeFile file, const Partitioning& partitioning, int ghosts,
                                     Collectives& ranks, std::vector<int> components, LeftOut* leftOut) {
  auto volume = std::make_shared<Volume>();
  ScalarType type{};
  int componentsOfFile = 0;
  FieldStatistics statistics;
  int64_t points = 0, done = 0;  // of this rank's; each is read and stored
  const auto count = [&](int64_t more) {
    done += more;
    ranks.done(double(done) / double(2 * points));
  };
  agree(ranks, [&] {
    componentsOfFile = file.array.components;
    if (!components.empty()) file = withComponents(std::move(file), std::move(components));
    type = file.array.type;
    volume->name = std::filesystem::path(file.path).stem().string();
    if (!file.array.name.empty()) volume->name += ":" + file.array.name;
    volume->grid = file.grid;
    volume->components = file.array.components;
    statistics.ranges.resize(size_t(volume->components) + (volume->components > 1));
    for (int partition : partitioning.owned(ranks.rank()))
      points += extentOf(file.grid, partitioning.box(partition), ghosts).count();
    for (int partition : partitioning.owned(ranks.rank())) {
      VolumeBlock block;
      block.extent = extentOf(file.grid, partitioning.box(partition), ghosts);
      if (block.extent.count() == 0) continue;
      block.samples.reserve(Bricks(block.extent.points).count() * file.bytesPerPoint());
      block.samples.resize(size_t(block.extent.count()) * file.bytesPerPoint());
      volume->blocks.emplace(partition, std::move(block));
    }
    std::vector<ReadTarget> targets;
    for (auto& [partition, block] : volume->blocks) targets.push_back({block.extent, block.samples});
    readVolume(file, targets, [&](int64_t some) {
      ranks.check();
      if (some > 0) count(some);
    });
    for (const auto& [partition, block] : volume->blocks)
      statistics.merge(statisticsOf(block, type, volume->components,
                                    ownedPoints(file.grid, partitioning, partition), ranks));
    if (leftOut) *leftOut += leftOutOf(file, componentsOfFile, *volume);
  });

  mergeRanges(ranks, statistics.ranges);
  volume->ranges = statistics.ranges;
  volume->noDataSamples = int64_t(sumOfCounts(ranks, uint64_t(statistics.noDataSamples)));
  storeSamples(*volume, type, componentsOfFile, volume->ranges, ranks, count);
  return volume;
}

void completeVolume(Volume& volume, const Partitioning& partitioning, Collectives& ranks) {
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
  storeSamples(volume, volume.stored, volume.components, statistics.ranges, ranks);
}

}  // namespace gxy

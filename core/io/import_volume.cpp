// SPDX-License-Identifier: Apache-2.0
#include "core/io/import_volume.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <utility>
#include <vector>

#include "core/comm/error.h"
#include "core/data/bricks.h"
#include "core/data/complete_volume.h"
#include "core/io/volume_formats.h"

namespace gxy {
namespace {

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
                                     Collectives& ranks, std::vector<int> components, LeftOut* leftOut,
                                     const std::optional<StoredLike>& like) {
  auto volume = std::make_shared<Volume>();
  int componentsOfFile = 0;
  int64_t points = 0, done = 0;  // of this rank's; each is read and stored
  const auto count = [&](int64_t more) {
    done += more;
    ranks.done(double(done) / double(2 * points));
  };
  agree(ranks, [&] {
    componentsOfFile = file.array.components;
    if (!components.empty()) file = withComponents(std::move(file), std::move(components));
    volume->name = std::filesystem::path(file.path).stem().string();
    if (!file.array.name.empty()) volume->name += ":" + file.array.name;
    volume->grid = file.grid;
    volume->stored = file.array.type;
    volume->components = file.array.components;
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
    if (leftOut) *leftOut += leftOutOf(file, componentsOfFile, *volume);
  });
  completeVolume(*volume, partitioning, ranks, componentsOfFile, count, like);
  return volume;
}

}  // namespace gxy

// SPDX-License-Identifier: Apache-2.0
#include "multiserver/insitu/grid_room.h"

#include <algorithm>
#include <utility>

#include "core/data/bricks.h"
#include "core/data/complete_volume.h"

namespace gxy {

namespace {

// The bytes of this rank's blocks of a field, while they are completed.
int64_t bytesToCome(const insitu::Field& field, const Grid& grid, const Partitioning& partitioning,
                    int rank) {
  size_t points = 0, largest = 0;
  for (const int p : partitioning.owned(rank)) {
    const Extent extent = extentOf(grid, partitioning.box(p), kGhostLayers);
    if (extent.count() == 0) continue;
    const size_t block = Bricks(extent.points).count();
    points += block;
    largest = std::max(largest, block);
  }
  const bool becomesFloat = isWide(field.type);    // block by block
  return int64_t(points * field.bytesPerPoint() +  // The limits of a description keep this below 2^63.
                 (becomesFloat ? largest * sizeof(float) * size_t(field.components) : 0));
}

}  // namespace

GridRoom::GridRoom(const insitu::Mesh& mesh, size_t number, const insitu::Encodings& encodings,
                   const Partitioning& partitioning, const GhostPlan& ghosts, int rank,
                   const TakeStepMemory& take)
    : partitioning_(partitioning), ghosts_(ghosts) {
  std::vector<insitu::Field> fields = mesh.fields;
  for (size_t f = 0; f < fields.size(); f++) {
    if (encodingIn(encodings, number, f)) fields[f].type = ScalarType::Float32;
    memory_.push_back(take("volume", bytesToCome(fields[f], mesh.grid, partitioning, rank)));
  }
  for (size_t f = 0; f < fields.size(); f++) {
    const insitu::Field& field = fields[f];
    auto volume = std::make_shared<Volume>();
    volume->name = field.name;
    volume->grid = mesh.grid;
    volume->stored = field.type;
    volume->components = field.components;
    if (const insitu::FieldEncoding* e = encodingIn(encodings, number, f))
      volume->shift = e->shift, volume->scale = e->scale, volume->rangesOfStored = true;
    for (const int p : partitioning.owned(rank)) {
      const Extent extent = extentOf(mesh.grid, partitioning.box(p), kGhostLayers);
      if (extent.count() == 0) continue;
      VolumeBlock& block = volume->blocks[p];
      block.extent = extent;
      block.samples.resize(Bricks(extent.points).count() * field.bytesPerPoint());
      clearPadding(block.samples, extent.points, field.bytesPerPoint());
    }
    volumes_.push_back(std::move(volume));
  }
  statistics_.resize(volumes_.size());
}

void GridRoom::store(const insitu::Piece& piece, size_t array, const insitu::PieceHeader& header,
                     std::span<const std::byte> samples) {
  if (header.count != std::exchange(count_, header.count))  // what came before is of a step that was given up
    for (FieldStatistics& statistics : statistics_) statistics = {};
  Volume& volume = *volumes_.at(array);
  VolumeBlock& block = volume.blocks.at(piece.partition);
  const size_t bytes = bytesOf(volume.stored) * size_t(volume.components);
  storeInBricks(block.samples, block.extent, piece.points, int64_t(header.offset / bytes), samples, bytes);
  if (needsStatistics(volume, partitioning_))  // The samples are in the processor's cache now.
    statistics_[array].merge(statisticsOf(samples, volume.stored, volume.components));
}

std::vector<std::shared_ptr<Dataset>> GridRoom::complete(Collectives& ranks) {
  std::vector<Volume*> all;
  for (const auto& volume : volumes_) all.push_back(volume.get());
  exchangeGhosts(all, ghosts_, ranks);
  for (size_t i = 0; i < volumes_.size(); i++)
    completeBricks(*volumes_[i], partitioning_, ranks, std::move(statistics_[i]), volumes_[i]->components);
  std::vector<std::shared_ptr<Dataset>> datasets;
  for (size_t i = 0; i < volumes_.size(); i++) {
    datasets.push_back(std::make_shared<Dataset>());
    Dataset& d = *datasets.back();
    d.array = volumes_[i]->name;
    d.bytes = bytesOf(*volumes_[i]);
    d.memory = std::move(memory_[i]);
    d.memory.resize(d.bytes);
    d.volume = std::move(volumes_[i]);
  }
  return datasets;
}

}  // namespace gxy

// SPDX-License-Identifier: Apache-2.0
#include "multiserver/insitu/grid_room.h"

#include <algorithm>
#include <cstring>

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
  const bool becomesFloat = bytesOf(field.type) > sizeof(float);  // block by block
  return int64_t(points * field.bytesPerPoint() +  // The limits of a description keep this below 2^63.
                 (becomesFloat ? largest * sizeof(float) * size_t(field.components) : 0));
}

}  // namespace

GridRoom::GridRoom(const insitu::Mesh& mesh, const Partitioning& partitioning, const GhostPlan& ghosts,
                   int rank, const TakeStepMemory& take)
    : partitioning_(partitioning), ghosts_(ghosts) {
  for (const insitu::Field& field : mesh.fields)
    memory_.push_back(take("volume", bytesToCome(field, mesh.grid, partitioning, rank)));
  for (const insitu::Field& field : mesh.fields) {
    auto volume = std::make_shared<Volume>();
    volume->name = field.name;
    volume->grid = mesh.grid;
    volume->stored = field.type;
    volume->components = field.components;
    for (const int p : partitioning.owned(rank)) {
      const Extent extent = extentOf(mesh.grid, partitioning.box(p), kGhostLayers);
      if (extent.count() == 0) continue;
      VolumeBlock& block = volume->blocks[p];
      block.extent = extent;
      block.samples.reserve(Bricks(extent.points).count() * field.bytesPerPoint());
      block.samples.resize(size_t(extent.count()) * field.bytesPerPoint());
    }
    volumes_.push_back(std::move(volume));
  }
}

void GridRoom::store(const insitu::Piece& piece, size_t array, const insitu::PieceHeader& header,
                     std::span<const std::byte> samples) {
  Volume& volume = *volumes_.at(array);
  VolumeBlock& block = volume.blocks.at(piece.partition);
  const auto bytes = int64_t(bytesOf(volume.stored)) * volume.components;
  const Index3& size = piece.points.points;
  for (int64_t point = int64_t(header.offset) / bytes; !samples.empty();) {
    const Index3 at{point % size[0], point / size[0] % size[1], point / size[0] / size[1]};
    const int64_t n = std::min(size[0] - at[0], int64_t(samples.size()) / bytes);
    int64_t place = 0;
    for (size_t a = 3; a-- > 0;)
      place = place * block.extent.points[a] + piece.points.first[a] + at[a] - block.extent.first[a];
    std::memcpy(block.samples.data() + place * bytes, samples.data(), size_t(n * bytes));
    samples = samples.subspan(size_t(n * bytes));
    point += n;
  }
}

std::vector<std::shared_ptr<Dataset>> GridRoom::complete(Collectives& ranks) {
  std::vector<Volume*> all;
  for (const auto& volume : volumes_) all.push_back(volume.get());
  exchangeGhosts(all, ghosts_, ranks);
  for (Volume* volume : all) completeVolume(*volume, partitioning_, ranks);
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

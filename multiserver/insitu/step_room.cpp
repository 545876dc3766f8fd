// SPDX-License-Identifier: Apache-2.0
#include "multiserver/insitu/step_room.h"

#include <algorithm>
#include <cstring>

#include "core/data/bricks.h"

namespace gxy {

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

StepRoom::StepRoom(const insitu::Mesh& mesh, const Partitioning& partitioning, int rank) {
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

void StepRoom::store(size_t field, const insitu::Piece& piece, uint64_t offset,
                     std::span<const std::byte> samples) {
  Volume& volume = *volumes_.at(field);
  VolumeBlock& block = volume.blocks.at(piece.partition);
  const auto bytes = int64_t(bytesOf(volume.stored)) * volume.components;
  const Index3& size = piece.points.points;
  for (int64_t point = int64_t(offset) / bytes; !samples.empty();) {
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

}  // namespace gxy

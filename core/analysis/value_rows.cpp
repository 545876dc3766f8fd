// SPDX-License-Identifier: Apache-2.0
#include "core/analysis/value_rows.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/analysis/brick_rows.h"
#include "core/analysis/field_tiles.h"
#include "core/data/extents.h"

namespace gxy {
namespace {

/// The value that a sample counts as.
float counted(float sample) {
  if (std::abs(sample) < std::numeric_limits<float>::min()) return 0;
  return sample - sample == 0 ? sample : std::numeric_limits<float>::quiet_NaN();
}

}  // namespace

VolumeRows::VolumeRows(const Volume& volume, const Partitioning& partitioning, int component,
                       const Volume* where)
    : volume_(volume), component_(component), where_(where) {
  constexpr int64_t kPlanes = 8;
  offset = component < volume.components ? volume.shift : 0;
  scale = volume.scale;
  const DataPoints data(volume.grid);
  const Extent all{
      data.first,
      {data.last[0] - data.first[0] + 1, data.last[1] - data.first[1] + 1, data.last[2] - data.first[2] + 1}};
  for (const auto& entry : volume.blocks) {
    const Extent points = intersection(ownedPoints(volume.grid, partitioning, entry.first), all);
    if (points.count() == 0) continue;
    for (int64_t z = 0; z < points.points[2]; z += kPlanes) {
      Part part{entry.first, points};
      part.points.first[2] += z;
      part.points.points[2] = std::min(kPlanes, points.points[2] - z);
      parts_.push_back(part);
    }
  }
}

void VolumeRows::visit(size_t part, const std::function<void(const ValueRow&)>& use) const {
  const int partition = parts_[part].partition;
  const Extent& points = parts_[part].points;
  const VolumeBlock& block = volume_.blocks.at(partition);
  const Bricks bricks(block.extent.points);
  const DataPoints data(volume_.grid);
  const Grid& grid = volume_.grid;
  const auto n = size_t(points.points[0]);
  std::vector<float> values(n), others(n);
  std::vector<double> squares;
  std::vector<uint8_t> where(n);
  ValueRow row;
  row.stored = values;
  row.where = where_ ? where.data() : nullptr;
  Index3 at = points.first;
  row.position = [&](size_t i) {
    return grid.origin + grid.spacing * glm::dvec3(double(at[0] + int64_t(i)), double(at[1]), double(at[2]));
  };
  const auto isEnd = [&](size_t a, int64_t i) {
    return !grid.rim && (i == data.first[a] || i == data.last[a]);
  };
  row.halfFirst = isEnd(0, at[0]);
  row.halfLast = n > 1 && isEnd(0, at[0] + points.points[0] - 1);
  for (at[2] = points.first[2]; at[2] < points.first[2] + points.points[2]; ++at[2])
    for (at[1] = points.first[1]; at[1] < points.first[1] + points.points[1]; ++at[1]) {
      const Index3 from{at[0] - block.extent.first[0], at[1] - block.extent.first[1],
                        at[2] - block.extent.first[2]};
      const auto read = [&](int component, std::vector<float>& to) {
        withType(volume_.stored, [&](auto t) {
          readPieces<decltype(t)>(bricks, block.samples.data(), volume_.components, component, from,
                                  points.points[0], to.data());
        });
      };
      if (component_ < volume_.components) {
        read(component_, values);
      } else {
        squares.assign(n, 0);
        for (int c = 0; c < volume_.components; ++c) {
          read(c, others);
          for (size_t i = 0; i < n; ++i) squares[i] += double(others[i]) * double(others[i]);
        }
        for (size_t i = 0; i < n; ++i) values[i] = float(std::sqrt(squares[i]));
      }
      for (float& value : values) value = counted(value);
      if (where_)
        readPieces<uint8_t>(bricks, where_->blocks.at(partition).samples.data(), 1, 0, from, points.points[0],
                            where.data());
      row.first.id = uint64_t(at[0] + grid.points[0] * (at[1] + grid.points[1] * at[2]));
      row.weight = 8 >> int(isEnd(1, at[1]) + isEnd(2, at[2]));
      use(row);
    }
}

glm::dvec3 placeOf(const Mesh& mesh, const MeshBlock& block, uint32_t entry) {
  if (!mesh.ofCells) return block.points[entry];
  glm::dvec3 sum(0);
  const auto corners = block.cells.pointsOf(entry);
  for (const uint32_t corner : corners) sum += block.points[corner];
  return sum / double(corners.size());
}

MeshRows::MeshRows(const Mesh& mesh, const Partitioning& partitioning, int component)
    : mesh_(mesh), curve_(partitioning.domain()), component_(component) {
  offset = component < mesh.components ? mesh.shift : 0;
  scale = mesh.scale;
  for (const auto& [partition, block] : mesh.blocks) {
    std::vector<uint8_t> isHere(block.points.size(), 1);
    for (size_t p = 0; p < isHere.size() && partitioning.partitions() > 1; ++p)
      isHere[p] = partitioning.nearest(block.points[p]) == partition;
    const auto count = uint32_t(mesh.ofCells ? block.cells.size() : block.points.size());
    bool begins = true;
    for (uint32_t entry = 0; entry < count; ++entry) {
      uint32_t point = entry;
      if (mesh.ofCells) {
        const auto corners = block.cells.pointsOf(entry);
        point = *std::min_element(corners.begin(), corners.end());
      }
      if (!isHere[point]) continue;
      if (begins || parts_.back().entries.size() == kPart) parts_.push_back({&block, {}});
      parts_.back().entries.push_back(entry);
      begins = false;
    }
  }
}

float MeshRows::valueOf(const float* values) const {
  if (component_ < mesh_.components) return counted(values[component_]);
  double squares = 0;
  for (int c = 0; c < mesh_.components; ++c) squares += double(values[c]) * double(values[c]);
  return counted(float(std::sqrt(squares)));
}

void MeshRows::visit(size_t part, const std::function<void(const ValueRow&)>& use) const {
  const auto& [block, entries] = parts_[part];
  const float* const values = mesh_.ofCells ? block->cellValues.data() : block->values.data();
  std::vector<float> stored;
  std::vector<ValueKey> keys;
  for (const uint32_t entry : entries) {
    stored.push_back(valueOf(values + entry * size_t(mesh_.components)));
    keys.push_back({curve_(placeOf(mesh_, *block, entry)), 0});
  }
  ValueRow row;
  row.stored = stored;
  row.keys = keys.data();
  row.position = [this, part](size_t i) {
    return placeOf(mesh_, *parts_[part].block, parts_[part].entries[i]);
  };
  use(row);
}

void GeometryRows::visit(size_t part, const std::function<void(const ValueRow&)>& use) const {
  std::vector<float> values;
  std::vector<ValueKey> keys;
  std::vector<uint32_t> points;
  const auto add = [&](uint32_t point, ValueKey key) {
    values.push_back(block_.values.empty() ? std::numeric_limits<float>::quiet_NaN()
                                           : counted(block_.values[point]));
    keys.push_back(key);
    points.push_back(point);
  };
  for (size_t p = part * kPart; p < std::min(block_.ids.size(), (part + 1) * kPart); ++p) {
    if (kind_ == GeometryKind::Particles) {
      add(uint32_t(p), {block_.ids[p], 0});
      continue;
    }
    add(block_.segments[p][0], {block_.ids[p], 0});
    if (block_.neighbours[p][1] == block_.segments[p][1]) add(block_.segments[p][1], {block_.ids[p], 1});
  }
  ValueRow row;
  row.stored = values;
  row.keys = keys.data();
  row.position = [&](size_t i) { return block_.points[points[i]]; };
  use(row);
}

}  // namespace gxy

// SPDX-License-Identifier: Apache-2.0
#include "core/data/gather.h"

#include <algorithm>
#include <cstring>
#include <vector>

#include "core/comm/error.h"
#include "core/comm/wire.h"
#include "core/data/bricks.h"
#include "core/data/geometry_bytes.h"

namespace gxy {
namespace {

Extent common(const Extent& a, const Extent& b) {
  Extent both;
  for (size_t i = 0; i < 3; i++) {
    both.first[i] = std::max(a.first[i], b.first[i]);
    both.points[i] =
        std::max<int64_t>(std::min(a.first[i] + a.points[i], b.first[i] + b.points[i]) - both.first[i], 0);
  }
  return both;
}

/// Appends the values of some points of a block, x fastest.
void appendValues(const Volume& volume, const VolumeBlock& block, const Extent& part, Bytes& to) {
  const Bricks bricks(block.extent.points);
  const auto n = size_t(volume.components);
  const bool asStored = gatheredType(volume) == volume.stored;
  withType(volume.stored, [&](auto stored) {
    const size_t point = n * sizeof stored;
    for (int64_t z = part.first[2]; z < part.first[2] + part.points[2]; z++)
      for (int64_t y = part.first[1]; y < part.first[1] + part.points[1]; y++)
        bricks.alongX(part.first[0] - block.extent.first[0], y - block.extent.first[1],
                      z - block.extent.first[2], part.points[0], [&](size_t place, int64_t, int64_t count) {
                        const std::byte* from = &block.samples[place * point];
                        const size_t size = size_t(count) * point;
                        if (asStored) {
                          to.insert(to.end(), from, from + size);
                          return;
                        }
                        for (size_t at = 0; at < size; at += sizeof stored) {
                          std::memcpy(&stored, from + at, sizeof stored);
                          const double value = volume.shift + volume.scale * double(stored);
                          const auto* bytes = reinterpret_cast<const std::byte*>(&value);
                          to.insert(to.end(), bytes, bytes + sizeof value);
                        }
                      });
  });
}

/// Copies the points of `part`, x fastest, to their places in `slab`, a part of whole slices.
void place(std::span<const std::byte> values, const Extent& part, const Extent& slab, size_t pointBytes,
           std::vector<std::byte>& to) {
  const size_t row = size_t(part.points[0]) * pointBytes;
  for (int64_t z = 0; z < part.points[2]; z++)
    for (int64_t y = 0; y < part.points[1]; y++, values = values.subspan(row)) {
      const int64_t line =
          (part.first[2] + z - slab.first[2]) * slab.points[1] + part.first[1] + y - slab.first[1];
      std::memcpy(&to[size_t(line * slab.points[0] + part.first[0] - slab.first[0]) * pointBytes],
                  values.data(), row);
    }
}

}  // namespace

ScalarType gatheredType(const Volume& volume) {
  return volume.shift == 0 && volume.scale == 1 ? volume.stored : ScalarType::Float64;
}

Index3 gatheredPoints(const Grid& grid) {
  const int64_t outside = grid.rim ? 2 : 0;
  return {grid.points[0] - outside, grid.points[1] - outside, grid.points[2] - outside};
}

int64_t gatheredSliceBytes(const Volume& volume) {
  const Index3 n = gatheredPoints(volume.grid);
  return n[0] * n[1] * volume.components * int64_t(bytesOf(gatheredType(volume)));
}

void gatherSlices(const Volume& volume, const Partitioning& partitioning, Collectives& ranks, int64_t bytes,
                  const std::function<void(int64_t first, std::span<const std::byte> values)>& take) {
  const Index3 n = gatheredPoints(volume.grid);
  const int64_t rim = volume.grid.rim ? 1 : 0;
  const int64_t atOnce = std::clamp<int64_t>(bytes / gatheredSliceBytes(volume), 1, n[2]);
  const size_t pointBytes = size_t(volume.components) * bytesOf(gatheredType(volume));
  for (int64_t first = 0; first < n[2]; first += atOnce) {
    const Extent slab{{rim, rim, rim + first}, {n[0], n[1], std::min(atOnce, n[2] - first)}};
    std::vector<Bytes> messages(size_t(ranks.size()));
    agree(ranks, [&] {
      ranks.check();
      ranks.done(double(first) / double(n[2]));
      for (const auto& [partition, block] : volume.blocks) {
        const Extent part = common(ownedPoints(volume.grid, partitioning, partition), slab);
        if (part.count() == 0) continue;
        const Bytes header = Writer().write(part).take();
        messages[0].insert(messages[0].end(), header.begin(), header.end());
        appendValues(volume, block, part, messages[0]);
      }
    });
    const std::vector<Bytes> came = ranks.allToAll(std::move(messages));
    agree(ranks, [&] {
      if (ranks.rank() != 0) return;
      std::vector<std::byte> values(size_t(slab.count()) * pointBytes);
      int64_t points = 0;
      for (const Bytes& message : came) {
        std::span<const std::byte> rest(message);
        while (!rest.empty()) {
          Extent part;
          std::memcpy(&part, rest.data(), sizeof part);
          rest = rest.subspan(sizeof part);
          const size_t size = size_t(part.count()) * pointBytes;
          place(rest.first(size), part, slab, pointBytes, values);
          rest = rest.subspan(size);
          points += part.count();
        }
      }
      if (points != slab.count())
        throw Error("slices from " + std::to_string(first) + " on: found " + std::to_string(points) +
                    " points in partitions, expected " + std::to_string(slab.count()));
      take(first, values);
    });
  }
}

GeometryBlock gatherGeometry(const OwnedGeometry& geometry, Collectives& ranks) {
  std::vector<Bytes> messages(size_t(ranks.size()));
  agree(ranks, [&] {
    ranks.check();
    if (geometry.block.ids.empty()) return;
    Writer writer;
    write(writer, geometry.block);
    messages[0] = writer.take();
  });
  const std::vector<Bytes> came = ranks.allToAll(std::move(messages));
  GeometryBlock all;
  agree(ranks, [&] {
    std::vector<GeometryBlock> parts;
    for (const Bytes& message : came) {
      if (message.empty()) continue;
      Reader in(message, "primitives of a rank");
      parts.push_back(readBlock(in));
    }
    all = merged(geometry.kind, parts, advanceOf(ranks));
  });
  return all;
}

}  // namespace gxy

// SPDX-License-Identifier: Apache-2.0
#include "core/data/replicate.h"

#include <cmath>
#include <limits>

#include "core/comm/error.h"
#include "core/comm/wire.h"
#include "core/data/geometry_bytes.h"
#include "core/data/joined.h"

namespace gxy {
namespace {

/// Bounding box of a primitive's points, and the largest radius at them.
struct Bounds {
  Box box;
  double radius = 0;
};
Bounds boundsOf(const GeometryBlock& block, GeometryKind kind, size_t p, const RadiusOf& radius) {
  Bounds bounds;
  for (uint32_t i : primitivePoints(block, kind, p)) {
    bounds.box.extend(block.points[i]);
    if (kind == GeometryKind::Triangles) continue;
    const double r = radius(radiusValue(block, i));
    if (r > bounds.radius) bounds.radius = r;
  }
  return bounds;
}

}  // namespace

double borderSlack(const Partitioning& partitioning) {
  const Box& domain = partitioning.domain();
  double longest = 0, largest = 0;
  for (int a = 0; a < 3; ++a) {
    longest = std::max(longest, domain.hi[a] - domain.lo[a]);
    largest = std::max({largest, std::abs(domain.lo[a]), std::abs(domain.hi[a])});
  }
  return 16 * double(std::numeric_limits<float>::epsilon()) * longest +
         8 * std::numeric_limits<double>::epsilon() * largest;
}

std::vector<int> partitionsTouched(const Partitioning& partitioning, const Box& box, double radius) {
  const double reach = radius + borderSlack(partitioning);
  std::array<std::array<int, 2>, 3> cells;
  for (int a = 0; a < 3; ++a) cells[a] = partitioning.cellsTouched(a, box.lo[a] - reach, box.hi[a] + reach);
  const std::array<int, 3> n = partitioning.cells();
  const auto [x, y, z] = cells;
  std::vector<int> touched;
  for (int k = z[0]; k <= z[1]; ++k) {
    for (int j = y[0]; j <= y[1]; ++j) {
      const size_t row = (size_t(k) * size_t(n[1]) + size_t(j)) * size_t(n[0]);
      for (int i = x[0]; i <= x[1]; ++i) touched.push_back(partitioning.cellPartition()[row + size_t(i)]);
    }
  }
  std::sort(touched.begin(), touched.end());
  touched.erase(std::unique(touched.begin(), touched.end()), touched.end());
  return touched;
}

std::vector<Bytes> packForOwners(const GeometryBlock& read, GeometryKind kind,
                                 const Partitioning& partitioning, const RadiusOf& radius, int ranks,
                                 const Advance& advance, PrimitiveSpan span) {
  if (span.first == 0) validate(read, kind);
  std::vector<std::vector<uint32_t>> touching(static_cast<size_t>(partitioning.partitions()));
  const Advance finding = partOf(advance, 0, 2), packing = partOf(advance, 1, 2);
  span.last = std::min(span.last, read.ids.size());
  for (size_t p = span.first; p < span.last; ++p) {
    tell(finding, p - span.first, span.last - span.first);
    const Bounds bounds = boundsOf(read, kind, p, radius);
    for (int part : partitionsTouched(partitioning, bounds.box, bounds.radius)) {
      touching[size_t(part)].push_back(uint32_t(p));
    }
  }
  std::vector<Writer> writers(static_cast<size_t>(ranks));
  for (int part = 0; part < partitioning.partitions(); ++part) {
    const int owner = partitioning.owner(part);
    if (owner >= ranks) {
      throw Error("replication: partition " + std::to_string(part) + " is owned by rank " +
                  std::to_string(owner) + ", expected fewer than " + std::to_string(ranks));
    }
    if (touching[size_t(part)].empty()) continue;
    Writer& writer = writers[size_t(owner)];
    writer.write(int32_t(part));
    write(writer, subset(read, kind, touching[size_t(part)],
                         partOf(packing, size_t(part), size_t(partitioning.partitions()))));
  }
  std::vector<Bytes> messages;
  for (Writer& writer : writers) messages.push_back(writer.take());
  return messages;
}

ReceivedBlocks::ReceivedBlocks(GeometryKind kind, const Partitioning& partitioning, int rank)
    : kind_(kind), rank_(rank) {
  for (int part : partitioning.owned(rank)) parts_[part];
}

void ReceivedBlocks::take(std::span<const Bytes> messages) {
  for (const Bytes& message : messages) {
    Reader reader(message, "replicated primitives");
    while (!reader.rest().empty()) {
      const auto part = reader.read<int32_t>();
      const auto at = parts_.find(part);
      if (at == parts_.end()) {
        reader.fail("partition " + std::to_string(part) + " came, expected one of rank " +
                    std::to_string(rank_));
      }
      at->second.push_back(readBlock(reader));
      validate(at->second.back(), kind_);
    }
  }
}

std::map<int, GeometryBlock> ReceivedBlocks::merged(const Advance& advance) {
  std::map<int, GeometryBlock> blocks;
  for (auto& [part, list] : parts_) {
    const Advance mine = partOf(advance, blocks.size(), parts_.size());
    blocks.emplace(part, gxy::merged(kind_, joined(kind_, std::move(list)), mine));
  }
  return blocks;
}

std::vector<std::vector<uint32_t>> homesOf(const GeometryBlock& block, GeometryKind kind,
                                           const Partitioning& partitioning, int ranks,
                                           const Advance& advance) {
  std::vector<std::vector<uint32_t>> homes(static_cast<size_t>(ranks));
  for (size_t p = 0; p < block.ids.size(); ++p) {
    tell(advance, p, block.ids.size());
    const glm::dvec3 first = block.points[*primitivePoints(block, kind, p).begin()];
    homes.at(size_t(partitioning.owner(partitioning.nearest(first)))).push_back(uint32_t(p));
  }
  return homes;
}

}  // namespace gxy

// SPDX-License-Identifier: Apache-2.0
// Cells and values of meshes on their way between ranks.
#include <algorithm>
#include <set>
#include <string>
#include <tuple>
#include <utility>

#include "core/comm/error.h"
#include "core/comm/wire.h"
#include "core/data/mesh_blocks.h"
#include "core/data/mesh_values.h"
#include "core/data/morton.h"
#include "core/data/replicate.h"

namespace gxy {

namespace {

int ownerAmong(const Partitioning& partitioning, int partition, int ranks) {
  const int owner = partitioning.owner(partition);
  if (owner >= ranks)
    throw Error("replication: partition " + std::to_string(partition) + " is owned by rank " +
                std::to_string(owner) + ", expected fewer than " + std::to_string(ranks));
  return owner;
}

/// The cells of a partitioning that points reach with borderSlack(). Those of a cell of a mesh are the span of those of its points, so
/// that each point is searched for once.
class TouchedCells {
 public:
  TouchedCells(const std::vector<glm::dvec3>& points, const Partitioning& partitioning)
      : partitioning_(partitioning), cells_(partitioning.cells()) {
    const double slack = borderSlack(partitioning);
    ofPoints_.reserve(points.size());
    for (const glm::dvec3& p : points) {
      std::array<std::array<int, 2>, 3>& one = ofPoints_.emplace_back();
      for (int a = 0; a < 3; a++) one[size_t(a)] = partitioning.cellsTouched(a, p[a] - slack, p[a] + slack);
    }
  }

  /// The partitions that a cell of a mesh touches, ascending. The next call overwrites them.
  const std::vector<int>& partitionsOf(std::span<const uint32_t> cell) {
    std::array<std::array<int, 2>, 3> span = ofPoints_[cell[0]];
    for (const uint32_t point : cell.subspan(1))
      for (size_t a = 0; a < 3; a++) {
        span[a][0] = std::min(span[a][0], ofPoints_[point][a][0]);
        span[a][1] = std::max(span[a][1], ofPoints_[point][a][1]);
      }
    found_.clear();
    for (int k = span[2][0]; k <= span[2][1]; k++)
      for (int j = span[1][0]; j <= span[1][1]; j++) {
        const size_t row = (size_t(k) * size_t(cells_[1]) + size_t(j)) * size_t(cells_[0]);
        for (int i = span[0][0]; i <= span[0][1]; i++)
          found_.push_back(partitioning_.cellPartition()[row + size_t(i)]);
      }
    if (found_.size() > 1) {
      std::sort(found_.begin(), found_.end());
      found_.erase(std::unique(found_.begin(), found_.end()), found_.end());
    }
    return found_;
  }

 private:
  const Partitioning& partitioning_;
  const std::array<int, 3> cells_;
  std::vector<std::array<std::array<int, 2>, 3>> ofPoints_;
  std::vector<int> found_;
};

using CellNumbers = std::array<std::vector<uint32_t>, kCellTypes>;  // within each type

/// Some cells of a piece, with their points.
class Subset {
 public:
  explicit Subset(const MeshPiece& all) : all_(all), numberOf_(all.points.size(), kNone) {}

  /// `taken` becomes the points of the whole piece that these are.
  MeshPiece of(const CellNumbers& wanted, const Advance& advance, std::vector<uint32_t>& taken) {
    MeshPiece some;
    some.components = all_.components;
    some.ofCells = all_.ofCells;
    const auto components = size_t(all_.components);
    for (const CellType type : kAllCellTypes) {
      const size_t n = shapeOf(type).points;
      const std::vector<uint32_t>& from = all_.cells.points[size_t(type)];
      std::vector<uint32_t>& to = some.cells.points[size_t(type)];
      to.reserve(wanted[size_t(type)].size() * n);
      for (const uint32_t cell : wanted[size_t(type)]) {
        tell(advance, to.size() / n, wanted[size_t(type)].size());
        for (size_t i = 0; i < n; i++) {
          const uint32_t point = from[cell * n + i];
          if (numberOf_[point] == kNone) {
            numberOf_[point] = uint32_t(taken.size());
            taken.push_back(point);
          }
          to.push_back(numberOf_[point]);
        }
        if (!all_.ofCells) continue;
        const auto values = all_.cellValues[size_t(type)].begin() + std::ptrdiff_t(cell * components);
        std::vector<float>& own = some.cellValues[size_t(type)];
        own.insert(own.end(), values, values + std::ptrdiff_t(components));
        some.duplicates[size_t(type)].push_back(all_.duplicates[size_t(type)][cell]);
      }
    }
    some.points.reserve(taken.size());
    some.numbers.reserve(taken.size());
    some.values.reserve(taken.size() * components);
    for (const uint32_t point : taken) {
      some.points.push_back(all_.points[point]);
      some.numbers.push_back(all_.numbers[point]);
      numberOf_[point] = kNone;
      if (all_.ofCells) continue;
      const auto values = all_.values.begin() + std::ptrdiff_t(point * components);
      some.values.insert(some.values.end(), values, values + std::ptrdiff_t(components));
    }
    return some;
  }

 private:
  static constexpr uint32_t kNone = UINT32_MAX;
  const MeshPiece& all_;
  std::vector<uint32_t> numberOf_;
};

void write(Writer& writer, const MeshPiece& piece) {
  writer.write(int32_t(piece.components)).write(piece.points).write(piece.values).write(piece.numbers);
  for (const auto& cells : piece.cells.points) writer.write(cells);
  writer.write(uint8_t(piece.ofCells));
  if (!piece.ofCells) return;
  for (const auto& values : piece.cellValues) writer.write(values);
  for (const auto& duplicates : piece.duplicates) writer.write(duplicates);
}

MeshPiece readPiece(Reader& reader) {
  MeshPiece piece;
  piece.components = reader.read<int32_t>();
  piece.points = reader.readVector<glm::dvec3>();
  piece.values = reader.readVector<float>();
  piece.numbers = reader.readVector<uint64_t>();
  for (auto& cells : piece.cells.points) cells = reader.readVector<uint32_t>();
  piece.ofCells = reader.read<uint8_t>() != 0;
  if (piece.ofCells) {
    for (auto& values : piece.cellValues) values = reader.readVector<float>();
    for (auto& duplicates : piece.duplicates) duplicates = reader.readVector<uint8_t>();
  }
  validate(piece);
  return piece;
}

template <class T>
void append(std::vector<T>& to, const std::vector<T>& from) {
  to.insert(to.end(), from.begin(), from.end());
}

void append(MeshPiece& to, MeshPiece from) {
  if (to.points.empty() && to.cells.size() == 0) {
    to = std::move(from);
    return;
  }
  if (to.components != from.components)
    throw Error("parts of a mesh have " + std::to_string(to.components) + " and " +
                std::to_string(from.components) + " components, expected the same");
  if (to.ofCells != from.ofCells)
    throw Error("parts of a mesh have values of points and of cells, expected the same");
  if (to.points.size() + from.points.size() >= kMostMeshPoints)
    throw Error("a partition has a mesh of more than 2^30 points; use more partitions");
  const auto shift = uint32_t(to.points.size());
  append(to.points, from.points);
  append(to.values, from.values);
  append(to.numbers, from.numbers);
  for (size_t type = 0; type < kCellTypes; type++) {
    for (const uint32_t point : from.cells.points[type]) to.cells.points[type].push_back(point + shift);
    append(to.cellValues[type], from.cellValues[type]);
    append(to.duplicates[type], from.duplicates[type]);
  }
}

}  // namespace

std::vector<Bytes> packForOwners(const MeshPiece& read, const Partitioning& partitioning, int ranks,
                                 const Advance& advance, ValueRoutes* routes) {
  validate(read);
  if (routes) routes->sent.resize(size_t(ranks));
  const auto partitions = size_t(partitioning.partitions());
  std::vector<CellNumbers> touching(partitions);
  const Advance finding = partOf(advance, 0, 2), packing = partOf(advance, 1, 2);
  TouchedCells touched(read.points, partitioning);
  for (const CellType type : kAllCellTypes) {
    const size_t n = shapeOf(type).points, count = read.cells.size(type);
    const std::span<const uint32_t> cells = read.cells.points[size_t(type)];
    for (size_t cell = 0; cell < count; cell++) {
      tell(finding, cell, count);
      for (const int partition : touched.partitionsOf(cells.subspan(cell * n, n)))
        touching[size_t(partition)][size_t(type)].push_back(uint32_t(cell));
    }
  }
  std::vector<Writer> writers(static_cast<size_t>(ranks));
  Subset subset(read);
  for (size_t p = 0; p < partitions; p++) {
    const int owner = ownerAmong(partitioning, int(p), ranks);
    if (std::all_of(touching[p].begin(), touching[p].end(), [](const auto& some) { return some.empty(); }))
      continue;
    Writer& writer = writers[size_t(owner)];
    writer.write(int32_t(p));
    std::vector<uint32_t> taken;
    write(writer, subset.of(touching[p], partOf(packing, p, partitions), taken));
    for (const CellType type : kAllCellTypes)  // They become numbers among all cells.
      for (uint32_t& cell : touching[p][size_t(type)]) cell += read.cells.first(type);
    if (routes)
      routes->sent[size_t(owner)].push_back(
          {int(p), std::move(taken), read.ofCells ? std::move(touching[p]) : CellNumbers()});
    touching[p] = {};
  }
  std::vector<Bytes> messages;
  for (Writer& writer : writers) messages.push_back(writer.take());
  return messages;
}

std::map<int, MeshBlock> unpackMesh(const Partitioning& partitioning, int rank,
                                    std::span<const Bytes> received, MeshBlockCounts& counts,
                                    const Advance& advance, ValueRoutes* routes) {
  std::map<int, MeshPiece> pieces;
  for (const Bytes& message : received) {
    Reader reader(message, "cells of a mesh");
    while (!reader.rest().empty()) {
      advance(0);
      const auto partition = reader.read<int32_t>();
      if (partition < 0 || partition >= partitioning.partitions() || partitioning.owner(partition) != rank)
        reader.fail("partition " + std::to_string(partition) + " came, expected one of rank " +
                    std::to_string(rank));
      append(pieces[partition], readPiece(reader));
    }
  }
  std::map<int, MeshBlock> blocks;
  for (auto& [partition, piece] : pieces) {
    MeshBlock block = meshBlock(
        std::move(piece), partitioning, partition, counts,
        partOf(advance, size_t(std::distance(pieces.begin(), pieces.find(partition))), pieces.size()),
        routes ? &routes->taken[partition] : nullptr);
    if (block.cells.size() > 0) blocks.emplace(partition, std::move(block));
  }
  return blocks;
}

std::vector<Bytes> packSettledValues(const std::map<int, MeshBlock>& blocks, const MeshBlockCounts& counts,
                                     const Partitioning& partitioning, int ranks) {
  std::set<std::tuple<int, int, uint32_t>> toTell;  // to which partition, of which one, the point
  for (const auto& [partition, differing] : counts.differing) {
    const auto block = blocks.find(partition);
    if (block == blocks.end()) continue;
    std::vector<uint8_t> differs(block->second.points.size(), 0);
    for (const uint32_t point : differing) differs[point] = 1;
    for (const CellType type : kAllCellTypes) {
      const size_t n = shapeOf(type).points;
      const std::span<const uint32_t> cells = block->second.cells.points[size_t(type)];
      for (size_t at = 0; at < cells.size(); at += n) {
        const auto cell = cells.subspan(at, n);
        if (std::none_of(cell.begin(), cell.end(), [&](uint32_t point) { return differs[point]; })) continue;
        Box box;
        for (const uint32_t point : cell) box.extend(block->second.points[point]);
        for (const int to : partitionsTouched(partitioning, box, 0))
          for (const uint32_t point : cell)
            if (differs[point] && to != partition) toTell.emplace(to, partition, point);
      }
    }
  }
  std::vector<Writer> writers(static_cast<size_t>(ranks));
  for (const auto& [to, from, point] : toTell) {
    const MeshBlock& block = blocks.at(from);
    const size_t components = block.values.size() / block.points.size();
    writers[size_t(ownerAmong(partitioning, to, ranks))]
        .write(int32_t(to))
        .write(block.points[point])
        .write(std::span(block.values).subspan(point * components, components));
  }
  std::vector<Bytes> messages;
  for (Writer& writer : writers) messages.push_back(writer.take());
  return messages;
}

void takeSettledValues(std::map<int, MeshBlock>& blocks, const Partitioning& partitioning,
                       std::span<const Bytes> received) {
  const MortonCurve curve(partitioning.domain());
  const auto keyOf = [&](const glm::dvec3& p) { return std::tuple(curve(p), p.x, p.y, p.z); };
  for (const Bytes& message : received) {
    Reader reader(message, "values of points of a mesh");
    while (!reader.rest().empty()) {
      const auto partition = reader.read<int32_t>();
      const auto place = reader.read<glm::dvec3>();
      const auto values = reader.readVector<float>();
      const auto at = blocks.find(partition);
      if (at == blocks.end()) continue;
      MeshBlock& block = at->second;
      const auto point =
          std::lower_bound(block.points.begin(), block.points.end(), place,
                           [&](const glm::dvec3& a, const glm::dvec3& b) { return keyOf(a) < keyOf(b); });
      if (point == block.points.end() || *point != place) continue;
      const size_t components = block.values.size() / block.points.size();
      if (values.size() != components)
        reader.fail(std::to_string(values.size()) + " components came, expected " +
                    std::to_string(components));
      std::copy(values.begin(), values.end(),
                block.values.begin() + (point - block.points.begin()) * std::ptrdiff_t(components));
    }
  }
}

void settle(std::map<int, MeshBlock>& blocks, const Partitioning& partitioning, MeshBlockCounts& counts,
            std::span<uint64_t* const> toSum, Collectives& ranks, bool ofCells) {
  std::vector<uint64_t> mine;
  for (const uint64_t* sum : toSum) mine.push_back(*sum);
  const auto all = gatherValues(ranks, std::span<const uint64_t>(mine));
  for (size_t i = 0; i < mine.size(); i++) {
    *toSum[i] = 0;
    for (const auto& theirs : all) *toSum[i] += theirs[i];
  }
  if (counts.differingPoints == 0 && !ofCells) return;
  std::vector<Bytes> messages;
  agree(ranks, [&] { messages = packSettledValues(blocks, counts, partitioning, ranks.size()); });
  const std::vector<Bytes> received = ranks.allToAll(std::move(messages));
  agree(ranks, [&] { takeSettledValues(blocks, partitioning, received); });
}

std::map<int, MeshBlock> distribute(MeshPiece read, const Partitioning& partitioning, MeshBlockCounts& counts,
                                    Collectives& ranks, const std::function<void(int64_t)>& toTake,
                                    ValueRoutes* routes) {
  std::vector<Bytes> messages;
  const bool ofCells = read.ofCells;
  agree(ranks, [&] {
    if (toTake) toTake(bytesOf(read));
    messages = packForOwners(read, partitioning, ranks.size(), advanceOf(ranks, 0, 0.5), routes);
    read = {};
  });
  std::vector<Bytes> received = ranks.allToAll(std::move(messages));
  std::map<int, MeshBlock> blocks;
  agree(ranks, [&] {
    // Of a tetrahedron a message has 16 bytes, and the block in the making twice as many and 64 for its faces; of
    // other cells it is less by their points.
    int64_t bytes = 0;
    for (const Bytes& message : received) bytes += int64_t(message.size());
    if (toTake) toTake(4 * bytes);
    blocks = unpackMesh(partitioning, ranks.rank(), received, counts, advanceOf(ranks, 0.5), routes);
    received.clear();
  });
  uint64_t* const sums[] = {&counts.points,         &counts.repeatedCells,   &counts.degenerateCells,
                            &counts.mergedPoints,   &counts.differingPoints, &counts.crowdedFaces,
                            &counts.foldedFaces,    &counts.invertedCells,   &counts.hangingPoints,
                            &counts.splitFaces,     &counts.noDataPoints,    &counts.noDataCells,
                            &counts.differingCells, &counts.cells[0],        &counts.cells[1],
                            &counts.cells[2],       &counts.cells[3]};
  settle(blocks, partitioning, counts, sums, ranks, ofCells);
  return blocks;
}

}  // namespace gxy

// SPDX-License-Identifier: Apache-2.0
#include "core/data/complete_mesh.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <span>
#include <utility>

#include "core/data/merge_ranges.h"

namespace gxy {

namespace {

// Ranges of components and of the magnitude, of what this rank has. `leftOut`: 1 for those that do not count; empty if all do.
std::vector<Range> rangesOf(const std::vector<double>& values, size_t components,
                            std::span<const uint8_t> leftOut, const Advance& advance) {
  std::vector<Range> ranges(components > 1 ? components + 1 : 1);
  const size_t points = values.size() / components;
  for (size_t p = 0; p < points; p++) {
    tell(advance, p, points);
    if (!leftOut.empty() && leftOut[p]) continue;
    double sum = 0;
    for (size_t c = 0; c < components; c++) {
      const double value = values[p * components + c];
      ranges[c].extend(value);
      sum += value * value;
    }
    if (components > 1) ranges.back().extend(std::sqrt(sum));
  }
  return ranges;
}

Mesh meshWith(EncodedValues values, const MeshBlockCounts& counts, const Box& box) {
  Mesh mesh;
  mesh.ofCells = values.ofCells;
  mesh.components = values.components;
  mesh.shift = values.shift;
  mesh.scale = values.scale;
  mesh.ranges = std::move(values.ranges);
  mesh.box = box;
  MeshReport& report = mesh.report;
  report.cells = counts.cells;
  report.points = counts.points;
  report.repeatedCells = counts.repeatedCells;
  report.degenerateCells = counts.degenerateCells;
  report.mergedPoints = counts.mergedPoints;
  report.differingPoints = counts.differingPoints;
  report.crowdedFaces = counts.crowdedFaces;
  report.foldedFaces = counts.foldedFaces;
  report.invertedCells = counts.invertedCells;
  report.hangingPoints = counts.hangingPoints;
  report.splitFaces = counts.splitFaces;
  report.noDataPoints = counts.noDataPoints;
  report.noDataCells = counts.noDataCells;
  report.differingCells = counts.differingCells;
  return mesh;
}

// The points of cells that are no duplicates.
Box boxOf(const MeshPiece& piece) {
  Box box;
  for (const CellType type : kAllCellTypes) {
    const std::vector<uint8_t>& duplicates = piece.duplicates[size_t(type)];
    const size_t n = shapeOf(type).points;
    for (size_t cell = 0; cell < duplicates.size(); cell++)
      for (size_t i = 0; i < n && !duplicates[cell]; i++)
        box.extend(piece.points[piece.cells.points[size_t(type)][cell * n + i]]);
  }
  return box;
}

std::vector<uint8_t> duplicatesOf(const MeshPiece& piece) {
  std::vector<uint8_t> all;
  for (const auto& ofType : piece.duplicates) all.insert(all.end(), ofType.begin(), ofType.end());
  return all;
}

void keepDuplicates(const MeshPiece& piece, MeshLayout& layout) {
  std::vector<uint8_t> duplicates = duplicatesOf(piece);
  if (std::find(duplicates.begin(), duplicates.end(), 1) == duplicates.end()) return;
  layout.duplicates = std::move(duplicates);
  layout.pointsOfDuplicates.assign(piece.points.size(), 1);
  for (const CellType type : kAllCellTypes) {
    const std::vector<uint32_t>& corners = piece.cells.points[size_t(type)];
    const size_t n = shapeOf(type).points;
    for (size_t i = 0; i < corners.size(); i++)
      if (!piece.duplicates[size_t(type)][i / n]) layout.pointsOfDuplicates[corners[i]] = 0;
  }
}

}  // namespace

EncodedValues encodedValues(ScalarType type, int components, bool ofCells, const std::vector<double>& values,
                            std::span<const uint8_t> leftOut, Collectives& ranks, const ToTake& toTake) {
  EncodedValues encoded;
  encoded.components = components;
  encoded.ofCells = ofCells;
  const Advance advance = [&](double) { ranks.check(); };
  agree(ranks, [&] { encoded.ranges = rangesOf(values, size_t(components), leftOut, advance); });
  mergeRanges(ranks, encoded.ranges);
  agree(ranks, [&] {
    Range ofAll;
    for (size_t c = 0; c < size_t(components); c++) ofAll.extend(encoded.ranges[c]);
    const Encoding encoding = encodingOf(type, components, ofAll);
    encoded.shift = encoding.shift;
    encoded.scale = encoding.scale;
    if (toTake) toTake(int64_t(values.size() * sizeof(float)));
    const Samples stored = convert(std::as_bytes(std::span(values)), ScalarType::Float64,
                                   {ScalarType::Float32, encoding.shift, encoding.scale}, advance);
    encoded.stored.resize(values.size());
    if (!stored.empty()) std::memcpy(encoded.stored.data(), stored.data(), stored.size());
  });
  return encoded;
}

EncodedMesh encodedMesh(MeshPiece piece, ScalarType type, std::vector<double> values, Collectives& ranks,
                        const ToTake& toTake) {
  EncodedMesh mesh;
  if (piece.ofCells)
    mesh.box = boxOf(piece);
  else
    for (const glm::dvec3& p : piece.points) mesh.box.extend(p);
  mergeBox(ranks, mesh.box);
  EncodedValues encoded =
      encodedValues(type, piece.components, piece.ofCells, values, duplicatesOf(piece), ranks, toTake);
  mesh.piece = std::move(piece);
  auto from = encoded.stored.begin();
  for (size_t kind = 0; kind < kCellTypes && mesh.piece.ofCells; kind++) {
    const auto count = std::ptrdiff_t(mesh.piece.duplicates[kind].size() * size_t(mesh.piece.components));
    mesh.piece.cellValues[kind].assign(from, from + count);
    from += count;
  }
  if (!mesh.piece.ofCells) mesh.piece.values = std::move(encoded.stored);
  mesh.shift = encoded.shift;
  mesh.scale = encoded.scale;
  mesh.ranges = std::move(encoded.ranges);
  return mesh;
}

int64_t bytesOf(const MeshLayout& layout) {
  Mesh mesh;
  mesh.blocks = layout.blocks;
  return bytesOf(mesh);
}

Mesh completeMesh(EncodedMesh read, const Partitioning& partitioning, Collectives& ranks,
                  const ToTake& toTake, MeshLayout* layout) {
  EncodedValues values{{},         read.piece.components, read.piece.ofCells, read.shift,
                       read.scale, std::move(read.ranges)};
  MeshBlockCounts counts;
  if (layout) agree(ranks, [&] { keepDuplicates(read.piece, *layout); });
  std::map<int, MeshBlock> blocks = distribute(std::move(read.piece), partitioning, counts, ranks, toTake,
                                               layout ? &layout->routes : nullptr);
  Mesh mesh = meshWith(std::move(values), counts, read.box);
  mesh.blocks = std::move(blocks);
  if (!layout) return mesh;
  for (const auto& [partition, block] : mesh.blocks)
    layout->blocks[partition] = {block.points, {}, block.cells, block.neighbours, block.shell};
  layout->counts = std::move(counts);
  layout->box = read.box;
  return mesh;
}

Mesh completeMesh(EncodedValues values, const MeshLayout& layout, const Partitioning& partitioning,
                  Collectives& ranks, const ToTake& toTake) {
  MeshBlockCounts counts = layout.counts;
  std::map<int, MeshBlock> blocks =
      distributeValues(layout.blocks, layout.routes, values.stored, values.components, values.ofCells,
                       partitioning, counts, ranks, toTake);
  Mesh mesh = meshWith(std::move(values), counts, layout.box);
  mesh.blocks = std::move(blocks);
  return mesh;
}

}  // namespace gxy

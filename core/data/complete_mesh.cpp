// SPDX-License-Identifier: Apache-2.0
#include "core/data/complete_mesh.h"

#include <cmath>
#include <cstring>
#include <map>
#include <span>
#include <utility>

#include "core/data/merge_ranges.h"

namespace gxy {

namespace {

// Ranges of components and of the magnitude, of what this rank has.
std::vector<Range> rangesOf(const std::vector<double>& values, size_t components, const Advance& advance) {
  std::vector<Range> ranges(components > 1 ? components + 1 : 1);
  const size_t points = values.size() / components;
  for (size_t p = 0; p < points; p++) {
    tell(advance, p, points);
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
  report.noDataPoints = counts.noDataPoints;
  return mesh;
}

}  // namespace

EncodedValues encodedValues(ScalarType type, int components, std::vector<double> values, Collectives& ranks,
                            const ToTake& toTake) {
  EncodedValues encoded;
  encoded.components = components;
  const Advance advance = [&](double) { ranks.check(); };
  agree(ranks, [&] { encoded.ranges = rangesOf(values, size_t(components), advance); });
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
  for (const glm::dvec3& p : piece.points) mesh.box.extend(p);
  mergeBox(ranks, mesh.box);
  EncodedValues encoded = encodedValues(type, piece.components, std::move(values), ranks, toTake);
  mesh.piece = std::move(piece);
  mesh.piece.values = std::move(encoded.stored);
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
  EncodedValues values{{}, read.piece.components, read.shift, read.scale, std::move(read.ranges)};
  MeshBlockCounts counts;
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
  std::map<int, MeshBlock> blocks = distributeValues(layout.blocks, layout.routes, values.stored,
                                                     values.components, partitioning, counts, ranks, toTake);
  Mesh mesh = meshWith(std::move(values), counts, layout.box);
  mesh.blocks = std::move(blocks);
  return mesh;
}

}  // namespace gxy

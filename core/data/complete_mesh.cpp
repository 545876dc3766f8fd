// SPDX-License-Identifier: Apache-2.0
#include "core/data/complete_mesh.h"

#include <cmath>
#include <cstring>
#include <span>
#include <utility>

#include "core/data/merge_ranges.h"

namespace gxy {

namespace {

// Ranges of components and of the magnitude, and the box, of what this rank has.
void measureMesh(EncodedMesh& mesh, const std::vector<double>& values, const Advance& advance) {
  const size_t components = size_t(mesh.piece.components);
  mesh.ranges.assign(components > 1 ? components + 1 : 1, {});
  for (size_t p = 0; p < mesh.piece.points.size(); p++) {
    tell(advance, p, mesh.piece.points.size());
    mesh.box.extend(mesh.piece.points[p]);
    double sum = 0;
    for (size_t c = 0; c < components; c++) {
      const double value = values[p * components + c];
      mesh.ranges[c].extend(value);
      sum += value * value;
    }
    if (components > 1) mesh.ranges.back().extend(std::sqrt(sum));
  }
}

}  // namespace

EncodedMesh encodedMesh(MeshPiece piece, ScalarType type, std::vector<double> values, Collectives& ranks,
                        const std::function<void(int64_t)>& toTake) {
  EncodedMesh mesh;
  mesh.piece = std::move(piece);
  agree(ranks, [&] { measureMesh(mesh, values, [&](double) { ranks.check(); }); });
  mergeBox(ranks, mesh.box);
  mergeRanges(ranks, mesh.ranges);
  agree(ranks, [&] {
    Range ofAll;
    for (size_t c = 0; c < size_t(mesh.piece.components); c++) ofAll.extend(mesh.ranges[c]);
    const Encoding encoding = encodingOf(type, mesh.piece.components, ofAll);
    mesh.shift = encoding.shift;
    mesh.scale = encoding.scale;
    if (toTake) toTake(int64_t(values.size() * sizeof(float)));
    const Samples stored =
        convert(std::as_bytes(std::span(values)), ScalarType::Float64,
                {ScalarType::Float32, encoding.shift, encoding.scale}, [&](double) { ranks.check(); });
    mesh.piece.values.resize(values.size());
    if (!stored.empty()) std::memcpy(mesh.piece.values.data(), stored.data(), stored.size());
  });
  return mesh;
}

Mesh completeMesh(EncodedMesh read, const Partitioning& partitioning, Collectives& ranks,
                  const std::function<void(int64_t)>& toTake) {
  Mesh mesh;
  mesh.components = read.piece.components;
  mesh.shift = read.shift;
  mesh.scale = read.scale;
  mesh.ranges = std::move(read.ranges);
  mesh.box = read.box;
  MeshBlockCounts counts;
  mesh.blocks = distribute(std::move(read.piece), partitioning, counts, ranks, toTake);
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

}  // namespace gxy

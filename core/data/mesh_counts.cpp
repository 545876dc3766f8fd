// SPDX-License-Identifier: Apache-2.0
#include "core/data/mesh_counts.h"

namespace gxy {

std::vector<std::pair<const char*, uint64_t>> namedCounts(const MeshReport& report) {
  std::vector<std::pair<const char*, uint64_t>> all;
  const auto add = [&](const char* name, uint64_t count) {
    if (count > 0) all.emplace_back(name, count);
  };
  for (const CellType type : kAllCellTypes) add(pluralOf(type), report.cells[size_t(type)]);
  add("flat cells", report.flatCells);
  add("ghost cells", report.ghostCells);
  add("repeated cells", report.repeatedCells);
  add("degenerate cells", report.degenerateCells);
  add("unusable cells", report.unusableCells);
  add("merged points", report.mergedPoints);
  add("differing points", report.differingPoints);
  add("crowded faces", report.crowdedFaces);
  add("folded faces", report.foldedFaces);
  add("inverted cells", report.invertedCells);
  add("hanging points", report.hangingPoints);
  add("split faces", report.splitFaces);
  add("points without data", report.noDataPoints);
  add("cells without data", report.noDataCells);
  add("differing cells", report.differingCells);
  return all;
}

}  // namespace gxy

// SPDX-License-Identifier: Apache-2.0
#include "core/data/cells_around.h"

namespace gxy {

CellsAround::CellsAround(const MeshCellsView& cells, size_t points) : first_(points + 1, 0) {
  for (const auto& ofType : cells.points)
    for (const uint32_t point : ofType) first_[point + 1]++;
  for (size_t p = 0; p < points; p++) first_[p + 1] += first_[p];
  cells_.resize(first_[points]);
  std::vector<size_t> next(first_.begin(), first_.end() - 1);
  uint32_t cell = 0;
  for (const CellType type : kAllCellTypes) {
    const std::span<const uint32_t> corners = cells.points[size_t(type)];
    const size_t n = shapeOf(type).points;
    for (size_t at = 0; at < corners.size(); at += n, cell++)
      for (size_t i = 0; i < n; i++) cells_[next[corners[at + i]]++] = cell;
  }
}

}  // namespace gxy

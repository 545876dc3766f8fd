// SPDX-License-Identifier: Apache-2.0
// The cells of a mesh that have a point.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/data/mesh.h"

namespace gxy {

/// The cells that have each point, in the order of cells. A cell is there twice for a point that it has twice. Immutable; safe to use from
/// any thread.
class CellsAround {
 public:
  CellsAround(const MeshCellsView& cells, size_t points);

  std::span<const uint32_t> of(size_t point) const {
    return std::span(cells_).subspan(first_[point], first_[point + 1] - first_[point]);
  }

 private:
  std::vector<size_t> first_;  ///< by point, and the end of all
  std::vector<uint32_t> cells_;
};

}  // namespace gxy

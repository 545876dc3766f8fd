// SPDX-License-Identifier: Apache-2.0
// Cells of a mesh as kernels take them.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "core/data/mesh.h"

namespace gxy {

/// The cells of a block: tetrahedra (kernels/mesh.h), or hexahedra, some of whose corners are the same for other cells
/// (kernels/hexahedron.h). It refers to the block, which must stay as it is.
struct KernelCells {
  KernelCells() = default;
  KernelCells(KernelCells&&) = default;
  KernelCells& operator=(KernelCells&&) = default;

  uint32_t corners = 4;              ///< of a cell, 4 or 8
  uint32_t sides = 4;                ///< of a cell, 4 or 6
  std::span<const uint32_t> points;  ///< of all cells, one after the other
  std::span<const uint32_t>
      neighbours;  ///< for each side of each cell the side of the neighbour in this block, or kNoFace
  std::vector<uint32_t> orders;  ///< of hexahedra: one per cell (kernels/hexahedron.h)
  std::vector<uint32_t> shell;   ///< the sides without a neighbour that have an area

  size_t size() const { return points.size() / corners; }
  std::span<const uint32_t> pointsOf(size_t cell) const { return points.subspan(cell * corners, corners); }
  /// Whether the corners of a side, given as bits, are all corners of a side of this cell that has an area and no neighbour.
  bool isOuterSide(size_t cell, uint32_t bits) const;

 private:
  friend KernelCells kernelCells(const MeshBlock&, bool);
  std::vector<uint32_t> ownPoints_, ownNeighbours_;
};

/// Returns the cells of a block. `tetrahedra`: whether all cells of the whole mesh are tetrahedra; otherwise all of them become
/// hexahedra, whatever this block has, so that pictures do not depend on the partitions.
KernelCells kernelCells(const MeshBlock& block, bool tetrahedra);

}  // namespace gxy

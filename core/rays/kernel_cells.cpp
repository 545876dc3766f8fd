// SPDX-License-Identifier: Apache-2.0
#include "core/rays/kernel_cells.h"

#include <algorithm>
#include <array>

#include "core/kernels/single.h"

namespace gxy {

namespace {

using HexPoints = std::array<uint32_t, 8>;

// A cell of a type as a hexahedron: which of its points each corner is, and the side that each of its faces becomes.
struct AsHexahedron {
  std::array<uint8_t, 8> corner;
  std::array<uint8_t, 6> side;
};

constexpr std::array<AsHexahedron, kCellTypes> kAsHexahedra{{
    {{0, 1, 2, 2, 3, 3, 3, 3}, {1, 0, 2, 4}},
    {{0, 1, 2, 3, 4, 4, 4, 4}, {4, 2, 1, 3, 0}},
    {{0, 1, 2, 2, 3, 4, 5, 5}, {4, 5, 2, 1, 0}},
    {{0, 1, 2, 3, 4, 5, 6, 7}, {0, 1, 2, 3, 4, 5}},
}};

FaceId sideOf(FaceId face, const SharedMeshCells& cells) {
  if (face == kNoFace) return face;
  return faceId(cellOf(face), kAsHexahedra[size_t(cells.typeOf(cellOf(face)))].side[size_t(faceOf(face))]);
}

std::array<uint32_t, 4> pointsOfSide(const HexPoints& cell, uint32_t side) {
  const uint32_t corners = single::sideCorners(side);
  std::array<uint32_t, 4> points;
  for (uint32_t k = 0; k < 4; k++) points[k] = cell[corners >> 4 * k & 7];
  return points;
}

// The order of a side: it begins at the lowest point and goes on to the lower one of those beside it, or, in a triangle, so that the
// third and the fourth corner are the same point.
uint32_t orderOf(const HexPoints& cell, uint32_t side) {
  constexpr uint32_t kOtherWay = 4, kTriangle = 8;
  const std::array<uint32_t, 4> points = pointsOfSide(cell, side);
  for (uint32_t k = 0; k < 4; k++)
    if (points[k] == points[(k + 1) % 4]) return (k + 2) % 4 | kTriangle;
  const auto lowest = uint32_t(std::min_element(points.begin(), points.end()) - points.begin());
  return lowest | (points[(lowest + 3) % 4] < points[(lowest + 1) % 4] ? kOtherWay : 0);
}

bool hasArea(std::array<uint32_t, 4> points) {
  std::sort(points.begin(), points.end());
  return std::unique(points.begin(), points.end()) - points.begin() >= 3;
}

}  // namespace

bool KernelCells::isOuterSide(size_t cell, uint32_t bits) const {
  for (uint32_t side = 0; side < sides; side++) {
    if (neighbours[cell * sides + side] != kNoFace) continue;
    uint32_t ofSide = 0;
    if (corners == 4) {
      ofSide = 15u & ~(1u << side);
    } else {
      HexPoints points;
      std::copy_n(pointsOf(cell).begin(), 8, points.begin());
      const auto own = pointsOfSide(points, side);
      if (!hasArea(own)) continue;
      for (uint32_t k = 0; k < 8; k++)
        if (std::find(own.begin(), own.end(), points[k]) != own.end()) ofSide |= 1u << k;
    }
    if (ofSide == bits) return true;
  }
  return false;
}

KernelCells kernelCells(const MeshBlock& block, bool tetrahedra) {
  KernelCells cells;
  if (tetrahedra) {
    cells.points = block.cells.points[size_t(CellType::Tetrahedron)];
    cells.neighbours = block.neighbours[size_t(CellType::Tetrahedron)];
    cells.shell.assign(block.shell.begin(), block.shell.end());
    return cells;
  }
  const size_t count = block.cells.size();
  cells.corners = 8;
  cells.sides = 6;
  cells.ownPoints_.reserve(8 * count);
  cells.ownNeighbours_.assign(6 * count, kNoFace);
  cells.orders.assign(count, 0);
  size_t cell = 0;
  for (const CellType type : kAllCellTypes) {
    const AsHexahedron& as = kAsHexahedra[size_t(type)];
    const size_t faces = shapeOf(type).faces;
    for (size_t i = 0; i < block.cells.size(type); i++, cell++) {
      const auto own = block.cells.pointsOf(uint32_t(cell));
      HexPoints points;
      for (size_t k = 0; k < 8; k++) points[k] = own[as.corner[k]];
      cells.ownPoints_.insert(cells.ownPoints_.end(), points.begin(), points.end());
      for (size_t f = 0; f < faces; f++)
        cells.ownNeighbours_[6 * cell + as.side[f]] =
            sideOf(block.neighbours[size_t(type)][i * faces + f], block.cells);
      for (uint32_t side = 0; side < HEX_SIDES; side++)
        cells.orders[cell] |= orderOf(points, side) << 4 * side;
    }
  }
  for (const FaceId face : block.shell) cells.shell.push_back(sideOf(face, block.cells));
  cells.points = cells.ownPoints_;
  cells.neighbours = cells.ownNeighbours_;
  return cells;
}

}  // namespace gxy

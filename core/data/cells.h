// SPDX-License-Identifier: Apache-2.0
// Lines and faces of VTK's cell types become path lines and triangles.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "core/data/geometry.h"

namespace gxy {

/// The cells of first order that become path lines or triangles, by their numbers in VTK.
enum class DrawnCellType : uint8_t {
  Line = 3,
  PolyLine = 4,
  Triangle = 5,
  TriangleStrip = 6,
  Polygon = 7,
  Pixel = 8,  ///< a quad whose last two points are swapped
  Quad = 9
};

/// Whether cells of a type become path lines, or triangles. Any number may be asked for.
constexpr bool becomesLines(int type) {
  return type == int(DrawnCellType::Line) || type == int(DrawnCellType::PolyLine);
}
constexpr bool becomesTriangles(int type) {
  return type >= int(DrawnCellType::Triangle) && type <= int(DrawnCellType::Quad);
}

/// The number of points of each cell of a type; 0 if they have any number.
constexpr size_t pointsOfEach(DrawnCellType type) {
  switch (type) {
    case DrawnCellType::Line:
      return 2;
    case DrawnCellType::Triangle:
      return 3;
    case DrawnCellType::Pixel:
    case DrawnCellType::Quad:
      return 4;
    case DrawnCellType::PolyLine:
    case DrawnCellType::TriangleStrip:
    case DrawnCellType::Polygon:
      break;
  }
  return 0;
}

/// The number of segments or triangles of a cell with this many points; 0 if there are too few.
constexpr size_t primitivesOf(DrawnCellType type, size_t points) {
  const size_t fewer = becomesLines(int(type)) ? 1 : 2;
  return points > fewer ? points - fewer : 0;
}

/// Appends the segments of a line, in the order along it.
void appendLine(std::span<const uint32_t> points, GeometryBlock& block);
/// Appends the triangles of a cell that becomes triangles: those of primitivesOf(). Faces of more than three corners are cut by
/// triangulate(). The points are in the block.
void appendTriangles(DrawnCellType type, std::span<const uint32_t> points, GeometryBlock& block);

/// Copies points so that each cell has points of its own, which its primitives share; so a cell can have one
/// value or colour. For each point that is added, give(split, cell) appends the value or colour of its cell.
/// `cells` has the cell of each primitive; primitives of one cell follow each other.
void splitByCell(GeometryBlock& block, GeometryKind kind, std::span<const int64_t> cells,
                 const std::function<void(GeometryBlock& split, int64_t cell)>& give);

}  // namespace gxy

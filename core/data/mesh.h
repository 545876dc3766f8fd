// SPDX-License-Identifier: Apache-2.0
// MeshCells: the cells of an unstructured mesh, by their types.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace gxy {

/// Points and faces of a cell are in the order of VTK's linear cell of the same name, except for the faces of a tetrahedron: face i is
/// opposite point i there.
enum class CellType : uint8_t { Tetrahedron, Pyramid, Wedge, Hexahedron };
inline constexpr size_t kCellTypes = 4;
inline constexpr std::array<CellType, kCellTypes> kAllCellTypes{CellType::Tetrahedron, CellType::Pyramid,
                                                                CellType::Wedge, CellType::Hexahedron};

/// A face of a cell: the places of its corners among the cell's points. Seen from outside they run counterclockwise if the cell is
/// not inverted.
struct CellFace {
  uint8_t corners;  ///< 3 or 4
  std::array<uint8_t, 4> corner;
};

/// What all cells of a type have in common.
struct CellShape {
  uint8_t points, faces;
  std::array<CellFace, 6> face;
};
const CellShape& shapeOf(CellType type);

/// A face of a cell of a mesh. Every face of two cells has two of these.
using FaceId = uint32_t;
inline constexpr FaceId kNoFace = UINT32_MAX;
inline constexpr FaceId faceId(uint32_t cell, int face) { return cell << 3 | uint32_t(face); }
inline constexpr uint32_t cellOf(FaceId id) { return id >> 3; }
inline constexpr int faceOf(FaceId id) { return int(id & 7); }

/// A mesh may have one point or cell less than this.
inline constexpr uint64_t kMostMeshPoints = uint64_t(1) << 31, kMostMeshCells = uint64_t(1) << 29;

/// Cells as numbers of points. The cells are numbered by type: first the tetrahedra, then the pyramids, the wedges and the hexahedra.
struct MeshCells {
  std::array<std::vector<uint32_t>, kCellTypes> points;  ///< of all cells of a type, one after the other

  size_t size(CellType type) const { return points[size_t(type)].size() / shapeOf(type).points; }
  size_t size() const;
  /// The number of the first cell of a type.
  uint32_t first(CellType type) const;
  CellType typeOf(uint32_t cell) const;
  std::span<const uint32_t> pointsOf(uint32_t cell) const;
};

}  // namespace gxy

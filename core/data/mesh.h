// SPDX-License-Identifier: Apache-2.0
// Unstructured volumes: values at the points of a mesh of cells, or of its cells, stored per local partition.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/data/box.h"
#include "core/data/partitioning.h"
#include "core/data/shared_vector.h"

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

/// What cells of a type are called, for users: "tetrahedra".
const char* pluralOf(CellType type);

/// A face of a cell of a mesh. Every face of two cells has two of these.
using FaceId = uint32_t;
inline constexpr FaceId kNoFace = UINT32_MAX;
inline constexpr FaceId faceId(uint32_t cell, int face) { return cell << 3 | uint32_t(face); }
inline constexpr uint32_t cellOf(FaceId id) { return id >> 3; }
inline constexpr int faceOf(FaceId id) { return int(id & 7); }

/// A mesh may have one point or cell less than this.
inline constexpr uint64_t kMostMeshPoints = uint64_t(1) << 30, kMostMeshCells = uint64_t(1) << 29;

/// Cells as numbers of points. The cells are numbered by type: first the tetrahedra, then the pyramids, the wedges and the hexahedra.
template <class Numbers>
struct CellsByType {
  std::array<Numbers, kCellTypes> points;  ///< of all cells of a type, one after the other

  size_t size(CellType type) const { return points[size_t(type)].size() / shapeOf(type).points; }
  size_t size() const;
  /// The number of the first cell of a type.
  uint32_t first(CellType type) const;
  CellType typeOf(uint32_t cell) const;
  std::span<const uint32_t> pointsOf(uint32_t cell) const;
  /// The same cells, which must outlive the view.
  CellsByType<std::span<const uint32_t>> view() const {
    return {{points[0], points[1], points[2], points[3]}};
  }
};
using MeshCells = CellsByType<std::vector<uint32_t>>;
using SharedMeshCells = CellsByType<SharedVector<uint32_t>>;
using MeshCellsView = CellsByType<std::span<const uint32_t>>;

/// Arrays by type that do not change any more.
template <class T>
std::array<SharedVector<T>, kCellTypes> shared(std::array<std::vector<T>, kCellTypes> arrays) {
  std::array<SharedVector<T>, kCellTypes> all;
  for (size_t type = 0; type < kCellTypes; type++) all[type] = std::move(arrays[type]);
  return all;
}

/// The cells that touch one partition, with their points. Points and cells are numbered in an order of the whole mesh (meshBlock() in
/// mesh_blocks.h), of which each partition has a part. So of two points or cells the same one has the lower number in all partitions.
/// All but the values is shared with other fields and steps on the same points and cells.
struct MeshBlock {
  SharedVector<glm::dvec3> points;  ///< world coordinates
  std::vector<float> values;        ///< stored values, the components of a point together
  SharedMeshCells cells;            ///< the points of a tetrahedron ascend
  /// By type: for each face of each cell the face of the neighbour in this block, or kNoFace.
  std::array<SharedVector<FaceId>, kCellTypes> neighbours;
  SharedVector<FaceId> shell;  ///< the faces without a neighbour in this block that have an area, ascending
  /// If the data are those of cells (Mesh::ofCells): stored values by cell, the components of a cell together. `values` are then averages of
  /// them (averagesAtPoints() in point_averages.h). Else empty.
  std::vector<float> cellValues{};
};

/// What an import has found in a mesh. All counts are of the whole mesh.
struct MeshReport {
  std::array<uint64_t, kCellTypes> cells{};  ///< of each type
  uint64_t points = 0;
  uint64_t flatCells = 0;        ///< cells of lower dimension, which have no volume and are left out
  uint64_t ghostCells = 0;       ///< duplicate, refined or hidden cells, which are left out
  uint64_t repeatedCells = 0;    ///< cells with the same points as another one, which are left out
  uint64_t degenerateCells = 0;  ///< cells with a point twice that are no collapsed(), which are left out
  uint64_t unusableCells = 0;    ///< cells with a point whose coordinates are not finite, which are left out
  uint64_t mergedPoints = 0;     ///< points at exactly the same place as another one, which are taken as one
  uint64_t differingPoints =
      0;                      ///< of those, the points whose values differ; the first one's values are used
  uint64_t crowdedFaces = 0;  ///< faces of three or more cells; rays go from none of these to another
  /// Faces both of whose cells are on the same side, so that these overlap, or one of whose cells has no volume.
  uint64_t foldedFaces = 0;
  uint64_t invertedCells =
      0;  ///< cells whose faces run clockwise, seen from outside; pictures do not depend on it
  /// Points that lie in a face of cells which do not have them, within 1e-6 of its longest edge. Values may differ on both sides there.
  uint64_t hangingPoints = 0;
  uint64_t splitFaces = 0;  ///< triangles that are halves of a face of four points of other cells
  uint64_t noDataPoints =
      0;  ///< points with a NaN or infinite value; cells that have such a point are transparent
  uint64_t noDataCells = 0;  ///< of data of cells: those with a NaN or infinite value, which are transparent
  uint64_t differingCells =
      0;  ///< of data of cells: of repeated cells, those whose values differ; the lowest value is used
  bool operator==(const MeshReport&) const = default;
};

/// An unstructured volume. Values are shift + scale * stored (encodingOf()). It is immutable once complete; any thread may read it.
struct Mesh {
  std::string name;
  int components = 1;
  bool ofCells = false;  ///< whether the data are those of cells
  double shift = 0, scale = 1;
  /// Ranges of values (not stored values) over all points, or all cells: one for each component, then one for the magnitude if there are several.
  std::vector<Range> ranges;
  Box box;  ///< of all points that cells in the files have, world
  MeshReport report;
  std::map<int, MeshBlock> blocks;  ///< by local partition
};

/// Whether all cells of the whole mesh are tetrahedra; it depends on `report` alone.
bool hasOnlyTetrahedra(const Mesh& mesh);

/// Returns the side of a cube as large as the mesh's box divided by the number of its cells, in world units: the reference length of
/// opacities where a Vis gives none. It depends on `box` and `report` alone, so it is the same on all ranks. It is positive also if the
/// box is flat or empty.
double typicalLength(const Mesh& mesh);

/// Returns what is shown of values of several components each: one component, or the magnitude if none is named.
std::vector<float> shownValues(const std::vector<float>& values, int components,
                               std::optional<int> component);

/// Memory of the local blocks in bytes, that of arrays which other meshes share included.
int64_t bytesOf(const Mesh& mesh);
/// Of this, what their values take.
int64_t bytesOfValues(const Mesh& mesh);

}  // namespace gxy

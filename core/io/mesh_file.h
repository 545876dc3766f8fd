// SPDX-License-Identifier: Apache-2.0
// Reads unstructured volumes: cells with a volume, and values at their points or of the cells.
//
// .vtu .vts .vtr   VTK XML unstructured, structured (curvilinear) and rectilinear grids, any encoding
// .vtk             the same in VTK's legacy form
// .pvtu .pvts .pvtr .part   lists of such files
//
// Tetrahedra, pyramids, wedges, hexahedra and voxels are read. Cells of lower dimension are left out and counted. Structured
// and rectilinear grids are hexahedra between their points. An array vtkGhostType marks cells that are left out
// and counted, too, which are duplicate, refined and hidden ones, and hidden points, which have no data. If the values are those of cells,
// duplicates come along nevertheless, marked as such.
#pragma once
#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/data/mesh.h"
#include "core/data/mesh_kinds.h"
#include "core/data/scalar.h"
#include "core/io/geometry_file.h"
#include "core/io/left_out.h"

namespace gxy {

/// Whether a file is an unstructured, structured or rectilinear grid, or a list of such, if it is to be a volume: by its ending, and of
/// .vtk by its DATASET line.
bool isMeshFile(const std::string& path);

/// What is wanted of a file.
struct MeshWanted {
  std::string array;            ///< empty: the active scalars, or else the first (chooseValues())
  std::optional<bool> ofCells;  ///< absent: an array of points or else of cells
  int part = 0,
      of = 1;  ///< the cells are cut into `of` runs of about equal length; only those of one are kept
};

/// Cells of a file with the points that they have.
struct MeshContent {
  std::string array;     ///< that gave the values; empty if the file has no points
  bool ofCells = false;  ///< whether it is one of cells
  ScalarType type = ScalarType::Float32;
  int components = 1;
  std::vector<glm::dvec3> points;
  std::vector<double> values;     ///< of points, the components of a point together; NaN at hidden points
  std::vector<uint64_t> numbers;  ///< of points in the file
  MeshCells cells;
  std::array<std::vector<double>, kCellTypes>
      cellValues;  ///< by type, the components of a cell together; NaN of cells with a hidden point
  std::array<std::vector<uint8_t>, kCellTypes> duplicates;    ///< as in MeshPiece
  CellKinds kinds;                                            ///< of all cells of the file that are no ghosts
  uint64_t pointsOfFile = 0;                                  ///< whether cells have them or not
  uint64_t flatCells = 0, ghostCells = 0, unusableCells = 0;  ///< as in MeshReport, of the part
  LeftOut leftOut;
  std::vector<std::string> warnings;  ///< about flaws that do not prevent showing it, each with the path
};

/// Reads one file that is not a list. `toTake`, if not empty, is called with the bytes of the file's arrays, then with those of the
/// result. Throws Error for a file that is missing or malformed, has other cells with a volume, or has no such array.
MeshContent readMesh(const std::string& path, const MeshWanted& wanted, const TakeMemory& toTake = {});

}  // namespace gxy

// SPDX-License-Identifier: Apache-2.0
// Reads unstructured volumes: cells with a volume and values at their points.
//
// .vtu .vts .vtr   VTK XML unstructured, structured (curvilinear) and rectilinear grids, any encoding
// .vtk             the same in VTK's legacy form
// .pvtu .pvts .pvtr .part   lists of such files
//
// Tetrahedra, pyramids, wedges, hexahedra and voxels are read. Cells of lower dimension are left out and counted. Structured
// and rectilinear grids are hexahedra between their points. An array vtkGhostType marks cells that are left out
// and counted, too, which are duplicate, refined and hidden ones, and hidden points, which have no data.
#pragma once
#include <cstdint>
#include <glm/vec3.hpp>
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
  std::string array;  ///< of points; empty: the active scalars, or else the first (chooseValues())
  int part = 0,
      of = 1;  ///< the cells are cut into `of` runs of about equal length; only those of one are kept
};

/// Cells of a file with the points that they have.
struct MeshContent {
  std::string array;  ///< that gave the values; empty if the file has no points
  ScalarType type = ScalarType::Float32;
  int components = 1;
  std::vector<glm::dvec3> points;
  std::vector<double> values;     ///< the components of a point together; NaN at hidden points
  std::vector<uint64_t> numbers;  ///< of points in the file
  MeshCells cells;
  CellKinds kinds;                                            ///< of all cells of the file that are no ghosts
  uint64_t pointsOfFile = 0;                                  ///< whether cells have them or not
  uint64_t flatCells = 0, ghostCells = 0, unusableCells = 0;  ///< as in MeshReport, of the part
  LeftOut leftOut;
  std::vector<std::string> warnings;  ///< about flaws that do not prevent showing it, each with the path
};

/// Reads one file that is not a list. `toTake`, if not empty, is called with the bytes of the file's arrays, then with those of the
/// result. Throws Error for a file that is missing or malformed, has other cells with a volume, or has no such array of points.
MeshContent readMesh(const std::string& path, const MeshWanted& wanted, const TakeMemory& toTake = {});

}  // namespace gxy

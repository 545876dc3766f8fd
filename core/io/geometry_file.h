// SPDX-License-Identifier: Apache-2.0
// Reads geometry files: particles, path lines and triangles.
//
// .vtu .vtp .vts .vtr   VTK XML unstructured grids, polygonal data, structured and rectilinear grids, any encoding
// .vtk                  the same in VTK's legacy form
// .ply .stl .obj .off   triangle meshes
// .csv .xyz             points as lines of text, and atoms
// .pvtu .pvtp .pvts .pvtr .part   lists of such files (part_document.h)
//
// - Particles are all points of a file.
// - Path lines are its lines and polylines, with one segment for each pair of points.
// - Triangles are its triangles, strips, quads and polygons (core/data/polygon.h), flat cells of second order, cut
//   between all of their points, and the outer surface of solid cells (tetrahedra, hexahedra, wedges, pyramids,
//   prisms, also of second order): the faces that belong to one cell only.
//
// Other cells are not used. An array vtkGhostType marks further cells and points that are not used: duplicate,
// refined and hidden cells, cells of hidden points, and, as particles, duplicate and hidden points.
//
// If the values are those of cells, each cell gets points of its own that all have its value, so it has one
// colour. A particle has the value of the first vertex cell that it is in, or NaN. An array of colours
// (values_choice.h) becomes colours in the same way.
#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/data/geometry.h"
#include "core/io/left_out.h"
#include "core/io/values_choice.h"

namespace gxy {

/// Called with the number of bytes before memory is allocated. It may refuse them by throwing Error.
using TakeMemory = std::function<void(int64_t bytes)>;

/// The content of one file, including unusable primitives. Ids are the numbers of primitives in file
/// order from 0 on.
struct GeometryContent {
  GeometryBlock block;
  std::string array;         ///< the file's array that became the values or colours; empty if there is none
  bool ofCells = false;      ///< that array is one of cells
  uint64_t unusedCells = 0;  ///< number of cells of other kinds
  LeftOut leftOut;           ///< arrays of VTK XML files that were not needed and not read
  std::vector<std::string> warnings;  ///< about flaws that do not prevent showing it, each with the path
};

/// Returns the files that contain the data: those that a .pvtu, .pvtp, .pvts, .pvtr or .part
/// lists, or the file itself.
/// Throws Error for a list that is missing or malformed, or for an extension that is not listed above.
std::vector<std::string> geometryPieces(const std::string& path);

/// Returns the files that the <Piece> elements of a VTK XML file of this type ("PUnstructuredGrid") name,
/// as paths to open.
std::vector<std::string> xmlPieces(const std::string& path, const char* type);

/// Returns the values that all pieces of a list have, as the list declares their arrays; nothing if it
/// declares none. `ofCells`: as in ValuesWanted.
std::optional<ValuesWanted> valuesOfList(const std::string& path, std::optional<bool> ofCells = {});

/// Reads one file that is not a list. Several components of `values` become their magnitude, unless they are
/// colours. Normals are the point array "Normals" or "Normals_", or the active normals. `values.fields` name arrays of points that
/// become fields; a file with points must have all of them. `toTake`, if not
/// empty, is called with the bytes of the file's arrays, then with those of the result. Throws Error for a
/// file that is missing or malformed, or has no such array.
GeometryContent readGeometry(const std::string& path, GeometryKind kind, const ValuesWanted& values = {},
                             const TakeMemory& toTake = {});

/// A summary of a file for users: kinds and numbers of cells, and arrays with their ranges.
struct GeometrySummary {
  uint64_t points = 0, vertices = 0, segments = 0, triangles = 0, others = 0;
  uint64_t solids = 0;            ///< cells whose outer surface is shown
  std::map<int, uint64_t> kinds;  ///< all cells, ghosts too: CellKinds of mesh_kinds.h
  Box box;                        ///< bounding box of the finite points
  struct Array {
    std::string name;
    std::string type;
    int components = 1;
    bool colors = false;  ///< isColors()
    Range range;          ///< of the value, of the magnitude of several components, or of colour components
    uint64_t notFinite = 0;
    bool ofCells = false;
  };
  std::vector<Array> arrays;
};
/// Summarises one file that is not a list. `toTake`, if not empty, is called with the bytes of the file's arrays.
GeometrySummary summariseGeometry(const std::string& path, const TakeMemory& toTake = {});

/// Returns Triangles if the file has triangles or solid cells, else PathLines if it has lines, else Particles.
GeometryKind likelyKind(const GeometrySummary& summary);

}  // namespace gxy

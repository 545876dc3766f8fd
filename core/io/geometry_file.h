// SPDX-License-Identifier: Apache-2.0
// Geometry files: particles, path lines and triangles.
//
// .vtu .vtp          VTK XML unstructured grids and polygonal data, any encoding
// .vtk               the same in VTK's legacy form
// .ply .stl .obj .off   triangle meshes
// .csv .xyz          points as lines of text, and atoms
// .pvtu .pvtp .part  lists of such files (part_document.h)
//
// Particles are all points of a file; path lines its lines and polylines, one segment for each pair of points; triangles its
// triangles, strips, quads and polygons (data/polygon.h), flat cells of second order between all of their points, and of solid
// cells (tetrahedra, hexahedra, wedges, pyramids, prisms, also of second order) the outer surface: faces that no other cell has.
// Other cells are not used, nor are cells and points that an array vtkGhostType marks: duplicate, refined and hidden cells, cells
// of hidden points; duplicate and hidden points as particles.
//
// Values of cells: each cell gets points of its own that all have its value, so that it is of one colour. A particle has the value
// of the first vertex cell that it is in, or NaN. An array of colours (values_choice.h) becomes colours, in the same way.
#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/data/geometry.h"
#include "core/io/left_out.h"
#include "core/io/values_choice.h"

namespace gxy {

/// Told bytes of memory before they are allocated; may refuse them by an Error.
using TakeMemory = std::function<void(int64_t bytes)>;

/// What was read from one file, unusable primitives included. Ids are primitive numbers in file order from 0
/// on.
struct GeometryContent {
  GeometryBlock block;
  std::string array;         ///< of the file, that became the values or colours; empty if it has none
  bool ofCells = false;      ///< that array
  uint64_t unusedCells = 0;  ///< of other kinds
  LeftOut leftOut;           ///< arrays that .vtp and .vtu files hold and this is not made of: not read
  std::vector<std::string>
      warnings;  ///< of flaws that do not keep the file from being shown, each with the path
};

/// The files that hold the data: those that a .pvtu, .pvtp or .part lists, else the file itself. Throws Error
/// for a list that is missing or malformed, or an extension that is not listed above.
std::vector<std::string> geometryPieces(const std::string& path);

/// The files that the <Piece> elements of a VTK XML file of this type ("PUnstructuredGrid") name, as they will be opened.
std::vector<std::string> xmlPieces(const std::string& path, const char* type);

/// The values that all pieces of a list are to have, as the list declares their arrays; none where it does not.
std::optional<ValuesWanted> valuesOfList(const std::string& path);

/// Reads one file that is not a list. Several components of `values` become their magnitude, unless they are colours. Normals are the
/// point array "Normals" or "Normals_", or the active normals. Throws Error for a file that is missing or
/// malformed or has no such array. `toTake`, if any, is told what the file's arrays take, then what the result takes.
GeometryContent readGeometry(const std::string& path, GeometryKind kind, const ValuesWanted& values = {},
                             const TakeMemory& toTake = {});

/// What a file holds, for people: kinds and numbers of cells, arrays with their ranges.
struct GeometrySummary {
  uint64_t points = 0, vertices = 0, segments = 0, triangles = 0, others = 0;
  uint64_t solids = 0;  ///< cells whose outer surface is shown
  Box box;              ///< of finite points
  struct Array {
    std::string name;
    std::string type;
    int components = 1;
    bool colors = false;  ///< isColors()
    Range range;          ///< of the magnitude for several components; of colours, of these
    uint64_t notFinite = 0;
    bool ofCells = false;
  };
  std::vector<Array> arrays;
};
/// `toTake`, if any, is told what the file's arrays take.
GeometrySummary summariseGeometry(const std::string& path, const TakeMemory& toTake = {});

/// Triangles if the file has any, or solid cells, else path lines, else particles.
GeometryKind likelyKind(const GeometrySummary& summary);

}  // namespace gxy

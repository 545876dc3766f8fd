// SPDX-License-Identifier: Apache-2.0
// Writes geometry files.
#pragma once
#include <string>
#include <vector>

#include "core/data/gather_mesh.h"
#include "core/data/geometry.h"

namespace gxy {

/// Writes the primitives of a block in the format of the path's extension. .vtp and .vtu: all kinds, double
/// coordinates, nothing is lost. .ply: triangles, double coordinates, values as the property "value". .stl:
/// triangles, float coordinates only. .csv: particles, a line of text each. Values become the point array `array`. Fields become
/// point arrays of their names: all components, and in a .csv and a .ply a column or property for each, NAME:0, NAME:1. Names of
/// properties have _ for what else separates words there. A field of one component with the name `array` is left out, as the values are it. Colours become the array "RGB",
/// or red, green and blue in a .ply. Colours are written as unsigned char if all colours of the block are
/// such numbers (of `whole`, if the block is a piece of it), and otherwise as float. Segments that continue
/// each other become one polyline. Throws Error if the file cannot be written.
void writeGeometry(const std::string& path, const GeometryBlock& block, GeometryKind kind,
                   const std::string& array = "data", const GeometryBlock* whole = nullptr);

/// Writes a .vtu of a whole mesh: double coordinates, and values of points, or of cells if `ofCells`, as array `array` of `type` with `components`.
/// Throws Error if the file cannot be written.
void writeMesh(const std::string& path, const GatheredMesh& mesh, const std::string& array, ScalarType type,
               int components, bool ofCells);

/// Copies all points, cells and arrays of one file that readGeometry() can read, in their own types, to a
/// .vtp or .vtu. Flaws that do not prevent reading are logged. Returns false, and writes nothing, if `to` has
/// another extension, `from` is a list of pieces, or `to` is a .vtp and there are cells other than vertices,
/// lines, polygons and strips. Throws Error if a file cannot be read or written.
bool copyGeometry(const std::string& from, const std::string& to);

/// haveBytes(): whether all components of colours are multiples of 1/255, so that files can have them in
/// bytes. byteOf() converts a component to such a byte.
bool haveBytes(const std::vector<glm::vec3>& colors);
uint8_t byteOf(float component);

/// A piece of a .part, .pvtu or .pvtp, written by writeGeometry(). Its name is relative to the list.
struct GeometryPiece {
  Box extent;
  std::string file;
};
/// Writes the list of such pieces. The pieces have the same arrays as `like`.
void writeGeometryPieces(const std::string& path, const std::vector<GeometryPiece>& pieces,
                         const GeometryBlock& like, const std::string& array = "data");

/// The writers of single formats. `bytes`: colours are written as unsigned char.
void writeVtp(const std::string& path, const GeometryBlock& block, GeometryKind kind,
              const std::string& array, bool bytes);
void writeVtu(const std::string& path, const GeometryBlock& block, GeometryKind kind,
              const std::string& array, bool bytes);
void writeCsv(const std::string& path, const GeometryBlock& block, const std::string& array);
void writePly(const std::string& path, const GeometryBlock& block);
void writeStl(const std::string& path, const GeometryBlock& block);

}  // namespace gxy

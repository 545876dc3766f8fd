// SPDX-License-Identifier: Apache-2.0
// Geometry to files.
#pragma once
#include <string>
#include <vector>

#include "core/data/geometry.h"

namespace gxy {

/// Writes the primitives of a block by extension: .vtp and .vtu (all kinds, double coordinates, nothing is
/// lost), .ply (triangles; double coordinates, values as the property "value"), .stl (triangles; float
/// coordinates only). Values become the point array `array`, colours "RGB" (of .ply red, green and blue): of unsigned char
/// if all of the block, or of the whole that it is a piece of, are such numbers, else of float. Segments that continue each
/// other become one polyline.
void writeGeometry(const std::string& path, const GeometryBlock& block, GeometryKind kind,
                   const std::string& array = "data", const GeometryBlock* whole = nullptr);

/// Writes all points, cells and arrays of one file that readGeometry() can read, in their own types, to a .vtp or .vtu. Flaws that
/// do not keep it from being read are logged. Returns false, with nothing written, if `to` cannot hold them: for other
/// extensions, for lists of pieces, and for a .vtp of cells other than vertices, lines, polygons and strips. Throws Error
/// for what cannot be read or written.
bool copyGeometry(const std::string& from, const std::string& to);

/// Whether all colours are 255ths as files have them in bytes, and a component as such a byte.
bool haveBytes(const std::vector<glm::vec3>& colors);
uint8_t byteOf(float component);

/// A piece of a .part, .pvtu or .pvtp, written by writeGeometry(); its name is relative to the list.
struct GeometryPiece {
  Box extent;
  std::string file;
};
/// The list of such pieces; `like` tells which arrays they have.
void writeGeometryPieces(const std::string& path, const std::vector<GeometryPiece>& pieces,
                         const GeometryBlock& like, const std::string& array = "data");

/// The .ply and .stl writers.
void writePly(const std::string& path, const GeometryBlock& block);
void writeStl(const std::string& path, const GeometryBlock& block);

}  // namespace gxy

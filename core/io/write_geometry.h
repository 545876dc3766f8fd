// SPDX-License-Identifier: Apache-2.0
// Geometry to files.
#pragma once
#include <string>
#include <vector>

#include "gxy/data/geometry.h"

namespace gxy {

/// Writes the primitives of a block by extension: .vtp and .vtu (all kinds, double coordinates, nothing is
/// lost), .ply (triangles; double coordinates, values as the property "value"), .stl (triangles; float
/// coordinates only). Values become the point array `array`. Segments that continue each other become one
/// polyline.
void writeGeometry(const std::string& path, const GeometryBlock& block, GeometryKind kind,
                   const std::string& array = "data");

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

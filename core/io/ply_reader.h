// SPDX-License-Identifier: Apache-2.0
// Reads PLY 1.0 meshes: ascii, binary_little_endian and binary_big_endian. Used inside core/io only.
#pragma once
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <string>
#include <string_view>

#include "core/io/flaws.h"

namespace gxy {

/// Reads the points of element `vertex`, and, if they exist, the polygons of element `face` and the triangle
/// strips of element `tristrips` (-1 ends a strip), from the bytes of a file. Other elements are ignored.
///
/// Properties of a vertex: x, y and z are the point; nx, ny and nz become the normals "Normals"; u, v (or
/// texture_u, texture_v, or s, t) become the texture coordinates "TCoords". red, green, blue and optionally
/// alpha (also diffuse_red and so on, or r, g, b and a), all of one type, become the active scalars "RGB",
/// from 0 to 1. Each other scalar property becomes an array of its name. Of faces only colours are read, and
/// only if there are no strips; `flaws` gets the others.
///
/// Throws Error, which begins with `path`, for bytes that are not such a file, that end too early, or whose
/// faces refer to points that do not exist. Memory is in proportion to the number of bytes, whatever sizes
/// the file states.
vtkSmartPointer<vtkPolyData> readPly(std::string_view bytes, const std::string& path, Flaws& flaws);

}  // namespace gxy

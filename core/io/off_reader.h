// SPDX-License-Identifier: Apache-2.0
// Reads meshes in Geomview's Object File Format. Used inside core/io only.
#pragma once
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <string>
#include <string_view>

#include "core/io/flaws.h"

namespace gxy {

/// Reads the vertices and polygons from a file's bytes. The file begins with the keyword "OFF", which may be
/// missing, after the letters ST, C and N if vertices have texture coordinates, colours and normals. Then
/// come the numbers of vertices, faces and edges, a line for each vertex, and a line for each face. '#'
/// begins a comment.
///
/// Normals of vertices become "Normals" and their colours the active scalars "RGB" of points. If any face has
/// three or four numbers after its corners, these become the active scalars "RGB" of cells, NaN for faces
/// without them. Colours are from 0 to 1, or from 0 to 255 if one is 2 or more. `flaws` gets faces with fewer
/// than 3 corners, which are left out, and other numbers after the corners, which are ignored. Throws Error,
/// which begins with `path`, for other variants of the format (binary, 4 or n dimensions), malformed lines,
/// and vertices that do not exist.
vtkSmartPointer<vtkPolyData> readOff(std::string_view bytes, const std::string& path, Flaws& flaws);

}  // namespace gxy

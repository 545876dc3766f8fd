// SPDX-License-Identifier: Apache-2.0
// Meshes in Geomview's Object File Format. Used inside core/io only.
#pragma once
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <string>
#include <string_view>

#include "core/io/flaws.h"

namespace gxy {

/// The vertices and polygons of a file's bytes: "OFF", which may be missing, before it ST, C and N for texture coordinates, colours
/// and normals of vertices; the numbers of vertices, faces and edges; a line for each vertex, with "Normals" if it has them; a line
/// for each face. '#' begins a comment. Colours of vertices are the active scalars "RGB", and those of faces, where any has three
/// or four numbers after its corners, those of cells; 0 to 1 (or 0 to 255, if one is 2 or more), NaN where a face has none. `flaws`
/// is told of faces of fewer than 3 corners, which are left out, and of other numbers there, which are passed over. Throws Error, which begins with `path`, for other forms of the format (binary, of 4 or n dimensions),
/// malformed lines, and vertices that do not exist.
vtkSmartPointer<vtkPolyData> readOff(std::string_view bytes, const std::string& path, Flaws& flaws);

}  // namespace gxy

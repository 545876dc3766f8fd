// SPDX-License-Identifier: Apache-2.0
// Wavefront OBJ meshes. Used inside core/io only.
#pragma once
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <string>
#include <string_view>

#include "core/io/flaws.h"

namespace gxy {

/// The vertices `v`, polygons `f`, lines `l` and points `p` of a file's bytes; groups, materials and other
/// statements are passed over. Corners are "v", "v/t", "v//n" or "v/t/n", counted from 1 on or, if negative,
/// back from the last one so far. A vertex that polygons use with several normals or texture coordinates
/// becomes as many points, the copies after all vertices. If every corner of a polygon has a normal, the
/// points have normals "Normals" (that of a vertex no polygon uses is arbitrary); if every one has texture
/// coordinates, "TCoords".
/// Three numbers after a vertex's coordinates are its red, green and blue, 0 to 1 (or 0 to 255, if one is 2 or more), and a fourth its
/// opacity: the active scalars "RGB", NaN where a vertex has none.
/// Lines may end with "\n", "\r\n" or "\r", and a byte-order mark may come first. `flaws` is told of normals and texture
/// coordinates that do not exist, corners that end with '/', and cells of too few corners, which are left out. Throws Error, which
/// begins with `path`, for malformed statements and vertices that do not exist.
vtkSmartPointer<vtkPolyData> readObj(std::string_view bytes, const std::string& path, Flaws& flaws);

}  // namespace gxy

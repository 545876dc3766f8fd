// SPDX-License-Identifier: Apache-2.0
// Reads Wavefront OBJ meshes. Used inside core/io only.
#pragma once
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <string>
#include <string_view>

#include "core/io/flaws.h"

namespace gxy {

/// Reads the vertices `v`, polygons `f`, lines `l` and points `p` from a file's bytes. Groups, materials and
/// other statements are ignored. Corners are "v", "v/t", "v//n" or "v/t/n". Their numbers count from 1 on,
/// or, if negative, back from the last one so far. Lines may end with "\n", "\r\n" or "\r", and the text may
/// begin with a byte-order mark.
///
/// A vertex that polygons use with several normals or texture coordinates becomes as many points; the
/// copies come after all vertices. If every corner of polygons has a normal, the points have normals
/// "Normals"; the normal of a vertex that no polygon uses is arbitrary. If every corner has texture
/// coordinates, the points have "TCoords". Three numbers after a vertex's coordinates are red, green and
/// blue, from 0 to 1, or from 0 to 255 if one is 2 or more; a fourth is opacity. They become the active
/// scalars "RGB", NaN for vertices without them.
///
/// `flaws` gets normals and texture coordinates that do not exist, corners that end with '/', and cells with
/// too few corners, which are left out. Throws Error, which begins with `path`, for malformed statements and
/// vertices that do not exist.
vtkSmartPointer<vtkPolyData> readObj(std::string_view bytes, const std::string& path, Flaws& flaws);

}  // namespace gxy

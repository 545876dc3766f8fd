// SPDX-License-Identifier: Apache-2.0
// PLY 1.0 meshes: ascii, binary_little_endian and binary_big_endian. Used inside core/io only.
#pragma once
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <string>
#include <string_view>

#include "core/io/flaws.h"

namespace gxy {

/// The points of element `vertex`, the polygons of element `face` and the strips of triangles of element `tristrips` (-1 ends one),
/// if there are any, from the bytes of a file; every other element is passed over. x, y and z become the points; nx, ny, nz the normals "Normals";
/// u, v (or texture_u, texture_v, or s, t) the texture coordinates "TCoords"; red, green, blue and alpha, if there is one (also
/// diffuse_red and so on, or r, g, b and a), all of one type, the active scalars "RGB", from 0 to 1; each other scalar property an
/// array of its own name. Of faces colours alone are read, and only where there are no strips: `flaws` is told of others. Throws
/// Error, which begins with `path`, for bytes that are not such a file, that end too early, or whose faces refer to points that do not
/// exist; what it allocates is in proportion to the number of bytes, whatever they say.
vtkSmartPointer<vtkPolyData> readPly(std::string_view bytes, const std::string& path, Flaws& flaws);

}  // namespace gxy

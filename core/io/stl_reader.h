// SPDX-License-Identifier: Apache-2.0
// Reads STL meshes, binary and ascii. Used inside core/io only.
#pragma once
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <string>
#include <string_view>

#include "core/io/flaws.h"

namespace gxy {

/// Reads the facets from a file's bytes, in file order, each with three points of its own. Stored normals and
/// attributes are not used. The file is binary if it has the number of facets that it states, or states 0;
/// otherwise it is ascii if it begins with "solid". `flaws` gets bytes after the last facet, a stated number
/// of 0 with facets after it, normals that are not numbers, and an end without "endsolid". Throws Error,
/// which begins with `path`, if the file is neither.
vtkSmartPointer<vtkPolyData> readStl(std::string_view bytes, const std::string& path, Flaws& flaws);

}  // namespace gxy

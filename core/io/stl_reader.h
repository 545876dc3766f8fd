// SPDX-License-Identifier: Apache-2.0
// STL meshes, binary and ascii. Used inside core/io only.
#pragma once
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <string>
#include <string_view>

#include "core/io/flaws.h"

namespace gxy {

/// The facets of a file's bytes in file order, each with three points of its own; stored normals and attributes are not used. The
/// file is binary if it has the number of facets that it states (or states none), else ascii if it begins with "solid". `flaws` is
/// told of bytes after the last facet, a number of 0 with facets after it, normals that are no numbers, and an end without
/// "endsolid". Throws Error, which begins with `path`, when it is neither.
vtkSmartPointer<vtkPolyData> readStl(std::string_view bytes, const std::string& path, Flaws& flaws);

}  // namespace gxy

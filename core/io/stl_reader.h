// SPDX-License-Identifier: Apache-2.0
// STL meshes, binary and ascii. Used inside core/io only.
#pragma once
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <string>
#include <string_view>

namespace gxy {

/// The facets of a file's bytes in file order, each with three points of its own; stored normals and
/// attributes are not used. The file is binary if its size is that of the number of facets it states, else
/// ascii if it begins with "solid". Throws Error, which begins with `path`, when it is neither.
vtkSmartPointer<vtkPolyData> readStl(std::string_view bytes, const std::string& path);

}  // namespace gxy

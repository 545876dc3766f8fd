// SPDX-License-Identifier: Apache-2.0
// Geometry files as VTK datasets. Used inside core/io only, by files that see VTK.
#pragma once
#include <vtkPointSet.h>
#include <vtkSmartPointer.h>

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "gxy/io/geometry_file.h"

namespace gxy {

/// Point arrays that geometry is made of, as readGeometry() chooses them.
struct ArraysNeeded {
  std::string values;  ///< the array that becomes the values; if the file has none of that name, all are read
  bool normals = true;
};

/// Whether an array of three components of this name holds normals.
bool isNameOfNormals(std::string_view name);

/// Reads a .vtu .vtp .vtk .ply .stl or .obj file as polygonal data or an unstructured grid whose cells refer
/// to its points and whose arrays have one entry per point or cell; Error, with VTK's own words if it has
/// some, when it cannot. `toTake`, if any, is told once, before anything is allocated, how many bytes this takes: in the
/// XML forms those of the arrays that are read as the file states them, else those of the file. It may refuse them by an
/// Error. Of .vtp and .vtu files only `needed`, if given, and ghosts are read, and `leftOut` is told of the others.
vtkSmartPointer<vtkPointSet> readPointSet(const std::string& path, const TakeMemory& toTake = {},
                                          const std::optional<ArraysNeeded>& needed = {},
                                          LeftOut* leftOut = nullptr);

}  // namespace gxy

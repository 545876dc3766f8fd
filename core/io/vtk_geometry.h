// SPDX-License-Identifier: Apache-2.0
// Geometry files as VTK datasets. Used inside core/io only, by files that see VTK.
#pragma once
#include <vtkPointSet.h>
#include <vtkSmartPointer.h>

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/io/flaws.h"
#include "core/io/geometry_file.h"

namespace gxy {

/// Point arrays that geometry is made of, as readGeometry() chooses them.
struct ArraysNeeded {
  ValuesWanted values;  ///< if it must be there, but is not, all are read
  bool normals = true;
};

/// Reads a .vtu .vtp .vts .vtr .vtk .ply .stl .obj .off .csv or .xyz file as polygonal data, an unstructured grid or a structured one (also where
/// it is rectilinear) whose cells refer to its points and whose arrays have one entry per point or cell; Error, with VTK's own words if it has
/// some, when it cannot. `toTake`, if any, is told once, before anything is allocated, how many bytes this takes: in the
/// XML forms those of the arrays that are read as the file states them, else those of the file. It may refuse them by an
/// Error. Of XML files only `needed`, if given, and ghosts are read, and `leftOut` is told of the others. `flaws`, if any, is told
/// of what does not keep the file from being read.
vtkSmartPointer<vtkPointSet> readPointSet(const std::string& path, const TakeMemory& toTake = {},
                                          const std::optional<ArraysNeeded>& needed = {},
                                          LeftOut* leftOut = nullptr, Flaws* flaws = nullptr);

}  // namespace gxy

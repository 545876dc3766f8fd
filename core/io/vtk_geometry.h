// SPDX-License-Identifier: Apache-2.0
// Reads geometry files as VTK datasets. Used inside core/io only, by files that include VTK.
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

/// The arrays that geometry is made of, as readGeometry() chooses them.
struct ArraysNeeded {
  ValuesWanted values;  ///< if a required array is missing, all arrays are read
  bool normals = true;
};

/// Reads a .vtu .vtp .vts .vtr .vtk .ply .stl .obj .off .csv or .xyz file as polygonal data, an unstructured
/// grid or a structured grid (a rectilinear grid becomes one). It is checked that cells refer to existing
/// points and that arrays have one entry per point or cell.
///
/// `toTake`, if not empty, is called before memory is allocated: for VTK's XML formats with the bytes of the
/// arrays that are read, as the file states them, otherwise with the size of the file. It may refuse them by
/// throwing Error. Of XML files only the `needed` arrays, if given, and ghost arrays are read; the others are
/// added to `leftOut`. `flaws`, if not null, gets flaws that do not prevent reading. Throws Error, with VTK's
/// message if there is one, if the file cannot be read.
vtkSmartPointer<vtkPointSet> readPointSet(const std::string& path, const TakeMemory& toTake = {},
                                          const std::optional<ArraysNeeded>& needed = {},
                                          LeftOut* leftOut = nullptr, Flaws* flaws = nullptr);

}  // namespace gxy

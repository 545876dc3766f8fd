// SPDX-License-Identifier: Apache-2.0
// Geometry files as VTK datasets. Used inside core/io only, by files that see VTK.
#pragma once
#include <vtkPointSet.h>
#include <vtkSmartPointer.h>

#include <string>
#include <vector>

namespace gxy {

/// Reads a .vtu .vtp .vtk .ply .stl or .obj file as polygonal data or an unstructured grid whose cells refer
/// to its points and whose arrays have one entry per point or cell; Error, with VTK's own words if it has
/// some, when it cannot.
vtkSmartPointer<vtkPointSet> readPointSet(const std::string& path);

/// The files that the <Piece> elements of a VTK XML file of this type ("PUnstructuredGrid") name, as they will be opened.
std::vector<std::string> xmlPieces(const std::string& path, const char* type);

}  // namespace gxy

// SPDX-License-Identifier: Apache-2.0
// What legacy .vtk files hold, and what must hold in them before VTK's reader, which trusts them, may see them. Used inside
// core/io only. Keywords of the format have no case.
#pragma once
#include <string>
#include <string_view>

namespace gxy {

/// The type that the DATASET line of a file names, in upper case; empty if these are not the first bytes of a legacy VTK file.
std::string legacyDatasetType(std::string_view head);

/// Walks through a file with DATASET POLYDATA, UNSTRUCTURED_GRID, STRUCTURED_GRID or RECTILINEAR_GRID up to its first POINT_DATA or CELL_DATA,
/// and blanks out each METADATA block in `bytes`, as no use is made of them. Throws Error, which begins with
/// `path`, unless every keyword is known, every array is all there, cells have sizes that add up, and there
/// are as many cell types as cells. Polyhedra are not allowed. Point ids are left unchecked.
void checkLegacyVtk(std::string& bytes, const std::string& path);

}  // namespace gxy

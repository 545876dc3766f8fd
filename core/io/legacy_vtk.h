// SPDX-License-Identifier: Apache-2.0
// Checks legacy .vtk files before VTK reads them, because VTK's reader trusts their content. Used inside
// core/io only. Keywords of the format are not case-sensitive.
#pragma once
#include <string>
#include <string_view>

namespace gxy {

/// Returns the type in the DATASET line of a file, in upper case; empty if `head` is not the beginning of a
/// legacy VTK file.
std::string legacyDatasetType(std::string_view head);

/// Checks a file with DATASET POLYDATA, UNSTRUCTURED_GRID, STRUCTURED_GRID or RECTILINEAR_GRID up to its first
/// POINT_DATA or CELL_DATA. Replaces METADATA blocks in `bytes` by blanks, since they are not used. Throws
/// Error, which begins with `path`, unless every keyword is known, every array is complete, the sizes of cells
/// add up, and there are as many cell types as cells. Polyhedra are not allowed. Point ids are not checked.
void checkLegacyVtk(std::string& bytes, const std::string& path);

}  // namespace gxy

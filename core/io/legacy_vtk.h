// SPDX-License-Identifier: Apache-2.0
// What must hold in a legacy .vtk file before VTK's reader, which trusts it, may see it. Used inside core/io
// only.
#pragma once
#include <string>

namespace gxy {

/// Walks through a file with DATASET POLYDATA or UNSTRUCTURED_GRID up to its first POINT_DATA or CELL_DATA,
/// and blanks out each METADATA block in `bytes`, as no use is made of them. Throws Error, which begins with
/// `path`, unless every keyword is known, every array is all there, cells have sizes that add up, and there
/// are as many cell types as cells. Polyhedra are not allowed. Point ids are left unchecked.
void checkLegacyVtk(std::string& bytes, const std::string& path);

}  // namespace gxy

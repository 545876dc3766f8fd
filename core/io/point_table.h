// SPDX-License-Identifier: Apache-2.0
// Reads points from lines of text: tables (.csv), and point clouds or atoms (.xyz). Used inside core/io only.
#pragma once
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <string>
#include <string_view>

#include "core/io/flaws.h"

namespace gxy {

/// Reads a table. The first line shows whether commas, semicolons or tabs separate fields. A field may be in
/// quotes; an empty field is NaN. If the first line has names, the coordinates are the columns "x", "y" and
/// "z" in any letter case, or "Points:0" to "Points:2"; "z" may be missing and then is 0. Otherwise they are
/// the first three columns.
///
/// Other columns of numbers become arrays. Neighbouring columns "name:0", "name:1", ... become one array
/// "name". Columns "red", "green" and "blue", or "r", "g" and "b", in any letter case, with "alpha" or "a" if
/// it exists, become the array "RGB"; they are from 0 to 1, or from 0 to 255 if one is 2 or more. `flaws`
/// gets columns with other text, which are ignored. Throws Error, which begins with `path`, for tables
/// without coordinates and lines with another number of fields.
vtkSmartPointer<vtkPolyData> readCsv(std::string_view bytes, const std::string& path, Flaws& flaws);

/// Reads a point cloud: lines "x y z" with optional further numbers, which become arrays "value 1" and so on;
/// '#' begins a comment. If the first line is a single number, reads that many atoms "symbol x y z" after a
/// comment line; the atomic number becomes the array "element". `flaws` gets lines after the atoms, which are
/// ignored. Throws Error, which begins with `path`, for other lines.
vtkSmartPointer<vtkPolyData> readXyz(std::string_view bytes, const std::string& path, Flaws& flaws);

}  // namespace gxy

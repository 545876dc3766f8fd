// SPDX-License-Identifier: Apache-2.0
// Points as lines of text: tables (.csv) and point clouds or atoms (.xyz). Used inside core/io only.
#pragma once
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <string>
#include <string_view>

#include "core/io/flaws.h"

namespace gxy {

/// A table whose fields are separated by commas, semicolons or tabs, as its first line shows; a field may stand in quotes. Where
/// the first line holds names, "x", "y" and "z" in any case or "Points:0" to "Points:2" are the coordinates ("z" may be missing:
/// 0), else the first three columns. The other columns of numbers are arrays; "name:0", "name:1", ... beside each other become one array "name".
/// Columns "red", "green" and "blue", or "r", "g" and "b", in any case, and "alpha" or "a", become the array "RGB": 0 to 1, or 0 to 255
/// if one is 2 or more.
/// An empty field is NaN. `flaws` is told of columns that hold other text, which are passed over. Throws Error, which begins with
/// `path`, for tables without coordinates and lines of another number of fields.
vtkSmartPointer<vtkPolyData> readCsv(std::string_view bytes, const std::string& path, Flaws& flaws);

/// Lines "x y z" with further numbers, which become arrays "value 1" and so on; or, if the first line is a number alone, that many
/// atoms "symbol x y z" after a line of comment, with the atomic number as array "element". '#' begins a comment in the former.
/// `flaws` is told of what comes after the atoms, which is passed over. Throws Error, which begins with `path`, for other lines.
vtkSmartPointer<vtkPolyData> readXyz(std::string_view bytes, const std::string& path, Flaws& flaws);

}  // namespace gxy

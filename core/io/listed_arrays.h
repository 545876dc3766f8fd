// SPDX-License-Identifier: Apache-2.0
// Lists the arrays of a VTK dataset. Used inside core/io only, by files that include VTK.
#pragma once
#include <vtkDataArray.h>
#include <vtkDataSetAttributes.h>

#include <string>

#include "core/io/color_arrays.h"
#include "core/io/values_choice.h"

namespace gxy {

/// The arrays of points, or of cells, that have been read.
inline ListedArrays listOf(vtkDataSetAttributes* data) {
  const auto nameOf = [](vtkDataArray* array) {
    return std::string(array && array->GetName() ? array->GetName() : "");
  };
  ListedArrays list{{}, nameOf(data->GetScalars()), nameOf(data->GetNormals()), nameOf(data->GetTCoords())};
  for (int i = 0; i < data->GetNumberOfArrays(); ++i)
    if (vtkDataArray* array = data->GetArray(i); array && array->GetName())
      list.arrays.push_back({array->GetName(), array->GetNumberOfComponents(), isColors(array)});
  return list;
}

/// Their names for a message, or "none".
inline std::string namesOf(const ListedArrays& list) {
  std::string names;
  for (const auto& array : list.arrays) names += (names.empty() ? "'" : ", '") + array.name + "'";
  return names.empty() ? "none" : names;
}

}  // namespace gxy

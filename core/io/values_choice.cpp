// SPDX-License-Identifier: Apache-2.0
#include "core/io/values_choice.h"

#include <algorithm>
#include <cctype>

namespace gxy {
namespace {

constexpr std::string_view kGhostArray = "vtkGhostType";

/// Returns "data", or else the first array, among the arrays that contain colours, or among those that do not.
std::optional<std::string> usual(const ListedArrays& list, bool ofColors) {
  std::optional<std::string> first;
  for (const auto& [name, components, colors] : list.arrays) {
    if (colors != ofColors || name == kGhostArray || name == list.normals || name == list.textures) continue;
    if (components == 3 && isNameOfNormals(name)) continue;
    if (name == "data") return name;
    if (!first) first = name;
  }
  return first;
}

bool hasScalars(const ListedArrays& list) {
  return !list.scalars.empty() && list.scalars != kGhostArray && list.has(list.scalars);
}

}  // namespace

bool isNameOfNormals(std::string_view name) { return name == "Normals" || name == "Normals_"; }

bool isColors(std::string_view name, ScalarType type, int components) {
  if (components != 3 && components != 4) return false;
  if (type == ScalarType::UInt8) return true;
  std::string lower(name);
  for (char& c : lower) c = char(std::tolower(static_cast<unsigned char>(c)));
  constexpr std::string_view kNames[] = {"rgb", "rgba", "color", "colors", "colour", "colours"};
  return std::find(std::begin(kNames), std::end(kNames), lower) != std::end(kNames);
}

bool ListedArrays::has(std::string_view name) const {
  return std::any_of(arrays.begin(), arrays.end(), [&](const Array& array) { return array.name == name; });
}

std::optional<ChosenArray> chooseValues(const ListedArrays& points, const ListedArrays& cells,
                                        const ValuesWanted& wanted) {
  if (!wanted.array.empty()) {
    if (points.has(wanted.array) && !wanted.ofCells.value_or(false)) return ChosenArray{wanted.array, false};
    if (cells.has(wanted.array) && wanted.ofCells.value_or(true)) return ChosenArray{wanted.array, true};
    return {};
  }
  const bool mayBeOfPoints = !wanted.ofCells.value_or(false), mayBeOfCells = wanted.ofCells.value_or(true);
  if (mayBeOfPoints && hasScalars(points)) return ChosenArray{points.scalars, false};
  if (mayBeOfCells && hasScalars(cells)) return ChosenArray{cells.scalars, true};
  for (const bool colors : {false, true}) {
    if (const auto name = mayBeOfPoints ? usual(points, colors) : std::nullopt)
      return ChosenArray{*name, false};
    if (const auto name = mayBeOfCells ? usual(cells, colors) : std::nullopt) return ChosenArray{*name, true};
  }
  return {};
}

}  // namespace gxy

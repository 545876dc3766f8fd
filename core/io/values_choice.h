// SPDX-License-Identifier: Apache-2.0
// Which of a geometry file's arrays becomes the values, or the colours.
#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/data/scalar.h"

namespace gxy {

/// The arrays of a file's points, or of its cells: as the file lists them, read or not.
struct ListedArrays {
  struct Array {
    std::string name;
    int components = 1;
    bool colors = false;  ///< isColors()
  };
  std::vector<Array> arrays;
  std::string scalars, normals, textures;  ///< the active ones, by name

  bool has(std::string_view name) const;
};

/// The array that is to become the values, or, if it holds colours, these.
struct ValuesWanted {
  std::string array;            ///< of points, else of cells; empty: the usual one (chooseValues())
  std::optional<bool> ofCells;  ///< an array of cells only, or of points only
  bool orNone = false;          ///< no values, instead of an Error, if the file has no array of that name
  std::string radii;            ///< the array of points that gives radii; empty: the values do

  ValuesWanted() = default;
  ValuesWanted(std::string name, std::optional<bool> cells = {}, bool none = false)
      : array(std::move(name)), ofCells(cells), orNone(none) {}
  ValuesWanted(const char* name) : array(name) {}
};

struct ChosenArray {
  std::string name;
  bool ofCells = false;
};

/// Whether an array of three components of this name holds normals.
bool isNameOfNormals(std::string_view name);

/// Whether an array of three or four components holds red, green, blue and opacity: all of unsigned char, as VTK sees it, and
/// those of the names RGB, RGBA, Color, Colors, Colour and Colours in any case.
bool isColors(std::string_view name, ScalarType type, int components);

/// The array of points of the name that is wanted, else that of cells. If no name is: the active scalars of points, else of
/// cells; else of points the array "data", else the first one; else of cells the same; else the first colours of points, else of
/// cells, which are none of the former. Normals, texture coordinates and vtkGhostType are chosen only by their name. None where
/// there is no such array.
std::optional<ChosenArray> chooseValues(const ListedArrays& points, const ListedArrays& cells,
                                        const ValuesWanted& wanted);

}  // namespace gxy

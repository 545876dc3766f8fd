// SPDX-License-Identifier: Apache-2.0
// Chooses the array of a geometry file that becomes the values, or the colours.
#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/data/scalar.h"

namespace gxy {

/// The arrays of a file's points, or of its cells, as the file lists them, whether they have been read or not.
struct ListedArrays {
  struct Array {
    std::string name;
    int components = 1;
    bool colors = false;  ///< isColors()
  };
  std::vector<Array> arrays;
  std::string scalars, normals, textures;  ///< names of the active ones; empty: none

  bool has(std::string_view name) const;
};

/// The array that is to become the values, or the colours if it contains colours.
struct ValuesWanted {
  std::string array;            ///< name of the array; empty: the default of chooseValues()
  std::optional<bool> ofCells;  ///< true: an array of cells only; false: of points only; absent: either
  bool orNone = false;          ///< if the file has no array of that name, there are no values and no Error
  std::string radii;            ///< array of points that gives radii; empty: the values give them
  std::vector<std::string>
      fields;  ///< arrays of points that become further fields, with all their components

  ValuesWanted() = default;
  ValuesWanted(std::string name, std::optional<bool> cells = {}, bool none = false)
      : array(std::move(name)), ofCells(cells), orNone(none) {}
  ValuesWanted(const char* name) : array(name) {}
};

struct ChosenArray {
  std::string name;
  bool ofCells = false;
};

/// Whether an array with this name and three components contains normals.
bool isNameOfNormals(std::string_view name);

/// Whether an array contains colours. It must have three components, or four with opacity. It then contains
/// colours if its type is unsigned char, as in VTK, or its name is RGB, RGBA, Color, Colors, Colour or
/// Colours in any letter case.
bool isColors(std::string_view name, ScalarType type, int components);

/// Returns the array of points with the wanted name, or else that of cells. If no name is wanted, it is the
/// first of these that exists: the active scalars of points; those of cells; the array of points called
/// "data"; the first array of points; the same two for cells; the same four among arrays of colours, which
/// are not considered before. Of these only those of points or of cells count if `wanted.ofCells` says so. Normals, texture coordinates and vtkGhostType are chosen only by name. Returns
/// nothing if there is no such array.
std::optional<ChosenArray> chooseValues(const ListedArrays& points, const ListedArrays& cells,
                                        const ValuesWanted& wanted);

}  // namespace gxy

// SPDX-License-Identifier: Apache-2.0
// The two files that simsim goes to and fro between.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "core/io/volume_file.h"

namespace gxy::simsim {

/// The same arrays in two files.
struct Inputs {
  struct Pair {
    ArrayInfo array;  ///< of the steps. It has a name, and no range.
    VolumeFile first, second;
  };
  Grid grid;
  std::vector<Pair> arrays;
};

/// Opens both files. `names` are arrays that both have. Without names it is the active array of each, and the
/// steps have its name in the first file, or that file's own name if the array has none. Throws Error if
/// grids, types or numbers of components differ, or if the samples are of cells.
Inputs openInputs(const std::string& first, const std::string& second, const std::vector<std::string>& names);

}  // namespace gxy::simsim

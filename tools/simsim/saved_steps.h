// SPDX-License-Identifier: Apache-2.0
// The files of steps that simsim writes beside publishing them.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "core/io/write_volume.h"
#include "tools/simsim/inputs.h"

namespace gxy::simsim {

/// Files FOLDER/NAME-STEP.vti, which have all arrays on the whole grid.
class SavedSteps {
 public:
  /// Makes the folder if it does not exist. `first` and `second` are the paths of the inputs.
  SavedSteps(const std::string& folder, const std::string& name, const Inputs& inputs,
             const std::string& first, const std::string& second);

  std::string path(int64_t step) const;
  /// Creates the file of a step, or empties it. All ranks write their blocks of each array. Throws Error for a
  /// file that the inputs are read from.
  VolumeWriter create(int64_t step) const;

 private:
  std::string folder_, name_;
  Grid grid_;
  std::vector<ArrayInfo> arrays_;
  std::vector<std::string> kept_;  ///< files of the inputs
};

}  // namespace gxy::simsim

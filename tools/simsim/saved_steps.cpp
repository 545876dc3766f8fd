// SPDX-License-Identifier: Apache-2.0
#include "tools/simsim/saved_steps.h"

#include <filesystem>
#include <system_error>

#include "core/comm/error.h"
#include "core/io/referenced_files.h"

namespace gxy::simsim {

namespace fs = std::filesystem;

SavedSteps::SavedSteps(const std::string& folder, const std::string& name, const Inputs& inputs,
                       const std::string& first, const std::string& second)
    : folder_(folder), name_(name), grid_(inputs.grid) {
  std::error_code failed;
  fs::create_directories(folder, failed);
  if (failed) throw Error(folder + ": the folder cannot be made: " + failed.message());
  for (const Inputs::Pair& pair : inputs.arrays) arrays_.push_back(pair.array);
  for (const std::string& input : {first, second})
    for (const std::string& file : filesOpenedFor(input)) kept_.push_back(file);
}

std::string SavedSteps::path(int64_t step) const {
  return (fs::path(folder_) / (name_ + "-" + std::to_string(step) + ".vti")).string();
}

VolumeWriter SavedSteps::create(int64_t step) const {
  const std::string file = path(step);
  std::error_code missing;
  for (const std::string& input : kept_)
    if (fs::equivalent(file, input, missing))
      throw Error(file + ": it would be overwritten, but it is an input; give another folder or name");
  return VolumeWriter(file, grid_, arrays_);
}

}  // namespace gxy::simsim

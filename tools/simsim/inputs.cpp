// SPDX-License-Identifier: Apache-2.0
#include "tools/simsim/inputs.h"

#include <filesystem>
#include <sstream>

#include "core/comm/error.h"
#include "core/comm/error_text.h"

namespace gxy::simsim {
namespace {

std::string gridText(const Grid& grid) {
  std::ostringstream text;
  text.precision(17);
  const auto three = [&](const auto& values, const char* between) {
    text << values[0] << between << values[1] << between << values[2];
  };
  three(grid.points, " x ");
  text << " points, origin (";
  three(grid.origin, ", ");
  text << "), spacing (";
  three(grid.spacing, ", ");
  text << ')';
  return text.str();
}

std::string typeText(const ArrayInfo& array) {
  return std::string(nameOf(array.type)) + " with " + std::to_string(array.components) +
         (array.components == 1 ? " component" : " components");
}

/// Throws Error, with the values in both files, unless they are equal.
void expectEqual(const char* what, const VolumeFile& first, const std::string& ofFirst,
                 const VolumeFile& second, const std::string& ofSecond) {
  if (ofFirst == ofSecond) return;
  throw Error("expected the same " + std::string(what) + " in both files, found " + ofFirst + " in " +
              first.path + " and " + ofSecond + " in " + second.path);
}

Inputs::Pair openPair(const std::string& first, const std::string& second, const std::string& name) {
  Inputs::Pair pair{{}, openVolume(first, name), openVolume(second, name)};
  for (const VolumeFile* file : {&pair.first, &pair.second})
    if (file->grid.rim)
      throw Error(file->path + ": array " + inQuotes(file->array.name) +
                  " has samples of cells, expected samples of points");
  expectEqual("grid", pair.first, gridText(pair.first.grid), pair.second, gridText(pair.second.grid));
  const std::string what = "type of array" + (name.empty() ? std::string() : " " + inQuotes(name));
  expectEqual(what.c_str(), pair.first, typeText(pair.first.array), pair.second, typeText(pair.second.array));
  pair.array = pair.first.array;
  pair.array.range.reset();
  if (pair.array.name.empty()) pair.array.name = std::filesystem::path(first).stem().string();
  return pair;
}

}  // namespace

Inputs openInputs(const std::string& first, const std::string& second,
                  const std::vector<std::string>& names) {
  Inputs inputs;
  if (names.empty()) inputs.arrays.push_back(openPair(first, second, {}));
  for (const std::string& name : names) inputs.arrays.push_back(openPair(first, second, name));
  inputs.grid = inputs.arrays.front().first.grid;
  return inputs;
}

}  // namespace gxy::simsim

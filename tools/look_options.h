// SPDX-License-Identifier: Apache-2.0
// How data files are shown without a state file: options that programs have in common.
#pragma once
#include <CLI/CLI.hpp>
#include <charconv>
#include <cmath>
#include <string>
#include <vector>

#include "core/scene/first_look.h"

namespace gxy {

/// `isovalues` are words for readIsovalues(), after parsing.
inline void addLookOptions(CLI::App& app, std::vector<std::string>& isovalues, LookOptions& look,
                           std::string& array) {
  app.add_option("--iso", isovalues,
                 "Data files: isosurfaces of volumes at these values, or auto, instead of the volume")
      ->delimiter(',')
      ->allow_extra_args(false);
  app.add_flag("--slice", look.slice,
               "Data files: slices through the middle of volumes, instead of the volume");
  app.add_option("--array", array, "Data files: the array to show");
}

/// Throws CLI::ValidationError for what is neither a number nor `auto`.
inline void readIsovalues(const std::vector<std::string>& words, LookOptions& look) {
  for (const std::string& word : words) {
    if (word == "auto") {
      look.autoIsovalue = true;
      continue;
    }
    double value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value))
      throw CLI::ValidationError("--iso", "expected numbers or auto, found '" + word + "'");
    look.isovalues.push_back(value);
  }
}

}  // namespace gxy

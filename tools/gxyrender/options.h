// SPDX-License-Identifier: Apache-2.0
// The command line of gxyrender.
#pragma once
#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/scene/first_look.h"
#include "core/scene/scene.h"

namespace gxy {

struct RenderOptions {
  std::vector<std::string> files;               ///< a state file, or data files
  std::string array;                            ///< array of data files
  LookOptions look;                             ///< options of the first look at data files
  bool looks = false;                           ///< one of the two options above was given
  std::map<std::string, std::string> datasets;  ///< files of datasets of the state file, by name
  std::string prefix = "image";
  std::string sweepFile;       ///< of a Cinema database; empty: there is none to be made
  bool resume = false;         ///< keep the pictures that the database has
  size_t firstPicture = 0;     ///< number of the current time step's first picture
  std::optional<double> time;  ///< time of that step, if it is known
  std::optional<std::array<int, 2>> size;
  std::string backend = "auto";
  std::string device;  ///< device of the backend; empty: the best one
  bool reference = false;
  std::optional<double> tolerance, step;
  std::array<int, 3> partitions{0, 0, 0};  ///< as in automaticPartitioning()
  int concurrent = 8;
  std::string format = "png";
  bool depth = false;
  std::string statsFile;
  int threads = 0;
  int packet = 1024;
  int64_t raysInFlight = 1 << 20;
  bool annotate = false;
  bool quiet = false;

  /// Replaces settings of the state by those of the command line.
  void apply(State& state) const;
};

/// Returns the exit code if the program should end at once (0 after --help, 2 for wrong usage), or nothing.
/// Prints help and errors only if `speaks`.
std::optional<int> parseOptions(int argc, char** argv, bool speaks, RenderOptions& options);

}  // namespace gxy

// SPDX-License-Identifier: Apache-2.0
// The command line of gxyrender.
#pragma once
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/scene/first_look.h"
#include "core/scene/scene.h"

namespace gxy {

struct RenderOptions {
  std::vector<std::string> files;  ///< a state file, or data
  std::string array;               ///< of data files
  LookOptions look;                ///< at data files
  bool looks = false;              ///< whether one of the two above was given
  std::string prefix = "image";
  size_t firstPicture = 0;     ///< number of a step's first
  std::optional<double> time;  ///< of that step, where it is known
  std::optional<std::array<int, 2>> size;
  std::string backend = "auto";
  std::string device;  ///< of the backend; empty: the best
  bool reference = false;
  std::optional<double> tolerance, step;
  std::array<int, 3> partitions{0, 0, 0};  ///< {n, 0, 0}: n, cut automatically; {0, 0, 0}: one a rank or more
  int concurrent = 8;
  std::string format = "png";
  bool depth = false;
  std::string statsFile;
  int threads = 0;
  int packet = 1024;
  int64_t raysInFlight = 1 << 20;
  bool annotate = false;
  bool quiet = false;

  /// What the command line says goes over what the state file says.
  void apply(State& state) const;
};

/// The exit code to end with at once (0 after --help, 2 for wrong usage), or nothing. Prints help and errors only if
/// `speaks`.
std::optional<int> parseOptions(int argc, char** argv, bool speaks, RenderOptions& options);

}  // namespace gxy

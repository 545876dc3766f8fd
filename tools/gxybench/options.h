// SPDX-License-Identifier: Apache-2.0
// The command line of gxybench.
#pragma once
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "tools/gxybench/scenes.h"

namespace gxy::bench {

struct Options {
  enum class Command { Measure, List, Compare, Work };
  Command command = Command::Measure;

  // Measure
  std::vector<std::string> scenes;  ///< names of fixed scenes or state files; empty: all fixed ones
  bool quick = false;
  std::vector<std::string> backends{"auto"};
  std::string device;
  std::vector<int> ranks{1};
  std::optional<std::array<int, 2>> size;
  Ladders ladders;
  int repeats = 0;  ///< never 0 after parsing
  int threads = 0;
  std::string out = "bench", cache, launcher;
  bool quiet = false;

  // Compare
  std::string older, newer;
  bool wall = false, fail = false;
  std::string error = "rms";

  // Work
  std::string jobFile;
};

/// Parses the command line, and prints help and errors. Returns the exit code if the program is to end at
/// once (0 after --help, 2 for wrong usage), otherwise nothing.
std::optional<int> parseOptions(int argc, char** argv, Options& options);

}  // namespace gxy::bench

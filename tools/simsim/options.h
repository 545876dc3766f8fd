// SPDX-License-Identifier: Apache-2.0
// The command line of simsim.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tools/simsim/blend.h"
#include "tools/simsim/place.h"

namespace gxy::simsim {

struct SimulationOptions {
  std::string first, second;        ///< files of the two volumes
  std::vector<std::string> arrays;  ///< none: the active one of each file
  std::string name = "simsim";      ///< of the stream
  std::string host = "127.0.0.1";
  uint16_t port = 5001;
  std::string tokenFile;    ///< as option "token-file" of gxy_open(); empty: its default
  int64_t steps = 10;       ///< 0: until a signal comes
  double pause = 5;         ///< seconds between steps
  Wave wave;                ///< how steps go to and fro
  int threads = 1;          ///< ranks in this process, if no launcher has started several
  std::string savedFolder;  ///< empty: steps are not saved
  bool waits = false;       ///< for each step to be taken, a minute at most
  bool quiet = false;

  /// "HOST:PORT"
  std::string server() const;
  /// The options of gxy_open().
  std::string ofStream() const;
};

/// `place` is that of this process among those that a launcher has started. Only rank 0 prints help, notes and
/// errors. Returns the exit code if the program should end at once (0 after --help, 2 for wrong usage), or
/// nothing.
std::optional<int> parseOptions(int argc, const char* const* argv, const Place& place,
                                SimulationOptions& options);

}  // namespace gxy::simsim

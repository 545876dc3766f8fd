// SPDX-License-Identifier: Apache-2.0
// The command line of msdata and msclient.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "multiserver/client/client.h"

namespace gxy {

struct SayOptions {
  Client::Options client;  ///< its `name` is that of the program
  std::vector<std::string> modules, statements, scripts;
  bool json = false;
  bool follow = false;  ///< after the last statement, events are printed until the connection ends
};

/// Returns the exit code if the program should end at once (0 after --help, 2 for wrong usage), or nothing.
std::optional<int> parseOptions(int argc, char** argv, SayOptions& options);

}  // namespace gxy

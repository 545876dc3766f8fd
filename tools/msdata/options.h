// SPDX-License-Identifier: Apache-2.0
// What msdata or msclient was asked on its command line.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "multiserver/client/client.h"

namespace gxy {

struct SayOptions {
  Client::Options client;  ///< its name is the program's
  std::vector<std::string> modules, statements, scripts;
  bool json = false;
  bool follow = false;  ///< after the last statement, events are printed until the connection ends
};

/// The exit code to end with at once (0 after --help, 2 for wrong usage), or nothing.
std::optional<int> parseOptions(int argc, char** argv, SayOptions& options);

}  // namespace gxy

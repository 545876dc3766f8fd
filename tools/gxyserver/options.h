// SPDX-License-Identifier: Apache-2.0
// The command line of gxyserver.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "multiserver/server/server.h"
#include "multiserver/server/server_rank.h"

namespace gxy {

struct ServeOptions {
  ServerRankOptions serverRank;
  ServerOptions server;
  std::string tokenFile, portFile, traceFile;
  std::vector<std::string> tenants;
  bool noToken = false;
  std::string device;  ///< BackendOptions::device
  std::string logLevel = "info";
  int threads = 0;
};

/// Returns the exit code if the program should end at once (0 after --help, 2 for wrong usage), or nothing.
/// Prints help and errors only if `speaks`.
std::optional<int> parseOptions(int argc, char** argv, bool speaks, ServeOptions& options);

}  // namespace gxy

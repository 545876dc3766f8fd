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
  bool printTicket = false;  ///< print an address that lets a browser in
  std::string device;        ///< BackendOptions::device
  std::string logLevel = "info";
  int threads = 0;
  std::string simulation;  ///< of galaxy_SIMULATION.so, which these processes run as well; empty: none
  std::vector<std::string> simulationArguments;
  bool world = false;  ///< ranks of a simulation are in MPI_COMM_WORLD, too
};

/// Returns the exit code if the program should end at once (0 after --help, 2 for wrong usage), or nothing.
/// Prints help and errors only if `speaks`.
std::optional<int> parseOptions(int argc, char** argv, bool speaks, ServeOptions& options);

}  // namespace gxy

// SPDX-License-Identifier: Apache-2.0
#include "tools/gxyserver/options.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <iostream>

#include "backends/registry/backends.h"
#include "multiserver/server/tenants.h"
#include "multiserver/web/hosts.h"
#include "tools/version_option.h"

namespace gxy {

namespace {

// Returns the first of some folders that is there, relative to the program, built or installed; empty if none is.
std::string beside(std::initializer_list<const char*> folders) {
  std::error_code failed;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", failed);
  for (const char* folder : folders) {
    const auto path = std::filesystem::weakly_canonical(program.parent_path() / folder, failed);
    if (std::filesystem::is_directory(path, failed)) return path.string();
  }
  return {};
}

std::string ownModules() {
  return beside({"../lib/galaxy", "../lib/x86_64-linux-gnu/galaxy", "../lib64/galaxy"});
}
std::string ownGui() { return beside({"../share/galaxy/gui"}); }

// Returns what is wrong with a number of bytes, after AsSizeValue has converted it; empty if nothing is.
std::string wrongBytes(const std::string& text) {
  int64_t bytes = 0;
  return CLI::detail::lexical_cast(text, bytes) && bytes > 0
             ? std::string()
             : "expected bytes from 1 up, as 500M, found " + text;
}

}  // namespace

std::optional<int> parseOptions(int argc, char** argv, bool speaks, ServeOptions& o) {
  CLI::App app("A server that many clients share: data, rendering and analysis on all ranks of an MPI job.",
               "gxyserver");
  int64_t idle = 0;
  bool noGui = false;
  double patience = std::chrono::duration<double>(o.serverRank.rankPatience).count();
  app.add_option("--port", o.server.port, "TCP port; 0: any that is free")->capture_default_str();
  app.add_option("--port-file", o.portFile, "a file to write the port to, once it listens");
  app.add_option("--bind", o.server.bind, "the address to listen on")->capture_default_str();
  app.add_option("--insitu-bind", o.serverRank.insituBind,
                 "the address on which each rank takes data of simulations (default: that of --bind)");
  app.add_option("--token-file", o.tokenFile, "where to leave the token (default: the user's run directory)");
  app.add_flag("--no-token", o.noToken, "let everybody in who can connect: for tests only");
  app.add_option("--tenant", o.tenants, "a further tenant, with a token file of its own; may be repeated")
      ->allow_extra_args(false)
      ->check(CLI::Validator(Tenants::wrongName, ""));
  auto* gui =
      app.add_option("--gui", o.server.guiFolder,
                     "folder with the browser GUI's files (default: share/galaxy/gui beside the program)")
          ->check(CLI::ExistingDirectory);
  app.add_flag("--no-gui", noGui, "serve no browsers")->excludes(gui);
  app.add_option(
         "--host", o.server.hosts,
         "a further name under which browsers reach the server, for instance of a reverse proxy; may be "
         "repeated")
      ->allow_extra_args(false)
      ->check(CLI::Validator(Hosts::wrongName, ""));
  app.add_flag("--print-ticket", o.printTicket,
               "print an address that lets one browser in, within 10 minutes, though the output may be read "
               "by others");
  app.add_option("--modules", o.serverRank.moduleFolders,
                 "folder in which modules are looked for before Galaxy's own; may be repeated")
      ->allow_extra_args(false);
  app.add_option(
         "--data", o.serverRank.dataFolders,
         "folder in which clients may read and write files; may be repeated (default: the current one)")
      ->allow_extra_args(false);
  app.add_option("--backend", o.serverRank.backend, kBackendHelp)->capture_default_str();
  app.add_option("--device", o.device, kDeviceHelp);
  app.add_option("--memory", o.serverRank.memory, "bytes for data, on each rank, as 500M")
      ->default_str(std::to_string(o.serverRank.memory >> 30) + "G")
      ->transform(CLI::AsSizeValue(false))
      ->check(CLI::Validator(wrongBytes, ""));
  app.add_option("--tenant-memory", o.serverRank.tenantMemory,
                 "bytes of one tenant, on each rank (default: as --memory)")
      ->transform(CLI::AsSizeValue(false))
      ->check(CLI::Validator(wrongBytes, ""));
  app.add_option("--tenant-frames", o.serverRank.tenantFrames, "renderings that a tenant may have in flight")
      ->capture_default_str()
      ->check(CLI::Range(1, 100000));
  app.add_option("--rays-in-flight", o.serverRank.raysInFlight, "of each rank")
      ->capture_default_str()
      ->check(CLI::Range(int64_t(1), int64_t(1) << 40));
  app.add_option("--max-clients", o.server.connection.limits.clients, "clients connected at once")
      ->capture_default_str()
      ->check(CLI::Range(1, 100000));
  app.add_option("--idle-exit", idle, "stop after so many minutes without clients; 0: never")
      ->check(CLI::Range(int64_t(0), int64_t(1) << 30));
  app.add_option("--rank-patience", patience,
                 "seconds without an answer after which clients are told that a rank is missing")
      ->capture_default_str()
      ->check(CLI::Range(0.1, 86400.0));
  app.add_option("--threads", o.threads, "threads of each rank; 0: the node's cores shared by its ranks")
      ->check(CLI::Range(0, 4096));
  app.add_option(
      "--trace", o.traceFile,
      "write what all ranks did when, the newest 262144 stages of each, to this file at the end, for "
      "chrome://tracing");
  app.add_option("--log-level", o.logLevel, "debug, info, warn, error or off")
      ->capture_default_str()
      ->check(CLI::IsMember({"debug", "info", "warn", "error", "off"}));
  auto* simulation = app.add_option("--simulation", o.simulation,
                                    "run the simulation galaxy_NAME.so, of the module folders or their "
                                    "folders `simulations`, in these processes, with what follows --");
  app.add_option("ARGS", o.simulationArguments, "arguments of the simulation, after --")->needs(simulation);
  app.add_flag(
         "--world", o.world,
         "the ranks of a simulation are in the same MPI job: mpirun -n M SIMULATION : -n N gxyserver --world")
      ->excludes(simulation);
  addVersion(app, "gxyserver");
  try {
    app.parse(argc, argv);
    for (const std::string& name : o.tenants)
      if (std::count(o.tenants.begin(), o.tenants.end(), name) > 1)
        throw CLI::ValidationError("--tenant", "expected each tenant once, found '" + name + "' again");
      else if (name == "view" || name.ends_with(".view"))
        throw CLI::ValidationError("--tenant",
                                   "expected a name other than 'view' and that does not end in '.view', "
                                   "as files of view-only tokens do; found '" +
                                       name + "'");
  } catch (const CLI::ParseError& e) {
    std::ostream nowhere(nullptr);
    const int code = app.exit(e, speaks ? std::cout : nowhere, speaks ? std::cerr : nowhere);
    return code == 0 ? 0 : 2;
  }
  o.server.idleExit = std::chrono::minutes(idle);
  o.serverRank.rankPatience = std::chrono::milliseconds(int64_t(patience * 1000));
  if (std::string own = ownModules(); !own.empty()) o.serverRank.moduleFolders.push_back(std::move(own));
  o.server.gui = !noGui;
  if (app.count("--gui") == 0) o.server.guiFolder = ownGui();
  if (app.count("--insitu-bind") == 0) o.serverRank.insituBind = o.server.bind;
  if (app.count("--tenant-memory") == 0) o.serverRank.tenantMemory = o.serverRank.memory;
  return std::nullopt;
}

}  // namespace gxy

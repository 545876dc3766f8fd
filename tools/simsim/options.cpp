// SPDX-License-Identifier: Apache-2.0
#include "tools/simsim/options.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>
#include <nlohmann/json.hpp>

#include "tools/number_option.h"
#include "tools/version_option.h"

namespace gxy::simsim {
namespace {

constexpr const char* kAbout =
    "A simulation of a simulation: goes to and fro between two volumes of the same grid, and publishes each "
    "step to a Galaxy server while it runs. The server has what comes as datasets NAME.ARRAY.";
constexpr const char* kFooter = R"(Examples:
  simsim begin.vti end.vti                         10 steps of the active array, 5 s apart
  simsim begin.vti end.vti -M 3 -n 0 -d 0.5        three ranks, until Ctrl-C
  galaxy run -n 4 simsim begin.vti end.vti -n 40   four ranks, each a process
Exit status: 0 done, 1 failed, or no step has reached the server, 2 wrong usage, 130 or 143 after SIGINT or
SIGTERM.)";

/// What is wrong with the name of a stream, which becomes part of file names; empty if nothing is.
std::string wrongName(const std::string& name) {
  if (!name.empty() && name.find('/') == std::string::npos) return {};
  return "expected a name without '/', found '" + name + "'";
}

/// Options that say what is published.
void addSteps(CLI::App& app, SimulationOptions& o, std::optional<double>& cycles) {
  app.add_option("A", o.first, "the volume of the first step: a .vti or another file that gxydata info reads")
      ->required();
  app.add_option("B", o.second, "the volume that the steps go to: same grid, same types of arrays")
      ->required();
  app.add_option("--array", o.arrays, "an array to publish; may be repeated (default: the active one)")
      ->allow_extra_args(false);
  app.add_option("-n,--steps", o.steps, "number of steps; 0: until interrupted")
      ->check(CLI::Range(int64_t(0), int64_t(1) << 40))
      ->capture_default_str();
  app.add_option("-d,--delay", o.pause, "seconds between steps")
      ->check(numberFrom(0, 1e6))
      ->capture_default_str();
  app.add_option("-c,--cycles", cycles,
                 "how often all steps together go from A to B and back (default: once in 10 steps)")
      ->check(numberFrom(1e-6, 1e6));
  app.add_option(
         "-M,--ranks", o.threads,
         "ranks of the simulation: each is a thread, owns a block and publishes it; started by mpirun "
         "or srun, each process is a rank instead")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
}

/// Options that say where to.
void addPlaces(CLI::App& app, SimulationOptions& o, std::string& layout) {
  const std::map<std::string, bool> policies{{"skip", false}, {"wait", true}};
  app.add_option("--policy", o.waits,
                 "skip: steps may be left out (the default); wait: each is taken, which is waited for a "
                 "minute at most")
      ->transform(CLI::Transformer(policies))
      ->type_name("skip|wait");
  app.add_option("-H,--host", o.host, "where the server runs")->capture_default_str();
  app.add_option("-P,-p,--port", o.port, "its port")->capture_default_str();
  app.add_option(
      "--token-file", o.tokenFile,
      "file with the server's token, - for none (default: where a server on this machine leaves it)");
  app.add_option("--name", o.name, "name of the stream: datasets are called NAME.ARRAY")
      ->check(CLI::Validator(wrongName, ""))
      ->capture_default_str();
  app.add_option("--save", o.savedFolder,
                 "also write each step to a file NAME-STEP.vti in this folder, before it is published");
  app.add_option("-l", layout, "ignored: the earlier simsim's layout, which nothing needs now");
  app.add_flag("-q,--quiet", o.quiet, "no line for each step, and no summary");
}

/// Throws CLI::ValidationError for options that do not go together.
void checkTogether(const CLI::App& app, const Place& place, const SimulationOptions& o,
                   const std::optional<double>& cycles) {
  if (cycles && o.steps == 0)
    throw CLI::ValidationError("-c", "expected a number of steps (-n) that the cycles are in, found -n 0");
  const std::string launched = "this is rank " + std::to_string(place.rank) + " of " +
                               std::to_string(place.ranks) + " that a launcher has started";
  if (place.ranks > 1 && app.count("-M") > 0)
    throw CLI::ValidationError("-M", "expected without a launcher, and " + launched);
  if (place.ranks > 1 && !o.savedFolder.empty())
    throw CLI::ValidationError("--save", "expected ranks of one process (-M), and " + launched);
  for (const std::string& array : o.arrays)
    if (std::ranges::count(o.arrays, array) > 1)
      throw CLI::ValidationError("--array", "expected each array once, found '" + array + "' again");
}

}  // namespace

std::string SimulationOptions::server() const {
  const bool bare = host.find(':') == std::string::npos || host.starts_with('[');
  return (bare ? host : "[" + host + "]") + ":" + std::to_string(port);
}

std::string SimulationOptions::ofStream() const {
  nlohmann::json options{{"to", server()}};
  if (!tokenFile.empty()) options["token-file"] = tokenFile;
  if (waits) options.update({{"policy", "wait"}, {"time-out", 60}});
  return options.dump();
}

std::optional<int> parseOptions(int argc, const char* const* argv, const Place& place, SimulationOptions& o) {
  CLI::App app(kAbout, "simsim");
  std::optional<double> cycles;
  std::string layout;
  addSteps(app, o, cycles);
  addPlaces(app, o, layout);
  app.footer(kFooter);
  addVersion(app, "simsim");
  const bool speaks = place.rank == 0;
  try {
    app.parse(argc, argv);
    checkTogether(app, place, o, cycles);
  } catch (const CLI::ParseError& e) {
    std::ostream nowhere(nullptr);
    const int code = app.exit(e, speaks ? std::cout : nowhere, speaks ? std::cerr : nowhere);
    return code == 0 ? 0 : 2;
  }
  if (cycles) o.wave = {*cycles, o.steps};
  if (speaks && app.count("-l") > 0)
    std::cerr << "simsim: option -l is ignored: the server tells the ranks where to send to\n";
  return std::nullopt;
}

}  // namespace gxy::simsim

// SPDX-License-Identifier: Apache-2.0
// Where a simulation publishes its steps, and how.
#pragma once
#include <chrono>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>

namespace gxy::insitu {

/// The options of gxy_open() (insitu/api/galaxy_insitu.h).
struct Options {
  bool on = false;
  std::string host;
  uint16_t port = 0;
  std::string tokenFile;     ///< "-": none; empty: where a server on this machine leaves its token
  std::string token;         ///< if it is known already
  bool asksForToken = true;  ///< false: the server is known to need none
  std::string tenant = "user";
  std::string scope = "private";
  std::string partition = "even";  ///< JSON, as it is sent to the server
  std::string steerable = "[]";    ///< the same
  std::string triggers = "[]";     ///< the same; or the name of a file that has it, in quotes
  /// How long a publish waits until it is taken: not at all (policy "skip"), or so many seconds (policy "wait"); infinity: for ever.
  std::chrono::duration<double> patience{0};
  int64_t every = 1;  ///< only the first of so many publishes is offered
  /// Only steps with these times are offered, in the simulation's unit.
  double firstTime = -std::numeric_limits<double>::infinity(),
         lastTime = std::numeric_limits<double>::infinity();
  std::chrono::duration<double> reconnect{5};  ///< 0: never
  std::optional<bool> checksum;  ///< whether samples are sent with checksums; none: but to loopback addresses
};

/// Reads `text`, a JSON object, or null for none. The environment variables GALAXY_INSITU and GALAXY_INSITU_OPTIONS go before it.
/// Throws Error, with what was expected, for options that do not exist and for wrong values.
Options readOptions(const char* text);
/// Whether `text`, or the environment, says "here". Throws Error as readOptions().
bool saysHere(const char* text);
/// Returns the options of the program and the environment together, as JSON. Throws Error as readOptions().
std::string givenOptions(const char* text);
/// Reads the file of triggers, if they are in one. Rank 0 of the simulation calls it, and brings them to the server. Throws Error.
void readTriggers(Options& options);

}  // namespace gxy::insitu

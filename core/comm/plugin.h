// SPDX-License-Identifier: Apache-2.0
// Plugins: shared libraries of Galaxy itself that hold what needs a large library of others, so that only programs
// that come to need it load it. A plugin offers one structure of functions, its table, and exports nothing else.
#pragma once
#include <string>

namespace gxy {

/// Opens the plugin of this name and returns its table. It is looked for in Galaxy's library folder beside the program's
/// folder, then as the dynamic linker finds libraries of the program (its run path, which those who link Galaxy's libraries
/// get from CMake). It stays open. Throws Error, which says what `purpose` needs it for ("reading pictures"), if it is missing
/// or of another version than this program. Safe from any thread.
const void* openPlugin(const std::string& name, const std::string& purpose);

/// The table, opened at the first call. Each type of table belongs to one plugin.
template <class Table>
const Table& plugin(const std::string& name, const std::string& purpose) {
  static const Table& table =
      *static_cast<const Table*>(openPlugin(name, purpose));  // tried again after an Error
  return table;
}

}  // namespace gxy

/// In one source of a plugin (galaxy_plugin() in GalaxyTargets.cmake), outside of namespaces: offers `table`.
#define GALAXY_PLUGIN(table)                                                \
  extern "C" const char* galaxy_plugin_version() { return GALAXY_VERSION; } \
  extern "C" const void* galaxy_plugin_table() { return &(table); }

// SPDX-License-Identifier: Apache-2.0
// Plugins: shared libraries of Galaxy's own that contain the code that depends on a large external library. A
// program loads the plugin, and with it that library, only when it first needs it. A plugin offers one
// structure of functions, its table, and exports nothing else.
#pragma once
#include <string>

namespace gxy {

/// Opens the plugin `name` and returns its table. The plugin is searched for in Galaxy's library folder
/// beside the program's folder, in the folder `galaxy` beside the shared library that has this code, if it is in one, then where the dynamic linker searches for the program's libraries (the run
/// path, which CMake sets for programs that link Galaxy's libraries). The plugin stays open. Throws Error if
/// the plugin is missing or its version differs from the program's; `purpose` ("reading pictures") begins the
/// message. Any thread may call it.
const void* openPlugin(const std::string& name, const std::string& purpose);

/// Returns the plugin's table. The first call opens the plugin. Each type of table belongs to one plugin.
template <class Table>
const Table& plugin(const std::string& name, const std::string& purpose) {
  static const Table& table =
      *static_cast<const Table*>(openPlugin(name, purpose));  // tried again after an Error
  return table;
}

}  // namespace gxy

/// Offers `table` as the plugin's table. Stands in one source of a plugin (galaxy_plugin() in
/// GalaxyTargets.cmake), outside of namespaces.
#define GALAXY_PLUGIN(table)                                                \
  extern "C" const char* galaxy_plugin_version() { return GALAXY_VERSION; } \
  extern "C" const void* galaxy_plugin_table() { return &(table); }

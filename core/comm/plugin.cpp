// SPDX-License-Identifier: Apache-2.0
#include "core/comm/plugin.h"

#include <dlfcn.h>

#include <filesystem>

#include "core/comm/error.h"
#include "core/comm/version.h"

namespace gxy {
namespace {

// In a build tree programs are build/PRESET/{bin,tests}/program and plugins are in build/PRESET/lib/galaxy.
// In an installation their relative place follows from the folders that CMake was given.
std::string placeOf(const std::string& file) {
  namespace fs = std::filesystem;
  std::error_code failed;
  const fs::path program = fs::read_symlink("/proc/self/exe", failed);
  for (const char* folder : {"../lib/galaxy", GALAXY_PLUGIN_FOLDER}) {
    const fs::path found = program.parent_path() / folder / file;
    if (fs::is_regular_file(found, failed)) return found.string();
  }
  // This code may be in a shared library that another program has opened.
  Dl_info self{};
  if (dladdr(reinterpret_cast<const void*>(&openPlugin), &self) != 0 && self.dli_fname) {
    const fs::path found = fs::absolute(self.dli_fname, failed).parent_path() / "galaxy" / file;
    if (fs::is_regular_file(found, failed)) return found.string();
  }
  return file;
}

}  // namespace

const void* openPlugin(const std::string& name, const std::string& purpose) {
  const std::string path = placeOf("libgalaxy_" + name + ".so");
  const std::string begin = purpose + " needs Galaxy's library ";
  void* library = dlopen(path.c_str(), RTLD_LAZY | RTLD_LOCAL);
  if (!library)
    throw Error(begin + "libgalaxy_" + name +
                ".so, expected in lib/galaxy beside the program's folder: " + dlerror());
  const auto version = reinterpret_cast<const char* (*)()>(dlsym(library, "galaxy_plugin_version"));
  const auto table = reinterpret_cast<const void* (*)()>(dlsym(library, "galaxy_plugin_table"));
  if (!version || !table) throw Error(begin + path + ", which is none of Galaxy's plugins");
  if (std::string(version()) != kVersion)
    throw Error(begin + path + " of version " + kVersion + ", found version " + version());
  return table();
}

}  // namespace gxy

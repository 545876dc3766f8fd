// SPDX-License-Identifier: Apache-2.0
#include "insitu/client/here.h"

#include <dlfcn.h>

#include <utility>

#include "core/comm/error.h"
#include "insitu/embed/embed.h"

namespace gxy::insitu {

namespace {

struct Process {
  std::mutex mutex;
  Here here;
  std::mutex starting;  ///< guards the others
  const galaxy_embed* library = nullptr;
  int streams = 0;
  bool runs = false;
};

Process& process() {
  static Process one;
  return one;
}

// The folder of this library, with a slash at the end.
std::string ownFolder() {
  Dl_info info{};
  if (dladdr(reinterpret_cast<const void*>(&here), &info) == 0 || !info.dli_fname) return {};
  const std::string path = info.dli_fname;
  return path.substr(0, path.rfind('/') + 1);
}

}  // namespace

Here here() {
  const std::lock_guard lock(process().mutex);
  return process().here;
}

void setHere(Here here) {
  const std::lock_guard lock(process().mutex);
  process().here = std::move(here);
}

void loadEmbedded(const std::string& mpi) {
  Process& p = process();
  const std::lock_guard lock(p.starting);
  if (p.library) return;
  constexpr const char* kName = "libgalaxy_embed.so.1";
  std::string why;
  for (const std::string& name : {ownFolder() + kName, std::string(kName)}) {
    // Global, so that the modules that it loads find its symbols.
    void* handle = dlopen(name.c_str(), RTLD_NOW | RTLD_GLOBAL);
    if (!handle) {
      why += std::string("\n  ") + dlerror();
      continue;
    }
    const auto* found = static_cast<const galaxy_embed*>(dlsym(handle, "galaxy_embed_impl"));
    if (!found || found->version != GALAXY_EMBED_VERSION)
      throw Error("\"to\": \"here\": " + name + " is of another version, expected that of this library");
    if (mpi.find(found->mpi) == std::string::npos)
      throw Error("\"to\": \"here\": the simulation uses " + mpi.substr(0, 60) +
                  ", and Galaxy was built with " + found->mpi + ": expected the same, or a server beside");
    p.library = found;
    return;
  }
  throw Error("\"to\": \"here\": " + std::string(kName) +
              " was not found. Expected it beside libgalaxy_insitu, or where the loader looks:" + why);
}

bool startEmbedded(Communicator communicator, const std::string& options) {
  Process& p = process();
  const std::lock_guard lock(p.starting);
  if (!p.library) return false;  // The server is that of gxyserver, which has loaded the simulation.
  if (p.runs) return ++p.streams > 0;
  galaxy_embed_address address{};
  Here found;
  const int failed = communicator.c
                         ? p.library->start(communicator.c, options.c_str(), &address)
                         : p.library->start_fortran(*communicator.fortran, options.c_str(), &address);
  if (failed == 0) {
    p.runs = true;
    p.streams = 1;
    found = {address.host, address.port, address.token, {}};
  } else {
    found.problem = std::string("\"to\": \"here\": ") + address.error;
  }
  setHere(std::move(found));
  return p.runs;
}

void leaveEmbedded() {
  Process& p = process();
  const std::lock_guard lock(p.starting);
  if (p.streams == 0 || --p.streams > 0 || !p.runs) return;
  p.library->stop();
  p.runs = false;
  setHere({});
}

}  // namespace gxy::insitu

// SPDX-License-Identifier: Apache-2.0
#include "tools/gxyserver/simulation.h"

#include <dlfcn.h>
#include <mpi.h>

#include <chrono>
#include <climits>
#include <cstdio>
#include <filesystem>
#include <thread>

#include "core/comm/error.h"

namespace gxy {

LoadedSimulation::LoadedSimulation(const std::string& name, const std::vector<std::string>& folders)
    : name_(name), library_(nullptr) {
  if (name.find('/') != std::string::npos)
    throw Error("--simulation: found '" + name + "', expected a bare name");
  std::string where;
  for (const std::string& folder : folders) {
    const std::string last = "/galaxy_" + name + ".so";
    std::string file = folder + "/simulations" + last;
    if (!std::filesystem::exists(file)) file = folder + last;
    where += (where.empty() ? "" : ", ") + folder;
    if (!std::filesystem::exists(file)) continue;
    library_ = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (!library_) throw Error(std::string("--simulation: it cannot be loaded: ") + dlerror());
    if (dlsym(library_, "galaxy_simulation")) return;
    throw Error("--simulation: " + file +
                " has no function galaxy_simulation(MPI_Comm, int, char**), expected one in C");
  }
  throw Error("--simulation: there is no galaxy_" + name + ".so, looked for in " + where);
}

int LoadedSimulation::run(const Listening& listening, const std::vector<std::string>& arguments) const {
  // Of the library that the simulation links, if it publishes at all.
  if (const auto setHere =
          reinterpret_cast<void (*)(const char*, const char*)>(dlsym(library_, "gxy_set_here")))
    setHere((listening.host + ":" + std::to_string(listening.port)).c_str(), listening.token.c_str());
  std::vector<std::string> words{name_};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  MPI_Comm mine;
  MPI_Comm_dup(MPI_COMM_WORLD, &mine);
  const auto simulation =
      reinterpret_cast<int (*)(MPI_Comm, int, char**)>(dlsym(library_, "galaxy_simulation"));
  const int status = simulation(mine, int(words.size()), argv.data());
  MPI_Comm_free(&mine);
  return status;
}

SharedWorld::SharedWorld() : communicator_(new MPI_Comm) {
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_split(MPI_COMM_WORLD, 1, rank, static_cast<MPI_Comm*>(communicator_));
}

SharedWorld::~SharedWorld() {
  MPI_Comm_free(static_cast<MPI_Comm*>(communicator_));
  delete static_cast<MPI_Comm*>(communicator_);
}

// The other end is gxy_split_world() in insitu/api/galaxy_insitu_mpi.h.
void SharedWorld::tell(const Listening& listening) {
  int rank = 0, ownRank = 0, root = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_rank(*static_cast<MPI_Comm*>(communicator_), &ownRank);
  const int server = ownRank == 0 ? rank : INT_MAX;
  MPI_Allreduce(&server, &root, 1, MPI_INT, MPI_MIN, MPI_COMM_WORLD);
  char where[2][512] = {};
  if (listening.port > 0) {
    std::snprintf(where[0], sizeof where[0], "%s:%d", listening.host.c_str(), int(listening.port));
    std::snprintf(where[1], sizeof where[1], "%s", listening.token.c_str());
  }
  MPI_Bcast(where, int(sizeof where), MPI_CHAR, root, MPI_COMM_WORLD);
}

void SharedWorld::awaitEnd() {
  MPI_Request barrier;
  MPI_Ibarrier(MPI_COMM_WORLD, &barrier);
  for (int done = 0; !done; MPI_Test(&barrier, &done, MPI_STATUS_IGNORE))
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
}

}  // namespace gxy

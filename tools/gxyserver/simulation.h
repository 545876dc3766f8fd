// SPDX-License-Identifier: Apache-2.0
// A simulation beside the server: in the same processes, or in the same MPI job.
#pragma once
#include <functional>
#include <future>
#include <string>
#include <vector>

namespace gxy {

/// Where the server listens. `port` 0: it could not be started.
struct Listening {
  std::string host;
  uint16_t port = 0;
  std::string token;
};

/// A simulation in a shared library, galaxy_NAME.so, which defines `int galaxy_simulation(MPI_Comm, int argc, char** argv)`.
class LoadedSimulation {
 public:
  /// Looks for it in the folders, in this order, in each first in the folder "simulations". Throws Error, with what was looked for and where.
  LoadedSimulation(const std::string& name, const std::vector<std::string>& folders);

  /// Runs it on this thread, with a communicator of its own, which is made of all ranks; its streams go to the server. Returns what it
  /// returns.
  int run(const Listening& listening, const std::vector<std::string>& arguments) const;

 private:
  const std::string name_;
  void* library_;
};

/// The server's ranks in an MPI world that a simulation shares.
class SharedWorld {
 public:
  /// Collective over the world, as gxy_split_world().
  SharedWorld();
  ~SharedWorld();
  SharedWorld(const SharedWorld&) = delete;
  SharedWorld& operator=(const SharedWorld&) = delete;

  /// Points to the MPI_Comm of the server's ranks.
  const void* communicator() const { return communicator_; }
  /// Tells the simulation where the server listens.
  void tell(const Listening& listening);
  /// Waits until the simulation has ended (gxy_end_world()).
  void awaitEnd();

 private:
  void* communicator_;  ///< an MPI_Comm
};

}  // namespace gxy

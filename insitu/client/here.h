// SPDX-License-Identifier: Apache-2.0
// The server that belongs to this process: it runs in it, or in the same MPI job.
#pragma once
#include <cstdint>
#include <mutex>
#include <string>

namespace gxy::insitu {

/// Where a server listens, and its token.
struct Here {
  std::string host;
  uint16_t port = 0;  ///< 0: there is none
  std::string token;
  std::string problem;  ///< why there is none
};

/// Of this process. Thread safe.
Here here();
void setHere(Here here);

/// Loads libgalaxy_embed, which runs a server in this process, unless that has been done. `mpi` is what the simulation's MPI
/// calls itself. Throws Error, with what was looked for and where, if it cannot be, or was built for another MPI.
void loadEmbedded(const std::string& mpi);
/// A communicator as C and as Fortran have it. One of them is given.
struct Communicator {
  const void* c = nullptr;  ///< points to an MPI_Comm
  const int* fortran = nullptr;
  bool given() const { return c || fortran; }
};
/// Collective over the ranks of `communicator`: starts a server, unless one runs. `options` are those of
/// gxy_open. Sets here(). Returns whether leaveEmbedded() is to be called for this stream.
bool startEmbedded(Communicator communicator, const std::string& options);
/// Counts a stream of it that has ended. With the last one the server ends; that is collective.
void leaveEmbedded();

}  // namespace gxy::insitu

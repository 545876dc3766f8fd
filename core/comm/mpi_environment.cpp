// SPDX-License-Identifier: Apache-2.0
#include "mpi_environment.h"

#include <mpi.h>

#include <string>

#include "error.h"

namespace gxy {

MpiEnvironment::MpiEnvironment() {
  int initialised = 0, level = 0;
  MPI_Initialized(&initialised);
  if (initialised) {
    MPI_Query_thread(&level);
  } else {
    MPI_Init_thread(nullptr, nullptr, MPI_THREAD_SERIALIZED, &level);
    finalises_ = true;
  }
  if (level >= MPI_THREAD_SERIALIZED) return;
  if (finalises_) MPI_Finalize();
  throw Error(
      "MPI runs with thread level " + std::to_string(level) +
      ", expected MPI_THREAD_SERIALIZED, or MPI_THREAD_MULTIPLE when the host program calls MPI as well");
}

MpiEnvironment::~MpiEnvironment() {
  if (finalises_) MPI_Finalize();
}

}  // namespace gxy

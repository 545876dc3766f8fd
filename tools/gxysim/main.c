/* SPDX-License-Identifier: Apache-2.0 */
#include <string.h>

#include "tools/gxysim/gxysim.h"

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  MPI_Comm comm;
  MPI_Comm_dup(MPI_COMM_WORLD, &comm);
  int rank;
  MPI_Comm_rank(comm, &rank);
  gxysim_options options;
  int status = gxysim_parse(argc, argv, rank == 0, &options);
  if (status < 0) {
    if (strcmp(options.simulation, "heat") == 0)
      status = gxysim_heat(comm, &options);
    else if (strcmp(options.simulation, "blobs") == 0)
      status = gxysim_blobs(comm, &options);
    else
      status = gxysim_particles(comm, &options);
  }
  MPI_Comm_free(&comm);
  MPI_Finalize();
  return status;
}

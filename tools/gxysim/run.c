/* SPDX-License-Identifier: Apache-2.0 */
#include <string.h>

#include "tools/gxysim/gxysim.h"

int gxysim_run(MPI_Comm comm, int argc, char** argv) {
  int rank;
  MPI_Comm_rank(comm, &rank);
  gxysim_options options;
  const int status = gxysim_parse(argc, argv, rank == 0, &options);
  if (status >= 0) return status;
  if (strcmp(options.simulation, "heat") == 0) return gxysim_heat(comm, &options);
  if (strcmp(options.simulation, "blobs") == 0) return gxysim_blobs(comm, &options);
  return gxysim_particles(comm, &options);
}

/* What `gxyserver --simulation gxysim -- ARGUMENTS` calls, on each of its ranks. */
int galaxy_simulation(MPI_Comm mine, int argc, char** argv) { return gxysim_run(mine, argc, argv); }

/* SPDX-License-Identifier: Apache-2.0 */
#include <string.h>

#include "insitu/api/galaxy_insitu_mpi.h"
#include "tools/gxysim/gxysim.h"

/* Whether the MPI job has ranks of gxyserver, too: `mpirun -n M gxysim ... --world : -n N gxyserver --world`. */
static int has_server_in_its_world(int argc, char** argv) {
  return argc > 2 && strcmp(argv[argc - 1], "--world") == 0;
}

int main(int argc, char** argv) {
  int level;
  MPI_Init_thread(&argc, &argv, MPI_THREAD_MULTIPLE, &level); /* for a server in these processes */
  const int world = has_server_in_its_world(argc, argv);
  MPI_Comm comm;
  if (world)
    comm = gxy_split_world();
  else
    MPI_Comm_dup(MPI_COMM_WORLD, &comm);
  const int status = gxysim_run(comm, world ? argc - 1 : argc, argv);
  MPI_Comm_free(&comm);
  if (world) gxy_end_world();
  MPI_Finalize();
  return status;
}

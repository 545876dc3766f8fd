/* SPDX-License-Identifier: Apache-2.0 */
#include <string.h>

#include "insitu/api/galaxy_insitu_mpi.h"
#include "tools/gxysim/gxysim.h"

/* Takes --world away. It says that the MPI job has ranks of gxyserver, too: `mpirun -n M gxysim ... --world : -n N gxyserver --world`. */
static int take_world(int* argc, char** argv) {
  for (int i = 1; i < *argc; i++) {
    if (strcmp(argv[i], "--world") != 0) continue;
    memmove(&argv[i], &argv[i + 1], (size_t)(*argc - i) * sizeof *argv);
    (*argc)--;
    return 1;
  }
  return 0;
}

int main(int argc, char** argv) {
  int level;
  MPI_Init_thread(&argc, &argv, MPI_THREAD_MULTIPLE, &level); /* for a server in these processes */
  const int world = take_world(&argc, argv);
  MPI_Comm comm;
  if (world)
    comm = gxy_split_world();
  else
    MPI_Comm_dup(MPI_COMM_WORLD, &comm);
  const int status = gxysim_run(comm, argc, argv);
  MPI_Comm_free(&comm);
  if (world) gxy_end_world();
  MPI_Finalize();
  return status;
}

/* SPDX-License-Identifier: Apache-2.0
 *
 * What simulations with MPI can use beside galaxy_insitu.h, in C or C++. It is compiled with the simulation's own mpi.h, so that the library
 * needs none. docs/insitu.md is the guide. */
#ifndef GALAXY_INSITU_MPI_H
#define GALAXY_INSITU_MPI_H

#include <limits.h>
#include <mpi.h>
#include <string.h>

#include "insitu/api/galaxy_insitu.h"

/* As gxy_open(), with rank and ranks of a communicator. Collective. If "to" is "here", a server runs in these processes from then on, until
 * the last stream that was opened so is closed: gxy_close() is collective then, and comes before MPI_Finalize(). MPI needs
 * MPI_THREAD_MULTIPLE for that. The server uses a communicator of its own, which it makes of this one, and threads that are nicer than the
 * simulation's. If it cannot be started, publishing is off, and gxy_message() says why. */
static inline gxy_sim* gxy_open_mpi(const char* name, MPI_Comm comm, const char* options) {
  char mpi[MPI_MAX_LIBRARY_VERSION_STRING];
  int length, rank, ranks, able[2], all[2];
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &ranks);
  MPI_Get_library_version(mpi, &length);
  able[0] = gxy_prepare_here(options, mpi);
  able[1] = -able[0];
  MPI_Allreduce(able, all, 2, MPI_INT, MPI_MIN, comm);
  if (all[0] == 0 && all[1] == 0) return gxy_open(name, rank, ranks, options);
  return gxy_open_here(name, rank, ranks, options, all[0] == 1 ? &comm : NULL);
}

/* For one MPI world, `mpirun -np M simulation : -np N gxyserver --world`: returns a communicator of the simulation's ranks, which stands in for
 * MPI_COMM_WORLD from then on, and waits until the server listens. Streams go to that server, unless their options say something
 * else. Collective over all ranks of the simulation, once, after MPI_Init(). Only in such a world. */
static inline MPI_Comm gxy_split_world(void) {
  MPI_Comm mine;
  char where[2][512] = {"", ""};
  int rank, server = INT_MAX, root;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_split(MPI_COMM_WORLD, 0, rank, &mine);
  MPI_Allreduce(&server, &root, 1, MPI_INT, MPI_MIN, MPI_COMM_WORLD);
  MPI_Bcast(where, (int)sizeof where, MPI_CHAR, root, MPI_COMM_WORLD);
  gxy_set_here(where[0], where[1]);
  return mine;
}

/* Ends the server of such a world. Collective over all ranks of the simulation, after their last gxy_close() and before
 * MPI_Finalize(). */
static inline void gxy_end_world(void) {
  MPI_Request all;
  MPI_Ibarrier(MPI_COMM_WORLD, &all);
  MPI_Wait(&all, MPI_STATUS_IGNORE);
}

#endif

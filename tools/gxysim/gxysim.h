/* SPDX-License-Identifier: Apache-2.0
 *
 * Small simulations with MPI that publish their steps to Galaxy. Each is one function, which main() calls. It talks to other
 * ranks through the communicator that it is given, and nowhere else. Its results are the same, to the bit, on any number of ranks
 * and with any decomposition, whether or not anybody sees its steps: a value is computed by one expression, wherever it lies.
 *
 * The functions return the program's exit status, the same on all ranks: 0 done, 1 failed, 2 wrong usage. Rank 0 says why. */
#pragma once
#include <mpi.h>
#include <stdint.h>

typedef struct gxysim_options {
  const char* simulation; /* heat, blobs or particles */
  const char* name;       /* of the stream */
  const char* output;     /* file for the last step, or NULL */
  int64_t size[3];        /* points, cells or, all in size[0], particles */
  int blocks[3];          /* ranks along x, y and z; 0: as MPI finds best */
  int64_t steps, every;   /* steps in all; every so many are published */
  double pause;           /* seconds that a step lasts besides its computation */
  double last;            /* seconds to wait for the last step to be published; 0: it is a step like others */
  int sine;               /* heat starts with a sine mode, and nothing else warms it */
} gxysim_options;

/* Runs the simulation that the arguments ask for, and returns the exit status. */
int gxysim_run(MPI_Comm comm, int argc, char** argv);
int galaxy_simulation(MPI_Comm mine, int argc, char** argv);

/* Reads the program's arguments. Returns -1, or the exit status if the program is to end now; `speaks`: with a text. */
int gxysim_parse(int argc, char** argv, int speaks, gxysim_options* options);

int gxysim_heat(MPI_Comm comm, const gxysim_options* options);
int gxysim_blobs(MPI_Comm comm, const gxysim_options* options);
int gxysim_particles(MPI_Comm comm, const gxysim_options* options);

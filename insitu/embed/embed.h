/* SPDX-License-Identifier: Apache-2.0
 *
 * What libgalaxy_embed offers to libgalaxy_insitu, which opens it when a simulation asks for "to": "here". It runs a server in the
 * simulation's own processes. */
#ifndef GALAXY_EMBED_H
#define GALAXY_EMBED_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define GALAXY_EMBED_VERSION 2

/* Texts end with 0. */
typedef struct galaxy_embed_address {
  char host[256];
  uint16_t port;
  char token[256];
  char error[1024];
} galaxy_embed_address;

typedef struct galaxy_embed {
  int version;     /* GALAXY_EMBED_VERSION */
  const char* mpi; /* a part of what MPI_Get_library_version says of the MPI that it was built with */
  /* Collective over the ranks of *communicator, an MPI_Comm, which is duplicated. `options` are those of gxy_open, JSON. 0: `address` says where
   * the server listens; else its `error` says what is wrong, on all ranks. */
  int (*start)(const void* communicator, const char* options, galaxy_embed_address* address);
  /* The same with the communicator as Fortran has it. */
  int (*start_fortran)(int communicator, const char* options, galaxy_embed_address* address);
  /* Collective over the same ranks. Ends the server. */
  void (*stop)(void);
} galaxy_embed;

/* The one symbol of the library in C: `const galaxy_embed galaxy_embed_impl`. */

#ifdef __cplusplus
}
#endif

#endif

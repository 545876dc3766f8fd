/* SPDX-License-Identifier: Apache-2.0
 *
 * A grid of values that is cut into boxes, one for each rank. A rank holds its box with ghost layers around it, x being the
 * fastest. Axes are in the order x, y, z. */
#pragma once
#include <stdio.h>

#include "tools/gxysim/gxysim.h"

typedef struct gxysim_block {
  MPI_Comm comm; /* with the ranks' places in the grid of boxes */
  int rank, ranks, blocks[3], ghosts;
  int64_t size[3];            /* of the whole grid */
  int64_t first[3], count[3]; /* what this rank owns */
  int64_t stride[3];          /* in values, with the ghosts */
  int64_t own, all;           /* where the first owned value lies; how many there are, with the ghosts */
} gxysim_block;

/* Cuts a grid into boxes, for all ranks of `comm`. Returns 0, or 2 with a text if it cannot be cut so. */
int gxysim_cut(MPI_Comm comm, const gxysim_options* options, const int64_t size[3], int ghosts,
               gxysim_block* block);

/* Where the value at a point of the whole grid lies. */
static inline int64_t gxysim_at(const gxysim_block* b, int64_t x, int64_t y, int64_t z) {
  return b->own + (x - b->first[0]) * b->stride[0] + (y - b->first[1]) * b->stride[1] +
         (z - b->first[2]) * b->stride[2];
}

/* Allocates values, all 0. If any rank has no memory, NULL on all, with a text: then free() what a rank has. */
void* gxysim_values(MPI_Comm comm, int64_t count, size_t bytes);

/* Fills the ghosts from the neighbours, those at edges and corners included. Outside the grid they are left as they are. */
void gxysim_exchange(const gxysim_block* block, void* values, MPI_Datatype type);

/* A number from 64 bits that looks random (Steele, Lea and Flood: Fast splittable pseudorandom number generators, 2014). */
uint64_t gxysim_mix(uint64_t bits);

/* The sum of mixed values and places, modulo 2^64, over all ranks: no decomposition changes it. Values of 4 or 8 bytes. */
uint64_t gxysim_checksum(const gxysim_block* block, const void* values, size_t bytes);

/* Writes a .npy file by z, y and x, of float32 or float64. Returns 0, or 1 with a text. */
int gxysim_save(const gxysim_block* block, const void* values, MPI_Datatype type, const char* path);

/* Writes rows to a .npy file, on one rank; `type` is NumPy's, such as "<f8", and `shape` as in "(3, 2)". Returns 0, or 1 with a text. */
int gxysim_write(const char* path, const char* type, const char* shape, const void* values, size_t bytes);

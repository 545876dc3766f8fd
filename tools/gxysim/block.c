/* SPDX-License-Identifier: Apache-2.0 */
#include "tools/gxysim/block.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

/* As many boxes along each axis as MPI finds best, the most along the longest axis. */
static void arrange(int ranks, const int64_t size[3], int blocks[3]) {
  int most[3] = {0, 0, 0}, done[3] = {0, 0, 0};
  MPI_Dims_create(ranks, 3, most);  // in descending order
  for (int i = 0; i < 3; i++) {
    int longest = -1;
    for (int a = 2; a >= 0; a--)
      if (!done[a] && (longest < 0 || size[a] > size[longest])) longest = a;
    blocks[longest] = most[i];
    done[longest] = 1;
  }
}

static void box_of(const gxysim_block* b, int rank, int64_t first[3], int64_t count[3]) {
  int place[3];
  MPI_Cart_coords(b->comm, rank, 3, place);
  for (int a = 0; a < 3; a++) {
    first[a] = b->size[a] * place[a] / b->blocks[a];
    count[a] = b->size[a] * (place[a] + 1) / b->blocks[a] - first[a];
  }
}

int gxysim_cut(MPI_Comm comm, const gxysim_options* options, const int64_t size[3], int ghosts,
               gxysim_block* b) {
  MPI_Comm_rank(comm, &b->rank);
  MPI_Comm_size(comm, &b->ranks);
  b->ghosts = ghosts;
  memcpy(b->size, size, sizeof b->size);
  memcpy(b->blocks, options->blocks, sizeof b->blocks);
  if (b->blocks[0] == 0) arrange(b->ranks, size, b->blocks);
  const int* n = b->blocks;
  if ((int64_t)n[0] * n[1] * n[2] != b->ranks) {
    if (b->rank == 0)
      fprintf(stderr, "gxysim: error: --blocks: expected %d block(s), as many as ranks, found %dx%dx%d\n",
              b->ranks, n[0], n[1], n[2]);
    return 2;
  }
  for (int a = 0; a < 3; a++)
    if (size[a] / n[a] < (ghosts > 0 ? ghosts : 1) || size[a] < 2) {
      if (b->rank == 0)
        fprintf(stderr,
                "gxysim: error: --size: expected more than %lld along %c, which is cut into %d block(s)\n",
                (long long)size[a], "xyz"[a], n[a]);
      return 2;
    }
  MPI_Cart_create(comm, 3, n, (int[]){0, 0, 0}, 0, &b->comm);
  box_of(b, b->rank, b->first, b->count);
  b->all = 1;
  b->own = 0;
  for (int a = 0; a < 3; a++) {
    b->stride[a] = b->all;
    b->own += ghosts * b->all;
    b->all *= b->count[a] + 2 * ghosts;
  }
  return 0;
}

void* gxysim_values(MPI_Comm comm, int64_t count, size_t bytes) {
  void* values = calloc((size_t)count + 1, bytes);
  int missing = !values, any, rank;
  MPI_Allreduce(&missing, &any, 1, MPI_INT, MPI_MAX, comm);
  MPI_Comm_rank(comm, &rank);
  if (!any) return values;
  if (rank == 0) fprintf(stderr, "gxysim: error: no memory for %lld values of a rank\n", (long long)count);
  free(values);
  return NULL;
}

/* A box within an array, all in the order x, y, z. */
static MPI_Datatype part(const int64_t all[3], const int64_t first[3], const int64_t count[3],
                         MPI_Datatype type) {
  int sizes[3], starts[3], counts[3];
  for (int a = 0; a < 3; a++) sizes[a] = (int)all[a], starts[a] = (int)first[a], counts[a] = (int)count[a];
  MPI_Datatype made;
  MPI_Type_create_subarray(3, sizes, counts, starts, MPI_ORDER_FORTRAN, type, &made);
  MPI_Type_commit(&made);
  return made;
}

/* As many layers as there are ghosts, from layer `begin` on, with all ghosts of the other axes. */
static MPI_Datatype layers(const gxysim_block* b, int axis, int64_t begin, MPI_Datatype type) {
  int64_t all[3], first[3] = {0, 0, 0}, count[3];
  for (int a = 0; a < 3; a++) all[a] = count[a] = b->count[a] + 2 * b->ghosts;
  first[axis] = begin;
  count[axis] = b->ghosts;
  return part(all, first, count, type);
}

void gxysim_exchange(const gxysim_block* b, void* values, MPI_Datatype type) {
  for (int axis = 0; axis < 3; axis++) {
    // The ghosts of the axes before travel along: so they come round corners.
    int below, above;
    MPI_Cart_shift(b->comm, axis, 1, &below, &above);
    MPI_Datatype ghosts[2] = {layers(b, axis, 0, type), layers(b, axis, b->ghosts + b->count[axis], type)};
    MPI_Datatype own[2] = {layers(b, axis, b->ghosts, type), layers(b, axis, b->count[axis], type)};
    MPI_Sendrecv(values, 1, own[0], below, 0, values, 1, ghosts[1], above, 0, b->comm, MPI_STATUS_IGNORE);
    MPI_Sendrecv(values, 1, own[1], above, 1, values, 1, ghosts[0], below, 1, b->comm, MPI_STATUS_IGNORE);
    for (int i = 0; i < 2; i++) MPI_Type_free(&ghosts[i]), MPI_Type_free(&own[i]);
  }
}

uint64_t gxysim_mix(uint64_t bits) {
  bits += 0x9e3779b97f4a7c15u;
  bits = (bits ^ (bits >> 30)) * 0xbf58476d1ce4e5b9u;
  bits = (bits ^ (bits >> 27)) * 0x94d049bb133111ebu;
  return bits ^ (bits >> 31);
}

uint64_t gxysim_checksum(const gxysim_block* b, const void* values, size_t bytes) {
  uint64_t sum = 0, total = 0;
  for (int64_t z = b->first[2]; z < b->first[2] + b->count[2]; z++)
    for (int64_t y = b->first[1]; y < b->first[1] + b->count[1]; y++)
      for (int64_t x = b->first[0]; x < b->first[0] + b->count[0]; x++) {
        const char* at = (const char*)values + bytes * (size_t)gxysim_at(b, x, y, z);
        uint32_t bits32 = 0;
        uint64_t bits = 0;
        if (bytes == 4)
          memcpy(&bits32, at, 4), bits = bits32;
        else
          memcpy(&bits, at, 8);
        sum += gxysim_mix(bits ^ gxysim_mix((uint64_t)(x + b->size[0] * (y + b->size[1] * z))));
      }
  MPI_Allreduce(&sum, &total, 1, MPI_UINT64_T, MPI_SUM, b->comm);
  return total;
}

int gxysim_write(const char* path, const char* type, const char* shape, const void* values, size_t bytes) {
  char header[128];  // magic, version 1.0, length of what follows, a Python literal that ends in a new line
  memcpy(header, "\x93NUMPY\x01\x00\x76\x00", 10);
  const int length = snprintf(header + 10, sizeof header - 10,
                              "{'descr': '%s', 'fortran_order': False, 'shape': %s, }", type, shape);
  memset(header + 10 + length, ' ', sizeof header - 11 - (size_t)length);
  header[sizeof header - 1] = '\n';
  FILE* file = fopen(path, "wb");
  int good = file && fwrite(header, sizeof header, 1, file) == 1 && fwrite(values, 1, bytes, file) == bytes;
  if (file) good = fclose(file) == 0 && good;
  if (!good) fprintf(stderr, "gxysim: error: %s: cannot be written: %s\n", path, strerror(errno));
  return !good;
}

int gxysim_save(const gxysim_block* b, const void* values, MPI_Datatype type, const char* path) {
  int64_t all[3], ghosts[3] = {b->ghosts, b->ghosts, b->ghosts}, first[3], count[3];
  for (int a = 0; a < 3; a++) all[a] = b->count[a] + 2 * b->ghosts;
  int bytes, failed = 0;
  MPI_Type_size(type, &bytes);
  const int64_t whole = b->size[0] * b->size[1] * b->size[2];
  char* received = gxysim_values(b->comm, b->rank == 0 ? whole : 0, (size_t)bytes);
  if (!received) return 1;
  MPI_Request sent;
  MPI_Datatype own = part(all, ghosts, b->count, type);
  MPI_Isend(values, 1, own, 0, 2, b->comm, &sent);
  for (int rank = 0; rank < b->ranks && b->rank == 0; rank++) {
    box_of(b, rank, first, count);
    MPI_Datatype box = part(b->size, first, count, type);
    MPI_Recv(received, 1, box, rank, 2, b->comm, MPI_STATUS_IGNORE);
    MPI_Type_free(&box);
  }
  MPI_Wait(&sent, MPI_STATUS_IGNORE);
  MPI_Type_free(&own);
  if (b->rank == 0) {
    char shape[64];
    snprintf(shape, sizeof shape, "(%lld, %lld, %lld)", (long long)b->size[2], (long long)b->size[1],
             (long long)b->size[0]);
    failed = gxysim_write(path, bytes == 4 ? "<f4" : "<f8", shape, received, (size_t)whole * (size_t)bytes);
  }
  free(received);
  MPI_Bcast(&failed, 1, MPI_INT, 0, b->comm);
  return failed;
}

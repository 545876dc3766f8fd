/* SPDX-License-Identifier: Apache-2.0
 *
 * Bodies that orbit a mass in the middle, a softened point (Plummer): acceleration -x / (|x|^2 + 0.01)^(3/2), by leapfrog steps. They do not
 * feel each other, so that each moves the same whatever rank it is on. The cube from -4 to 4 is cut into boxes, and a body moves to
 * the rank in whose box it is. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tools/gxysim/block.h"
#include "tools/gxysim/stream.h"

typedef struct body {
  double x[3], v[3], speed;
  int64_t id;
} body;

typedef struct bodies {
  body *list, *other;         /* `other`: room for a move. Both have `room` bodies. */
  int64_t count, room, moves; /* moves: to other ranks, so far */
  int* counts;                /* by rank: to send, begins there, to receive, begins there */
  MPI_Datatype type;
} bodies;

static double between(uint64_t* random, double least, double most) {
  *random = gxysim_mix(*random);
  return least + (most - least) * ((double)(*random >> 11) / 9007199254740992.0);
}

/* Body number `id` at first: on an orbit whose plane is tilted a little, at its farthest point. */
static body made(int64_t id) {
  uint64_t random = (uint64_t)id;
  const double r = between(&random, 0.4, 3), angle = between(&random, 0, 6.283185307179586),
               tilt = between(&random, -0.3, 0.3), s = r * r + 0.01;
  const double speed = between(&random, 0.8, 1) * sqrt(r * r / (s * sqrt(s)));
  const double along[2] = {cos(angle), sin(angle)}, up[2] = {cos(tilt), sin(tilt)};
  return (body){{r * along[0], r * along[1] * up[0], r * along[1] * up[1]},
                {-speed * along[1], speed * along[0] * up[0], speed * along[0] * up[1]},
                speed,
                id};
}

static void kick(body* p, double dt) {
  const double s = (p->x[0] * p->x[0] + p->x[1] * p->x[1] + p->x[2] * p->x[2]) + 0.01;
  const double pull = dt / (s * sqrt(s));
  for (int a = 0; a < 3; a++) p->v[a] -= pull * p->x[a];
}

static void advance(body* p, double dt) {
  kick(p, 0.5 * dt);
  for (int a = 0; a < 3; a++) p->x[a] += dt * p->v[a];
  kick(p, 0.5 * dt);
  p->speed = sqrt(p->v[0] * p->v[0] + p->v[1] * p->v[1] + p->v[2] * p->v[2]);
}

static int owner(const gxysim_block* b, const body* p) {
  int place[3], rank;
  for (int a = 0; a < 3; a++) {
    const double n = floor((p->x[a] + 4) / 8 * b->blocks[a]);
    place[a] = n < 0 ? 0 : n < b->blocks[a] ? (int)n : b->blocks[a] - 1;
  }
  MPI_Cart_rank(b->comm, place, &rank);
  return rank;
}

/* Sends each body to the rank that owns its place. Returns 0, or 1 if a rank has no memory. */
static int move(const gxysim_block* b, bodies* all) {
  int *send = all->counts, *from = send + b->ranks, *receive = from + b->ranks, *to = receive + b->ranks;
  memset(send, 0, sizeof(int) * (size_t)b->ranks);
  for (int64_t i = 0; i < all->count; i++) send[owner(b, &all->list[i])]++;
  MPI_Alltoall(send, 1, MPI_INT, receive, 1, MPI_INT, b->comm);
  from[0] = to[0] = 0;
  for (int r = 1; r < b->ranks; r++) from[r] = from[r - 1] + send[r - 1], to[r] = to[r - 1] + receive[r - 1];
  for (int64_t i = 0; i < all->count; i++) all->other[from[owner(b, &all->list[i])]++] = all->list[i];
  for (int r = 0; r < b->ranks; r++) from[r] -= send[r];
  all->moves += all->count - send[b->rank];
  const int64_t count = to[b->ranks - 1] + receive[b->ranks - 1];
  int more = count > all->room, any;
  MPI_Allreduce(&more, &any, 1, MPI_INT, MPI_MAX, b->comm);
  if (any) {  // The list has been copied: its values are needed no longer.
    const int64_t room = count > all->room ? count + count / 4 : all->room;
    body* list = gxysim_values(b->comm, room, sizeof(body));
    body* other = gxysim_values(b->comm, room, sizeof(body));
    if (!list || !other) return free(list), free(other), 1;
    memcpy(other, all->other, sizeof(body) * (size_t)all->count);
    free(all->list);
    free(all->other);
    all->list = list;
    all->other = other;
    all->room = room;
  }
  MPI_Alltoallv(all->other, send, from, all->type, all->list, receive, to, all->type, b->comm);
  all->count = count;
  return 0;
}

/* What all bodies have, for the interface: an array that goes from body to body. */
static gxy_array of_all(const void* first, int type, int components) {
  return (gxy_array){first, type, components, {sizeof(body), 0, 0}, 0, 0};
}

/* Says where the bodies are now, and where in memory. */
static void describe(gxy_sim* sim, const bodies* all) {
  static const double box[6] = {-4, -4, -4, 4, 4, 4};
  const body* p = all->list;
  gxy_points(sim, "bodies", all->count, of_all(p->x, GXY_FLOAT64, 3), of_all(&p->id, GXY_INT64, 1), box);
  gxy_field(sim, "bodies", 0, "speed", GXY_OF_POINTS, of_all(&p->speed, GXY_FLOAT64, 1));
  gxy_field(sim, "bodies", 0, "velocity", GXY_OF_POINTS, of_all(p->v, GXY_FLOAT64, 3));
}

static uint64_t checksum(const gxysim_block* b, const bodies* all) {
  uint64_t sum = 0, total, bits[6];
  for (int64_t i = 0; i < all->count; i++) {
    memcpy(bits, all->list[i].x, sizeof bits / 2);
    memcpy(bits + 3, all->list[i].v, sizeof bits / 2);
    for (uint64_t c = 0; c < 6; c++)
      sum += gxysim_mix(bits[c] ^ gxysim_mix(6 * (uint64_t)all->list[i].id + c));
  }
  MPI_Allreduce(&sum, &total, 1, MPI_UINT64_T, MPI_SUM, b->comm);
  return total;
}

/* Writes a row for each body, by id: position and velocity. Returns 0, or 1 with a text. */
static int save(const gxysim_block* b, const bodies* all, int64_t size, const char* path) {
  int *counts = all->counts, *begins = counts + b->ranks, count = (int)all->count, failed = 0;
  const int64_t here = b->rank == 0 ? size : 0;
  body* list = gxysim_values(b->comm, here, sizeof(body));
  double* rows = gxysim_values(b->comm, 6 * here, sizeof(double));
  if (list && rows) {
    MPI_Gather(&count, 1, MPI_INT, counts, 1, MPI_INT, 0, b->comm);
    begins[0] = 0;
    for (int r = 1; r < b->ranks; r++) begins[r] = begins[r - 1] + counts[r - 1];
    MPI_Gatherv(all->list, count, all->type, list, counts, begins, all->type, 0, b->comm);
    for (int64_t i = 0; i < here; i++) {
      memcpy(rows + 6 * list[i].id, list[i].x, sizeof list[i].x);
      memcpy(rows + 6 * list[i].id + 3, list[i].v, sizeof list[i].v);
    }
    char shape[64];
    snprintf(shape, sizeof shape, "(%lld, 6)", (long long)size);
    if (b->rank == 0) failed = gxysim_write(path, "<f8", shape, rows, 48 * (size_t)size);
    MPI_Bcast(&failed, 1, MPI_INT, 0, b->comm);
  }
  failed = failed || !list || !rows;
  free(list);
  free(rows);
  return failed;
}

int gxysim_particles(MPI_Comm comm, const gxysim_options* options) {
  const double dt = 0.01;
  const int64_t size = options->size[0], flat[3] = {1 << 22, 1 << 21, 1 << 20};  // to be cut along x first
  gxysim_block b;
  int status = gxysim_cut(comm, options, flat, 0, &b);
  if (status) return status;
  const int64_t first = size * b.rank / b.ranks, count = size * (b.rank + 1) / b.ranks - first;
  bodies all = {NULL, NULL, count, count, 0, NULL, MPI_DATATYPE_NULL};
  MPI_Type_contiguous(sizeof(body), MPI_BYTE, &all.type);
  MPI_Type_commit(&all.type);
  all.list = gxysim_values(b.comm, all.room, sizeof(body));
  all.other = gxysim_values(b.comm, all.room, sizeof(body));
  all.counts = gxysim_values(b.comm, 4 * (int64_t)b.ranks, sizeof(int));
  status = !all.list || !all.other || !all.counts;
  if (!status) {
    for (int64_t i = 0; i < count; i++) all.list[i] = made(first + i);
    status = move(&b, &all);
    all.moves = 0;
    gxy_sim* sim = gxysim_open(b.comm, options);
    for (int64_t step = 1; step <= options->steps && !status; step++) {
      for (int64_t i = 0; i < all.count; i++) advance(&all.list[i], dt);
      status = move(&b, &all);
      if (status) break;
      describe(sim, &all);
      gxysim_step(sim, options, step, (double)step * dt);
    }
    if (status) {
      gxy_close(sim, 0);
    } else {
      int64_t moves;
      MPI_Reduce(&all.moves, &moves, 1, MPI_INT64_T, MPI_SUM, 0, b.comm);
      if (b.rank == 0) printf("%s: %lld move(s) between ranks\n", options->name, (long long)moves);
      if (options->output) status = save(&b, &all, size, options->output);
      gxysim_end(sim, b.comm, options, (double)options->steps * dt, checksum(&b, &all));
    }
  }
  free(all.list);
  free(all.other);
  free(all.counts);
  MPI_Type_free(&all.type);
  MPI_Comm_free(&b.comm);
  return status;
}

/* SPDX-License-Identifier: Apache-2.0
 *
 * The heat equation dT/dt = Laplacian of T + q in the unit cube, on points: explicit Euler steps with the 7-point stencil, of
 * second order in space and of first order in time. Faces are cold, the floor is warm, and two balls are heated.
 * gxysim_heat.f90 is the same in Fortran: what is changed here is changed there. */
#include <math.h>
#include <stdlib.h>

#include "tools/gxysim/block.h"
#include "tools/gxysim/stream.h"

/* How strongly a ball with this centre heats a point. */
static double ball(double x, double y, double z, double cx, double cy, double cz, double radius) {
  const double d = ((x - cx) * (x - cx) + (y - cy) * (y - cy)) + (z - cz) * (z - cz);
  const double s = 1 - d / (radius * radius);
  return s > 0 ? 64 * (s * s) : 0;
}

/* The temperature at first, and the heat that comes in. */
static void start(const gxysim_block* b, int sine, double* t, double* q) {
  const double pi = 3.14159265358979323846;
  for (int64_t k = b->first[2]; k < b->first[2] + b->count[2]; k++)
    for (int64_t j = b->first[1]; j < b->first[1] + b->count[1]; j++)
      for (int64_t i = b->first[0]; i < b->first[0] + b->count[0]; i++) {
        const double x = (double)i / (double)(b->size[0] - 1), y = (double)j / (double)(b->size[1] - 1),
                     z = (double)k / (double)(b->size[2] - 1);
        const int64_t n = gxysim_at(b, i, j, k);
        t[n] = sine     ? sin(pi * x) * sin(pi * y) * sin(pi * z)
               : k == 0 ? 8 * ((x * (1 - x)) * (y * (1 - y)))
                        : 0;
        q[n] = sine ? 0 : ball(x, y, z, 0.3, 0.4, 0.6, 0.2) + ball(x, y, z, 0.7, 0.65, 0.4, 0.15);
      }
}

/* One step for all points that this rank owns, but for those on the faces. c: time step / spacing squared. */
static void advance(const gxysim_block* b, const double* t, const double* q, const double c[3], double dt,
                    double* next) {
  int64_t begin[3], end[3];
  for (int a = 0; a < 3; a++) {
    begin[a] = b->first[a] > 0 ? b->first[a] : 1;
    end[a] = b->first[a] + b->count[a] < b->size[a] ? b->first[a] + b->count[a] : b->size[a] - 1;
  }
  const int64_t y = b->stride[1], z = b->stride[2];
  for (int64_t k = begin[2]; k < end[2]; k++)
    for (int64_t j = begin[1]; j < end[1]; j++)
      for (int64_t i = begin[0], n = gxysim_at(b, i, j, k); i < end[0]; i++, n++) {
        const double two = 2 * t[n];
        const double flow = (c[0] * ((t[n - 1] + t[n + 1]) - two) + c[1] * ((t[n - y] + t[n + y]) - two)) +
                            c[2] * ((t[n - z] + t[n + z]) - two);
        next[n] = t[n] + (flow + dt * q[n]);
      }
}

int gxysim_heat(MPI_Comm comm, const gxysim_options* options) {
  gxysim_block b;
  int status = gxysim_cut(comm, options, options->size, 1, &b);
  if (status) return status;
  double* values = gxysim_values(b.comm, 3 * b.all, sizeof(double));
  if (values) {
    double *t = values, *next = t + b.all, *q = next + b.all, c[3], spacing[3];
    for (int a = 0; a < 3; a++) {
      spacing[a] = 1 / (double)(b.size[a] - 1);
      c[a] = (double)(b.size[a] - 1) * (double)(b.size[a] - 1);
    }
    const double dt = 0.45 / ((c[0] + c[1]) + c[2]);  // stable up to 0.5
    for (int a = 0; a < 3; a++) c[a] = dt * c[a];
    start(&b, options->sine, t, q);
    start(&b, options->sine, next, q);

    gxy_sim* sim = gxysim_open(b.comm, options);
    gxy_grid(sim, "grid", 0, GXY_OF_POINTS, b.size, b.first, b.count, (double[]){0, 0, 0}, spacing);
    for (int64_t step = 1; step <= options->steps; step++) {
      gxysim_exchange(&b, t, MPI_DOUBLE);
      advance(&b, t, q, c, dt, next);
      double* const before = t;
      t = next;
      next = before;
      const gxy_array array = {t + b.own, GXY_FLOAT64, 1, {8, 8 * b.stride[1], 8 * b.stride[2]}, 0, 0};
      gxy_field(sim, "grid", 0, "temperature", GXY_OF_POINTS, array);
      gxysim_step(sim, options, step, (double)step * dt);
    }
    if (options->output) status = gxysim_save(&b, t, MPI_DOUBLE, options->output);
    gxysim_end(sim, b.comm, options, (double)options->steps * dt, gxysim_checksum(&b, t, sizeof(double)));
  }
  const int failed = !values || status;
  free(values);
  MPI_Comm_free(&b.comm);
  return failed;
}

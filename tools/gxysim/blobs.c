/* SPDX-License-Identifier: Apache-2.0
 *
 * Clouds that a steady flow carries through the unit cube, on cells: d(density)/dt + div(velocity * density) = 0. In space, lines
 * within cells with van Leer's limiter (Towards the ultimate conservative difference scheme II, 1974), which need two ghost layers; in
 * time, Heun's method. The order is 2 where the density is smooth, and no density becomes negative.
 *
 * The velocity is the curl of (0, p(x) p(z), p(x) p(y)) with p(s) = (4 s (1 - s))^2, taken on the edges of cells: as much flows into
 * a cell as out of it, and nothing through the walls. */
#include <math.h>
#include <stdlib.h>

#include "tools/gxysim/block.h"
#include "tools/gxysim/stream.h"

/* By axis and face: p, and its difference to the next face over the spacing. */
typedef struct flow {
  double *p[3], *slope[3];
} flow;

static void make_flow(const gxysim_block* b, double* values, flow* f) {
  for (int a = 0; a < 3; a++) {
    const int64_t n = b->size[a];
    f->p[a] = values, f->slope[a] = values + n + 1, values += 2 * n + 1;
    for (int64_t i = 0; i <= n; i++) {
      const double s = (double)i / (double)n, q = 4 * s * (1 - s);
      f->p[a][i] = q * q;
    }
    for (int64_t i = 0; i < n; i++) f->slope[a][i] = (f->p[a][i + 1] - f->p[a][i]) * (double)n;
  }
}

/* The velocity through the lower face of cell i, j, k along an axis. i may be one more than the last cell's along that axis. */
static double along(const flow* f, int axis, int64_t i, int64_t j, int64_t k) {
  if (axis == 0) return f->p[0][i] * (f->slope[1][j] - f->slope[2][k]);
  return axis == 1 ? -f->p[1][j] * f->slope[0][i] : f->p[2][k] * f->slope[0][i];
}

static double limited(double left, double right) {
  return left * right > 0 ? 2 * (left * right) / (left + right) : 0;
}

/* The density at the lower face of the cell at `d`, whose neighbours are a stride apart, as it comes with the flow. */
static double carried(const float* d, int64_t stride, double velocity) {
  const double a = d[-2 * stride], b = d[-stride], c = d[0], e = d[stride];
  return velocity >= 0 ? b + 0.5 * limited(b - a, c - b) : c - 0.5 * limited(c - b, e - c);
}

static void start(const gxysim_block* b, const flow* f, float* density, float* velocity) {
  static const double blob[3][5] = {
      {0.3, 0.5, 0.5, 0.1, 1}, {0.65, 0.7, 0.4, 0.08, 0.8}, {0.6, 0.3, 0.7, 0.07, 0.9}};
  int64_t cell = 0, cells = b->count[0] * b->count[1] * b->count[2];
  for (int64_t k = b->first[2]; k < b->first[2] + b->count[2]; k++)
    for (int64_t j = b->first[1]; j < b->first[1] + b->count[1]; j++)
      for (int64_t i = b->first[0]; i < b->first[0] + b->count[0]; i++, cell++) {
        double sum = 0,
               at[3] = {((double)i + 0.5) / (double)b->size[0], ((double)j + 0.5) / (double)b->size[1],
                        ((double)k + 0.5) / (double)b->size[2]};
        for (int n = 0; n < 3; n++) {
          double r = 0;
          for (int a = 0; a < 3; a++) r += (at[a] - blob[n][a]) * (at[a] - blob[n][a]);
          sum += blob[n][4] * exp(-0.5 * r / (blob[n][3] * blob[n][3]));
        }
        density[gxysim_at(b, i, j, k)] = (float)sum;
        for (int a = 0; a < 3; a++)
          velocity[a * cells + cell] =
              (float)(0.5 * (along(f, a, i, j, k) + along(f, a, i + (a == 0), j + (a == 1), k + (a == 2))));
      }
}

/* An Euler step; with `before`, the mean of it and that. */
static void advance(const gxysim_block* b, const flow* f, const float* density, const float* before,
                    double dt, float* next) {
  for (int64_t k = b->first[2]; k < b->first[2] + b->count[2]; k++)
    for (int64_t j = b->first[1]; j < b->first[1] + b->count[1]; j++)
      for (int64_t i = b->first[0]; i < b->first[0] + b->count[0]; i++) {
        const int64_t n = gxysim_at(b, i, j, k);
        double out = 0;
        for (int a = 0; a < 3; a++) {
          const double below = along(f, a, i, j, k);
          const double above = along(f, a, i + (a == 0), j + (a == 1), k + (a == 2));
          out += (double)b->size[a] * (above * carried(density + n + b->stride[a], b->stride[a], above) -
                                       below * carried(density + n, b->stride[a], below));
        }
        const double stepped = density[n] - dt * out;
        next[n] = (float)(before ? 0.5 * (before[n] + stepped) : stepped);
      }
}

int gxysim_blobs(MPI_Comm comm, const gxysim_options* options) {
  gxysim_block b;
  int status = gxysim_cut(comm, options, options->size, 2, &b);
  if (status) return status;
  const int64_t cells = b.count[0] * b.count[1] * b.count[2];
  float* values = gxysim_values(b.comm, 3 * b.all + 3 * cells, sizeof(float));
  double* faces = gxysim_values(b.comm, 2 * (b.size[0] + b.size[1] + b.size[2]) + 3, sizeof(double));
  if (values && faces) {
    float *density = values, *half = density + b.all, *next = half + b.all, *velocity = next + b.all;
    flow f;
    make_flow(&b, faces, &f);
    start(&b, &f, density, velocity);
    // The slopes of p are below 3.1. All axes together, the flow goes less than half a cell in a step.
    const double dt = 0.5 / (6.2 * (double)b.size[0] + 3.1 * (double)b.size[1] + 3.1 * (double)b.size[2]);

    gxy_sim* sim = gxysim_open(b.comm, options);
    const double spacing[3] = {1 / (double)b.size[0], 1 / (double)b.size[1], 1 / (double)b.size[2]};
    gxy_grid(sim, "grid", 0, GXY_OF_CELLS, b.size, b.first, b.count, (double[]){0, 0, 0}, spacing);
    const gxy_array flows = {
        velocity, GXY_FLOAT32, 3, {4, 4 * b.count[0], 4 * b.count[0] * b.count[1]}, 4 * cells, 0};
    gxy_field(sim, "grid", 0, "velocity", GXY_OF_CELLS, flows);  // an array for each component
    for (int64_t step = 1; step <= options->steps; step++) {
      gxysim_exchange(&b, density, MPI_FLOAT);
      advance(&b, &f, density, NULL, dt, half);
      gxysim_exchange(&b, half, MPI_FLOAT);
      advance(&b, &f, half, density, dt, next);
      float* const before = density;
      density = next;
      next = before;
      const gxy_array array = {density + b.own, GXY_FLOAT32, 1, {4, 4 * b.stride[1], 4 * b.stride[2]}, 0, 0};
      gxy_field(sim, "grid", 0, "density", GXY_OF_CELLS, array);
      gxysim_step(sim, options, step, (double)step * dt);
    }
    if (options->output) status = gxysim_save(&b, density, MPI_FLOAT, options->output);
    gxysim_end(sim, b.comm, options, (double)options->steps * dt,
               gxysim_checksum(&b, density, sizeof(float)));
  }
  const int failed = !values || !faces || status;
  free(values);
  free(faces);
  MPI_Comm_free(&b.comm);
  return failed;
}

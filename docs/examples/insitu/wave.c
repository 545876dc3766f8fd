/* SPDX-License-Identifier: Apache-2.0 */
#include <mpi.h>
#include "insitu/api/galaxy_insitu.h"

static double height[32][40][48]; /* by z, y and x; each rank has a slab of it, along z */
static double cubic(double x) { return x - x * x * x; }

int main(int argc, char** argv) {
  int rank, ranks;
  MPI_Init(&argc, &argv), MPI_Comm_rank(MPI_COMM_WORLD, &rank), MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  const int64_t begin = 32 * rank / ranks, end = 32 * (rank + 1) / ranks;
  const int64_t size[3] = {48, 40, 32}, first[3] = {0, 0, begin}, count[3] = {48, 40, end - begin};
  const gxy_array values = {height[begin], GXY_FLOAT64, 1, {8, 8 * 48, 8 * 48 * 40}, 0, 0};

  gxy_sim* sim = gxy_open("wave", rank, ranks, NULL);
  gxy_grid(sim, "grid", 0, GXY_OF_POINTS, size, first, count, (double[]){0, 0, 0}, (double[]){1, 1, 1});
  gxy_field(sim, "grid", 0, "height", GXY_OF_POINTS, values);
  for (int step = 1; step <= 8; step++) {
    for (int64_t n = begin * 48 * 40; n < end * 48 * 40; n++)
      height[0][0][n] = cubic(0.03125 * (n % 48 - 3 * step)) + 0.03125 * (n / 48 % 40 - n / 1920);
    (step < 8 ? gxy_publish : gxy_publish_last)(sim, step, 0.125 * step);
  }
  gxy_close(sim, 10), MPI_Finalize();
}

// SPDX-License-Identifier: Apache-2.0
#include <mpi.h>

#include <vector>

#include "insitu/api/galaxy_insitu.hpp"

int main(int argc, char** argv) {
  int rank, ranks;
  MPI_Init(&argc, &argv), MPI_Comm_rank(MPI_COMM_WORLD, &rank), MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  const int begin = 32 * rank / ranks, layers = 32 * (rank + 1) / ranks - begin;
  std::vector<double> height(48 * 40 * layers);  // each rank has a slab along z; x is the fastest

  gxy::Simulation sim("wave", rank, ranks);
  sim.grid({{48, 40, 32}}, {{0, 0, begin}}, {{48, 40, layers}});
  sim.field("height", gxy::values(height.data(), {{48, 40, layers}}));
  for (int step = 1; step <= 8; step++) {
    for (int n = 0; n < 48 * 40 * layers; n++) {
      const double x = 0.03125 * (n % 48 - 3 * step), y = n / 48 % 40, z = n / 1920 + begin;
      height[n] = x - x * x * x + 0.03125 * (y - z);
    }
    step < 8 ? sim.publish(step, 0.125 * step) : sim.publishLast(step, 0.125 * step);
  }
  sim.close(10), MPI_Finalize();
}

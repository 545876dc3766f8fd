/* SPDX-License-Identifier: Apache-2.0 */
#define _POSIX_C_SOURCE 200809L
#include "tools/gxysim/stream.h"

#include "insitu/api/galaxy_insitu_mpi.h"

#include <stdio.h>
#include <time.h>

gxy_sim* gxysim_open(MPI_Comm comm, const gxysim_options* options) {
  return gxy_open_mpi(options->name, comm, NULL);
}

int gxysim_offers(const gxysim_options* options, int64_t step) {
  return step % options->every == 0 || step == options->steps;
}

void gxysim_step(gxy_sim* sim, const gxysim_options* options, int64_t step, double time) {
  if (gxysim_offers(options, step))
    (step == options->steps && options->last > 0 ? gxy_publish_last : gxy_publish)(sim, step, time);
  const struct timespec pause = {(time_t)options->pause,
                                 (long)(1e9 * (options->pause - (double)(time_t)options->pause))};
  if (options->pause > 0) nanosleep(&pause, NULL);
}

void gxysim_end(gxy_sim* sim, MPI_Comm comm, const gxysim_options* options, double time, uint64_t checksum) {
  int rank;
  MPI_Comm_rank(comm, &rank);
  if (rank == 0) {
    char message[512];
    snprintf(message, sizeof message, "%s", gxy_message(sim));
    gxy_stat n;
    gxy_statistics(sim, &n);
    printf("%s: step %lld, time %.9g, checksum %016llx\n", options->name, (long long)options->steps, time,
           (unsigned long long)checksum);
    printf("%s: %lld step(s) offered, %lld taken, %lld published%s%s%s\n", options->name,
           (long long)n.offered, (long long)n.taken, (long long)n.published,
           options->last > 0 && n.offered > 0 ? " before the last" : "", *message ? ": " : "", message);
    fflush(stdout);
  }
  gxy_close(sim, options->last);
}

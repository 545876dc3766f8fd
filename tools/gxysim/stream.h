/* SPDX-License-Identifier: Apache-2.0
 *
 * The stream of a simulation's steps, as its options say. */
#pragma once
#include "insitu/api/galaxy_insitu.h"
#include "tools/gxysim/gxysim.h"

gxy_sim* gxysim_open(MPI_Comm comm, const gxysim_options* options);

/* Whether this step is one of those that are published. */
int gxysim_offers(const gxysim_options* options, int64_t step);

/* Publishes the step, if it is one of those, and pauses. */
void gxysim_step(gxy_sim* sim, const gxysim_options* options, int64_t step, double time);

/* Prints the result and what has become of the steps, on rank 0, and ends the stream. */
void gxysim_end(gxy_sim* sim, MPI_Comm comm, const gxysim_options* options, double time, uint64_t checksum);

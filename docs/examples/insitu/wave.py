# SPDX-License-Identifier: Apache-2.0
import numpy as np
from mpi4py import MPI
from gxy.insitu import Simulation

rank, ranks = MPI.COMM_WORLD.Get_rank(), MPI.COMM_WORLD.Get_size()
begin, end = 32 * rank // ranks, 32 * (rank + 1) // ranks
k, j, i = np.ogrid[begin:end, 0:40, 0:48]
height = np.empty((end - begin, 40, 48))  # by z, y and x; each rank has a slab along z

with Simulation("wave", MPI.COMM_WORLD) as sim:
    sim.grid(size=(48, 40, 32), first=(0, 0, begin), count=(48, 40, end - begin))
    sim.field("height", height)
    for step in range(1, 9):
        x = 0.03125 * (i - 3 * step)
        height[:] = x - x * x * x + 0.03125 * (j - k)
        if step < 8:
            sim.publish(step, 0.125 * step)
    sim.publish_last(step, 0.125 * step)
    sim.close(10)

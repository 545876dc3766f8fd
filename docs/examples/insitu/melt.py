# SPDX-License-Identifier: Apache-2.0
import sys
from lammps import lammps
from mpi4py import MPI
from gxy.insitu import Simulation

lmp = lammps(cmdargs=["-log", "none"])
lmp.file(sys.argv[1])  # an input script without its `run`
box = lmp.extract_box()[:2]
sim = Simulation("lammps", MPI.COMM_WORLD)

def publish(*_):  # LAMMPS calls it at the end of each step
    step = lmp.extract_global("ntimestep")
    x, v, ids = (lmp.numpy.extract_atom(name) for name in ("x", "v", "id"))
    sim.points("atoms", x, ids=ids, box=box, velocity=v)
    sim.publish(step, step * lmp.extract_global("dt"))

lmp.command("fix galaxy all python/invoke 1 end_of_step publish")
lmp.command("run " + sys.argv[2])
sim.close()

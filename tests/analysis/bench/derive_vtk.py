#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Prints the processor time that VTK takes for what derive_benchmark measures, in ns a point. Usage: derive_vtk.py [POINTS PER AXIS]"""
import sys
import time

import numpy as np
import vtk
from vtk.util.numpy_support import numpy_to_vtk

vtk.vtkSMPTools.SetBackend("Sequential")
n = int(sys.argv[1]) if len(sys.argv) > 1 else 256
point = 0.001 * (np.arange(n**3) % 100003)
image = vtk.vtkImageData()
image.SetDimensions(n, n, n)
image.SetSpacing(1 / (n - 1), 1 / (n - 1), 1 / (n - 1))
for name, values in (("s", np.sin(point)), ("v", np.stack([np.sin(point + c) for c in range(3)], 1))):
    array = numpy_to_vtk(values.astype(np.float32), deep=1)
    array.SetName(name)
    image.GetPointData().AddArray(array)


def measure(what, make):
    least = float("inf")
    for _ in range(3):
        algorithm = make()
        algorithm.SetInputData(image)
        start = time.process_time()
        algorithm.Update()
        least = min(least, time.process_time() - start)
    print(f"{what}: {least * 1e9 / n**3:.2f} ns a point", flush=True)


def gradient(array, **computes):
    def make():
        made = vtk.vtkGradientFilter()
        made.SetInputArrayToProcess(0, 0, 0, 0, array)
        made.ComputeGradientOff()
        for what in computes:
            getattr(made, "SetCompute" + what)(1)
        return made

    return make


def calculator(expression, scalars, vectors):
    def make():
        made = vtk.vtkArrayCalculator()
        for name in scalars:
            made.AddScalarArrayName(name)
        for name in vectors:
            made.AddVectorArrayName(name)
        made.SetFunction(expression)
        made.SetResultArrayName("result")
        return made

    return make


measure("curl(v)", gradient("v", Vorticity=1))
measure("curl(v) and div(v)", gradient("v", Vorticity=1, Divergence=1))
measure("sqrt(s*s+1)*sin(s)+mag(v)", calculator("sqrt(s*s+1)*sin(s)+mag(v)", ["s"], ["v"]))
measure("mag(v)", calculator("mag(v)", [], ["v"]))
measure("grad(s)", gradient("s", Gradient=1))
measure("q(v)", gradient("v", QCriterion=1))

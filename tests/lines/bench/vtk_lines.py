#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Traces the lines of lines_benchmark with vtkStreamTracer: vtk_lines.py FOLDER.

Prints the processor's time in nanoseconds per cell length of way, and writes the ends of lines to NAME.ends,
for lines_benchmark to judge.
"""
import sys
import time

import numpy
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkImageData, vtkPolyData
from vtkmodules.vtkFiltersFlowPaths import vtkStreamTracer
from vtkmodules.vtkCommonMath import vtkRungeKutta2, vtkRungeKutta4, vtkRungeKutta45

folder = sys.argv[1]
with open(folder + "/seeds.txt") as text:
    n, cells = text.readline().split()
    n, cells = int(n), float(cells)
    seeds = numpy.loadtxt(text)
image = vtkImageData()
image.SetDimensions(n, n, n)
image.SetSpacing(*[1 / (n - 1)] * 3)
field = numpy.fromfile(folder + "/field.raw", dtype=numpy.float32).reshape(-1, 3)
array = numpy_to_vtk(field)
array.SetName("v")
image.GetPointData().SetVectors(array)


def trace(integrator, step, error, count):
    points = vtkPoints()
    for seed in seeds[:count]:
        points.InsertNextPoint(*seed)
    source = vtkPolyData()
    source.SetPoints(points)
    tracer = vtkStreamTracer()
    tracer.SetInputData(image)
    tracer.SetSourceData(source)
    tracer.SetIntegrator(integrator())
    tracer.SetIntegrationStepUnit(vtkStreamTracer.CELL_LENGTH_UNIT)
    tracer.SetInitialIntegrationStep(step)
    tracer.SetMaximumPropagation(cells / (n - 1))
    tracer.SetMaximumNumberOfSteps(10000000)
    tracer.SetComputeVorticity(False)
    if error:
        tracer.SetMaximumError(error)
        tracer.SetMinimumIntegrationStep(1e-4)
        tracer.SetMaximumIntegrationStep(1)
    start = time.process_time()
    tracer.Update()
    seconds = time.process_time() - start
    out = tracer.GetOutput()
    places = vtk_to_numpy(out.GetPoints().GetData()).astype(float)
    ids = vtk_to_numpy(out.GetCellData().GetArray("SeedIds"))
    offsets = vtk_to_numpy(out.GetLines().GetOffsetsArray())
    connectivity = vtk_to_numpy(out.GetLines().GetConnectivityArray())
    way, ends = 0, []
    for i, seed in enumerate(ids):
        line = places[connectivity[offsets[i]:offsets[i + 1]]]
        way += numpy.linalg.norm(numpy.diff(line, axis=0), axis=1).sum() * (n - 1)
        ends.append((seed, *line[-1]))
    return seconds * 1e9 / way, ends


for name, integrator, step, error, count in [
    ("rk2-0.5", vtkRungeKutta2, 0.5, 0, 2000),
    ("rk4-0.5", vtkRungeKutta4, 0.5, 0, 2000),
    ("rk4-0.1", vtkRungeKutta4, 0.1, 0, 500),
    ("rk4-0.03", vtkRungeKutta4, 0.03, 0, 200),
    ("rk45-1e-6", vtkRungeKutta45, 0.5, 1e-6, 500),
]:
    nanoseconds, ends = trace(integrator, step, error, count)
    print(f"{name:10} {nanoseconds:9.1f} ns/cell", flush=True)
    with open(f"{folder}/{name}.ends", "w") as text:
        for end in ends:
            text.write("%d %.17g %.17g %.17g\n" % end)

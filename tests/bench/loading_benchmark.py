#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""loading_benchmark.py PROGRAMS: the table of loading in docs/performance.md, in Markdown.

Has VTK write a volume (.vti), particles (.vtp) and hexahedra whose surface is shown (.vtu), of some 10^7 numbers each, in each
encoding, into a folder below the system's one for temporary files. VTK's own reader, on one thread, and loading_benchmark of the
folder PROGRAMS (such as build/release/bin), on one thread and on all cores, read each file in turns. The least of the turns is
printed. An import also makes what scenes need of the data. Needs Python's vtk and numpy.
"""
import argparse
import os
import pathlib
import subprocess
import sys
import tempfile

ENCODINGS = ["raw", "appended base64", "base64", "zlib", "ascii"]
VTK = r"""
import sys, time, resource, vtk
path = sys.argv[1]
kind = {"vti": "ImageData", "vtp": "PolyData", "vtu": "UnstructuredGrid"}[path[-3:]]
vtk.vtkSMPTools.Initialize(1)
reader = getattr(vtk, f"vtkXML{kind}Reader")()
reader.SetFileName(path)
wall, cpu = time.perf_counter(), time.process_time()
reader.Update()
print(time.perf_counter() - wall, time.process_time() - cpu, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / 1e6)
"""


def datasets(scale):
    import numpy
    import vtk
    from vtk.util import numpy_support

    def array(name, values):
        made = numpy_support.numpy_to_vtk(values, deep=True)
        made.SetName(name)
        return made

    def noise(shape):
        return random.standard_normal(shape, dtype=numpy.float32)

    random = numpy.random.default_rng(1)
    side = round(216 * scale ** (1 / 3))
    image = vtk.vtkImageData()
    image.SetDimensions(side, side, side)
    image.GetPointData().SetScalars(array("value", noise(side**3)))

    count = round(2.5e6 * scale)
    points = vtk.vtkPoints()
    points.SetData(array("Points", noise((count, 3))))
    particles = vtk.vtkPolyData()
    particles.SetPoints(points)
    particles.GetPointData().SetScalars(array("value", noise(count)))

    n = round(90 * scale ** (1 / 3))
    axis = numpy.arange(n + 1, dtype=numpy.float32)
    z, y, x = numpy.meshgrid(axis, axis, axis, indexing="ij")
    corner = numpy.arange((n + 1) ** 3).reshape(n + 1, n + 1, n + 1)[:n, :n, :n].ravel()
    steps = [0, 1, n + 2, n + 1]
    steps += [s + (n + 1) ** 2 for s in steps]
    cells = vtk.vtkCellArray()
    cells.SetData(8, numpy_support.numpy_to_vtkIdTypeArray((corner[:, None] + numpy.array(steps)).ravel().astype(numpy.int64), deep=True))
    points = vtk.vtkPoints()
    points.SetData(array("Points", numpy.stack([x, y, z], axis=-1).reshape(-1, 3) + 0.1 * noise(((n + 1) ** 3, 3))))
    grid = vtk.vtkUnstructuredGrid()
    grid.SetPoints(points)
    grid.SetCells(vtk.VTK_HEXAHEDRON, cells)
    grid.GetPointData().SetScalars(array("value", noise((n + 1) ** 3)))
    return {"vti": ("ImageData", image), "vtp": ("PolyData", particles), "vtu": ("UnstructuredGrid", grid)}


def write(folder, scale):
    import vtk
    for extension, (kind, data) in datasets(scale).items():
        for encoding in ENCODINGS:
            writer = getattr(vtk, f"vtkXML{kind}Writer")()
            writer.SetFileName(str(folder / f"{encoding.replace(' ', '_')}.{extension}"))
            writer.SetInputData(data)
            {"ascii": writer.SetDataModeToAscii, "base64": writer.SetDataModeToBinary}.get(encoding, writer.SetDataModeToAppended)()
            writer.SetEncodeAppendedData(encoding == "appended base64")
            writer.SetCompressorTypeToZLib() if encoding == "zlib" else writer.SetCompressorTypeToNone()
            writer.SetHeaderTypeToUInt64()
            if writer.Write() != 1:
                sys.exit(f"{extension} was not written")


def least(turns, commands):
    """For each command, the least of each of the numbers that it prints."""
    runs = [[] for _ in commands]
    for _ in range(turns):
        for run, command in zip(runs, commands):
            run.append([float(n) for n in subprocess.run(command, check=True, capture_output=True, text=True).stdout.split()])
    return [[min(column) for column in zip(*run)] for run in runs]


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("programs", type=pathlib.Path)
    parser.add_argument("--folder", type=pathlib.Path, help="keep the files here, and use those that are there")
    parser.add_argument("--turns", type=int, default=3)
    parser.add_argument("--scale", type=float, default=1, help="of the numbers of values")
    parser.add_argument("--only", default="", help="files whose name has this")
    o = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = o.folder or pathlib.Path(temporary)
        folder.mkdir(exist_ok=True)
        if not any(folder.iterdir()):
            write(folder, o.scale)
        print("| file | MB | VTK: CPU s, MB | reading: CPU s, MB | of VTK's | on all cores: wall s | import: CPU s, MB | on all cores: wall s |")
        print("|---|---|---|---|---|---|---|---|")
        program, cores = str(o.programs / "loading_benchmark"), str(os.cpu_count())
        for extension in ("vti", "vtp", "vtu"):
            for encoding in ENCODINGS:
                path = folder / f"{encoding.replace(' ', '_')}.{extension}"
                if o.only not in path.name:
                    continue
                vtk, read, read_all, whole, whole_all = least(o.turns, [
                    [sys.executable, "-c", VTK, str(path)], *([program, what, str(path), threads]
                                                              for what in ("read", "import") for threads in ("1", cores))])
                print(f"| .{extension} {encoding} | {path.stat().st_size / 1e6:.0f} | {vtk[1]:.2f}, {vtk[2]:.0f} "
                      f"| {read[1]:.2f}, {read[2]:.0f} | {read[1] / vtk[1]:.2f} | {read_all[0]:.2f} "
                      f"| {whole[1]:.2f}, {whole[2]:.0f} | {whole_all[0]:.2f} |", flush=True)


if __name__ == "__main__":
    main()

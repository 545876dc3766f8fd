#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""goals_table.py PROGRAMS DATA: the tables of docs/experiments/0001-comparison-with-peers.md, in Markdown.

PROGRAMS holds gxyrender (such as build/release/bin). DATA holds volumes in [-1,1]^3 (turb256.vti, ml256.vti, turb512.vti,
aster512.vti), particles (part1m.vtp), triangles (mesh.vtp), and of volumes their references in double: NAME.MAP.f32, 1024 x 1024 float
RGBA, and NAME.iso.f64, the distances to isovalue 0.5. A scene whose files are not there is left out. With --kernels FOLDER, trial_march and
trial_iso of it are run in turn with gxyrender, on DATA/NAME.raw: plain kernels of one thread, the floor that peers were measured against.

Times are CPU-ms of a warm frame on one thread: a fifth of what six frames take longer than one, each the least of the repeats, as everything
is measured in turn, and what is least is least disturbed. "frame": all but the writing of its file; "tracing": of the stages that the plain
kernels have, too. For an error that is
asked for, the setting of the ladder that takes least. Half an hour; needs numpy.
"""
import argparse
import json
import math
import pathlib
import re
import subprocess
import sys
import tempfile

import numpy as np

SIZE, FRAMES = 1024, 5
LADDER = [0.4, 0.3, 0.2, 0.14, 0.1, 0.05, 0.03, 0.015, 0.008, 0.004, 0.002]
SCALES = {"A": 8, "B": 20, "C": 60}  # of a map's entries to extinction: a ramp, linear, two spikes
MAPS = {"A": lambda v: max(0, (v - 0.3) / 0.7), "B": lambda v: v,
        "C": lambda v: max(0, 1 - abs(v - 0.45) / 0.02) + max(0, 1 - abs(v - 0.62) / 0.02)}
# RMS errors asked for: the plain kernel's step in cells that a goal names, and OSPRay 3.2's CPU-ms and error there (the best where it
# reaches none less), timed once on an AVX-512 Xeon
VOLUMES = {
    ("turb256", "A"): {1.7e-3: (2, 1262, 1.7e-3), 2e-4: (1, 3888, 4.4e-4)},
    ("turb256", "C"): {6.8e-3: (1, 1727, 3.2e-3), 9e-4: (0.5, 6132, 8.0e-4), 2e-4: (0.25, 6132, 8.0e-4)},
    ("ml256", "A"): {2.4e-3: (2, 1145, 2.4e-3), 3.2e-4: (1, 3060, 6.2e-4)},
    ("ml256", "C"): {5.3e-3: (1, 640, 5.3e-3), 1.1e-3: (0.5, 1582, 1.1e-3)},
    ("turb512", "A"): {8.7e-4: (2, 3096, 8.7e-4), 2e-4: (1, 5273, 4.4e-4)},
    ("aster512", "B"): {8.7e-4: (2, 3167, 8.7e-4), 2e-4: (1, 9839, 2.2e-4)},
}
ISOSURFACES = {"turb256": 284, "ml256": 187, "aster512": 262, "turb512": 442}
LIGHTS = ["no secondaries", "shadow", "shadow, 1 AO ray", "shadow, 4 AO rays"]
GEOMETRY = {"part1m": (306, 402, 616, 1128), "mesh": (122, 195, 393, 879)}


def camera():
    distance, elevation, azimuth = 4.4, math.radians(20), 0.3
    eye = [math.cos(elevation) * math.cos(azimuth), math.sin(elevation), math.cos(elevation) * math.sin(azimuth)]
    return {"viewpoint": [distance * x for x in eye], "viewcenter": [0, 0, 0], "viewup": [0, 1, 0], "aov": 45,
            "dimensions": [SIZE, SIZE]}


class Bench:
    def __init__(self, arguments, folder):
        self._programs, self._data, self._kernels = arguments.programs, arguments.data, arguments.kernels
        self._repeats, self._folder = arguments.repeats, folder

    def has(self, *names):
        return all((self._data / name).exists() for name in names)

    def _run(self, state, frames, depth=False):
        """Milliseconds of all frames, but of writing them: CPU, and by stage."""
        (self._folder / "scene.json").write_text(json.dumps({**state, "Cameras": [camera()] * frames}))
        command = [self._programs / "gxyrender", "scene.json", "-o", "picture", "--format", "raw", "--quiet", "--concurrent", "1",
                   "--threads", "1", "--backend", "embree", "--stats", "stats.json"] + (["--depth"] if depth else [])
        subprocess.run(command, cwd=self._folder, check=True, stdout=subprocess.DEVNULL)
        rank = json.loads((self._folder / "stats.json").read_text())["ranks"][0]
        stages = {name: 1000 * seconds for name, seconds in rank["thread seconds"].items()}
        return 1000 * (rank["seconds"]["cpu render"] - rank["seconds"].get("cpu pictures", 0)), stages

    def _warm(self, state, stage, least):
        """CPU-ms of a frame, of a stage and of all: from what one frame and six took at least so far, which `least` keeps."""
        for frames in (1, 1 + FRAMES):
            cpu, stages = self._run(state, frames)
            least[frames] = tuple(map(min, least.get(frames, (math.inf, math.inf)), (stages[stage], cpu)))
        return tuple((six - one) / FRAMES for one, six in zip(least[1], least[1 + FRAMES]))

    def _kernel(self, program, *options):
        if not self._kernels:
            return ""
        return subprocess.run([self._kernels / program, *options], cwd=self._folder, check=True, capture_output=True, text=True).stdout

    def volume(self, name, which):
        """{tolerance: (RMSE, tracing, frame)}, and {step: (ms, RMSE)} of the plain kernel."""
        entries = [MAPS[which](i / 255) * SCALES[which] for i in range(256)]
        operator = {"type": "Volume", "dataset": "d", "volume rendering": True,
                    "colormap": [[v, v, 0.2 + 0.5 * (1 - abs(2 * v - 1)), 1 - v] for v in (i / 255 for i in range(256))],
                    "extinctionmap": [[i / 255, e] for i, e in enumerate(entries)]}
        reference = self._data / f"{name}.{which}.f32"
        truth = np.fromfile(reference, np.float32).reshape(-1, 4)[:, :3].astype(float)
        ours, plain, least = {}, {}, {tolerance: {} for tolerance in LADDER}
        for _ in range(self._repeats):
            out = self._kernel("trial_march", f"file={self._data / name}.raw", f"n={name[-3:]}", f"tf={which}", f"ref={reference}")
            for step, ms, rmse in re.findall(r"h=([0-9.]+) cpu ([0-9.]+) ms RMSE ([0-9.e+-]+)", out):
                plain[float(step)] = min(plain.get(float(step), (math.inf,)), (float(ms), float(rmse)))
            for tolerance in LADDER:
                state = self._state("Volume", f"{name}.vti", operator, {"tolerance": tolerance})
                times = self._warm(state, "integrate", least[tolerance])
                picture = np.fromfile(self._folder / "picture_00000.raw", np.float32).reshape(-1, 4)[:, :3].astype(float)
                rmse = float(np.sqrt(((picture - truth) ** 2).mean()))
                ours[tolerance] = (rmse, *times)
        return ours, plain

    def isosurface(self, name):
        """Tracing and frame, what is wrong of the hits, and ms of the plain kernel."""
        state = self._state("Volume", f"{name}.vti", {"type": "Volume", "dataset": "d", "isovalues": [0.5]})
        plain, least = [], {}
        for _ in range(self._repeats):
            out = self._kernel("trial_iso", f"file={self._data / name}.raw", f"n={name[-3:]}", "iso=.5", "out=trial.f64")
            plain += [float(ms) for ms in re.findall(r"cpu ([0-9.]+) ms", out)]
            times = self._warm(state, "slices and isosurfaces", least)
        self._run(state, 1, depth=True)
        truth = np.fromfile(self._data / f"{name}.iso.f64")
        depth = np.fromfile(self._folder / "picture_00000.depth")
        hit, ours = truth < 1e29, depth < 1e29
        off = np.abs(truth - depth)[hit & ours] / (2 / (int(name[-3:]) - 1))
        wrong = f"{hit.sum()} hits, {(hit & ~ours).sum()} missed, {(ours & ~hit).sum()} extra, {(off > 0.5).sum()} more than half a cell off"
        return times, wrong, min(plain, default=None)

    def geometry(self, name, lights):
        kind = "Particles" if name == "part1m" else "Triangles"
        operator = {"type": kind, "dataset": "d"} | ({"radius": 0.002} if name == "part1m" else {})
        lighting = [{}, {"shadows": True}] + [{"shadows": True, "ao count": n, "ao radius": 0.5} for n in (1, 4)]
        state = self._state(kind, f"{name}.vtp", operator, lighting=lighting[lights])
        least = {}
        return [self._warm(state, "geometry", least) for _ in range(self._repeats)][-1][1]

    def _state(self, kind, file, operator, renderer=None, lighting=None):
        return {"Renderer": {"background": [0, 0, 0, 0], **(renderer or {})},
                "Datasets": [{"name": "d", "type": kind, "filename": str(self._data / file)}],
                "Visualization": {"Lighting": {"Sources": [[-1, -1, -1, 0]], "Ka": 0.4, "Kd": 0.7, **(lighting or {})},
                                  "operators": [operator]}}


def volumes(bench):
    print("| scene, map | RMSE asked for | tracing | frame | RMSE (tolerance) | plain kernel | times: tracing, frame | OSPRay | times: tracing, frame |")
    print("|---|---|---|---|---|---|---|---|---|")
    for (name, which), errors in VOLUMES.items():
        if not bench.has(f"{name}.vti", f"{name}.{which}.f32"):
            continue
        ours, plain = bench.volume(name, which)
        for asked, (step, ospray, ospray_rmse) in errors.items():
            tracing, frame, rmse, tolerance = min(
                ((t, f, e, setting) for setting, (e, t, f) in ours.items() if e <= asked), default=(math.nan,) * 4)
            floor = plain.get(step)
            against = f"step {step}: {floor[0]:.0f} at {floor[1]:.1e} | {floor[0] / tracing:.1f}, {floor[0] / frame:.1f}" if floor else "| "
            print(f"| {name}, {which} | {asked:.1e} | {tracing:.0f} | {frame:.0f} | {rmse:.1e} ({tolerance}) | {against} | "
                  f"{ospray} at {ospray_rmse:.1e} | {ospray / tracing:.1f}, {ospray / frame:.1f} |", flush=True)


def isosurfaces(bench):
    print("\n| isosurface | tracing | frame | plain kernel | times: tracing, frame | OSPRay | times: tracing, frame | |\n|---|---|---|---|---|---|---|---|")
    for name, ospray in ISOSURFACES.items():
        if not bench.has(f"{name}.vti", f"{name}.iso.f64"):
            continue
        (tracing, frame), wrong, plain = bench.isosurface(name)
        against = f"{plain:.0f} | {plain / tracing:.2f}, {plain / frame:.2f}" if plain else "| "
        print(f"| {name} | {tracing:.0f} | {frame:.0f} | {against} | {ospray} | {ospray / tracing:.1f}, {ospray / frame:.1f} | {wrong} |", flush=True)


def geometry(bench):
    print("\n| geometry | | frame | OSPRay | times |\n|---|---|---|---|---|")
    for name, peers in GEOMETRY.items():
        if not bench.has(f"{name}.vtp"):
            continue
        for lights, ospray in enumerate(peers):
            frame = bench.geometry(name, lights)
            print(f"| {name} | {LIGHTS[lights]} | {frame:.0f} | {ospray} | {ospray / frame:.2f} |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("programs", type=pathlib.Path, help="the folder of gxyrender")
    parser.add_argument("data", type=pathlib.Path, help="the folder of the data and references")
    parser.add_argument("--kernels", type=lambda p: pathlib.Path(p).resolve(), help="the folder of trial_march and trial_iso")
    parser.add_argument("--repeats", type=int, default=2)
    parser.add_argument("--tables", nargs="+", choices=["volumes", "isosurfaces", "geometry"], default=["volumes", "isosurfaces", "geometry"])
    arguments = parser.parse_args()
    arguments.programs, arguments.data = arguments.programs.resolve(), arguments.data.resolve()
    with tempfile.TemporaryDirectory() as folder:
        bench = Bench(arguments, pathlib.Path(folder))
        for table in arguments.tables:
            globals()[table](bench)
    return 0


if __name__ == "__main__":
    sys.exit(main())

# SPDX-License-Identifier: Apache-2.0
"""ways_test.py BUILD SEED RUNS MPIEXEC...: simulations whose ranks, ways to the server, types, layouts and decompositions are drawn, such that each
two values of two of them occur together in some run. Triggers leave a picture of each step, which equals gxyrender's of a file with the same
step, to the bit. RUNS: how many of these runs are made, from one on that SEED decides; 0: all."""
import itertools
import json
import os
import pathlib
import random
import subprocess
import sys
import tempfile
import time
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT / folder) for folder in ("tests/clients", "python/src")]
from server import Server  # noqa: E402
import gxy.client  # noqa: E402

BUILD, SEED, RUNS, MPIEXEC = pathlib.Path(sys.argv[1]).resolve(), int(sys.argv[2]), int(sys.argv[3]), sys.argv[4:]
PROGRAMS, SIMULATION = BUILD / "bin", BUILD / "tests" / "ways_simulation"
VALUES = {"way": ["beside", "here", "world"], "ranks": [1, 2, 3, 5], "servers": [1, 2, 3], "type": list(range(10)), "components": [1, 3],
          "layout": list(range(5)), "of": [0, 1], "partition": ["even", "simulation"]}


def state(points):
    """A visualization of the grid, seen from nearby."""
    size = [n * d for n, d in zip(points, [0.125, 0.25, 0.5])]
    centre = [o + s / 2 for o, s in zip([-1, 0.25, 2], size)]
    far = sum(s * s for s in size) ** 0.5
    return {"Visualization": {"operators": [{
                "type": "Volume", "dataset": "ways.a", "colormap": "Viridis", "data range": [0, 128], "isovalues": [70],
                "slices": [[0, 0, 1, centre[2]]], "volume rendering": True, "extinctionmap": [[0, 0.1], [128, 2]]}]},
            "Camera": {"viewpoint": [c + 0.6 * far for c in centre], "viewcenter": centre, "viewup": [0, 0, 1], "aov": 45,
                       "dimensions": [120, 90]}}


def pairwise(seed):
    """Runs that have all pairs. Each is the best of 30 that are drawn."""
    drawn, names = random.Random(seed), list(VALUES)
    # In the simulation's processes there are as many ranks of the server as of the simulation.
    pairs_of = lambda run: {((a, run[a]), (b, run[b])) for a, b in itertools.combinations(names, 2)  # noqa: E731
                            if run["way"] != "here" or "servers" not in (a, b)}
    left = {((a, x), (b, y)) for a, b in itertools.combinations(names, 2) for x in VALUES[a] for y in VALUES[b]
            if (a, x, b) != ("way", "here", "servers")}
    runs = []
    while left:
        wanted, candidates = sorted(left, key=str), []
        for _ in range(30):
            run = {name: drawn.choice(values) for name, values in VALUES.items()}
            run.update(drawn.choice(wanted))
            candidates.append(run)
        runs.append(max(candidates, key=lambda run: len(pairs_of(run) & left)))
        left -= pairs_of(runs[-1])
    return runs


class Ways(unittest.TestCase):
    def test_all_show_what_files_show(self):
        runs = pairwise(SEED)
        for number, run in enumerate(runs[:RUNS] if RUNS else runs):
            with self.subTest(**run), tempfile.TemporaryDirectory(prefix="galaxy-ways-") as folder:
                self.compare(run, random.Random(SEED + number), pathlib.Path(folder))

    def compare(self, run, drawn, folder):
        case = {"points": [drawn.randint(6, 20) for _ in range(3)], "seed": drawn.randrange(2**32), "world": run["way"] == "world",
                **{name: run[name] for name in ("type", "components", "layout", "of")}}
        seen = state(case["points"])
        options = {"policy": "wait", "time-out": 60, "partition": run["partition"], "here": {"port": 0, "backend": "embree"},
                   "triggers": [{"name": "movie", "when": {"every": 1}, "do": "batch", "exact": True,
                                 "batch": {"prefix": "seen-{step}", "state": seen}}]}
        getattr(self, "publish_" + run["way"])(run, options, [SIMULATION, json.dumps(case)], folder)
        self.start(folder, SIMULATION, json.dumps(case), "file")
        found = sorted(folder.glob("seen-*.png"))
        self.assertEqual(len(found), 2)
        for step, picture in enumerate(found, 1):
            dataset = {"name": "ways.a", "filename": f"file.{step}.vti", "type": "Volume"}
            (folder / "state.json").write_text(json.dumps({"Datasets": [dataset], **seen}))
            self.start(folder, PROGRAMS / "gxyrender", "state.json", "-o", f"file-{step}", "--backend", "embree")
            expected = folder / f"file-{step}_00000.png"
            self.assertGreater(expected.stat().st_size, 1000, "there is something to be seen")
            self.assertEqual(picture.read_bytes(), expected.read_bytes(), picture.name)

    def start(self, folder, *command, options=None, to="off"):
        if options is not None:
            (folder / "options.json").write_text(json.dumps(options))
        environment = {**os.environ, "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
                       "GALAXY_INSITU_OPTIONS": str(folder / "options.json") if options is not None else "", "GALAXY_INSITU": to}
        done = subprocess.run([str(word) for word in command], cwd=folder, env=environment, text=True, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, timeout=120)
        self.assertEqual(done.returncode, 0, done.stdout)

    def publish_beside(self, run, options, simulation, folder):
        server = Server(PROGRAMS, MPIEXEC, run["servers"], ["--backend", "embree", "--data", str(folder)])
        try:
            self.start(folder, *MPIEXEC, "-n", run["ranks"], *simulation, options={**options, "token-file": str(server.token)},
                       to=f"127.0.0.1:{server.port}")
            with gxy.client.Client(port=server.port, token_file=server.token) as client:
                client.request("load insitu")
                for _ in range(1200):
                    if not client.request("insitu.streams")["streams"]:  # and so what triggers have begun
                        break
                    time.sleep(0.05)
                client.request("quit")
        finally:
            self.assertEqual(server.stop(), 0)

    def publish_here(self, run, options, simulation, folder):
        self.start(folder, *MPIEXEC, "-n", run["ranks"], *simulation, options=options, to="here")

    def publish_world(self, run, options, simulation, folder):
        self.start(folder, *MPIEXEC, "-n", run["ranks"], *simulation, ":", "-n", run["servers"], PROGRAMS / "gxyserver", "--world", "--port", 0,
                   "--backend", "embree", options=options, to="here")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])

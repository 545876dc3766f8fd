# SPDX-License-Identifier: Apache-2.0
"""server_test.py BUILD SIMULATION MPIEXEC...: the instrumented simulation with libcatalyst-galaxy.so, on several numbers of ranks, and
one server on two ranks. What it publishes is what NumPy and the package gxy publish, to the bit."""
import json
import os
import pathlib
import subprocess
import sys
import time
import unittest

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT / folder) for folder in ("tests/clients", "python/src")]
from gxy.insitu import Simulation  # noqa: E402
from server import Server  # noqa: E402
import gxy.client  # noqa: E402

BUILD, PROGRAM, MPIEXEC = pathlib.Path(sys.argv[1]).resolve(), sys.argv[2], sys.argv[3:]
LAST = 8  # step


def wave(step):
    """As the simulation's height, by z, y and x. No operation rounds."""
    z, y, x = np.indices((32, 40, 48), dtype=np.float64)
    x = (x - 3 * step) / 32
    return x * (1 - x) * (1 + x) + (y - z) / 32


def state(dataset):
    """A view of the whole volume: translucent, with a surface and a slice."""
    return {
        "Visualization": {"operators": [{
            "type": "Volume", "dataset": dataset, "colormap": "Viridis", "data range": [-3, 3], "isovalues": [0.125],
            "slices": [[0, 0, 1, 7.25]], "opacity": 0.5, "volume rendering": True,
            "extinctionmap": [[-3, 0.01], [3, 0.1]]}]},
        "Camera": {"viewpoint": [55, 35, 47], "viewcenter": [12, 10, 8], "viewup": [0, 0, 1], "aov": 35,
                   "dimensions": [192, 144]},
    }


def atoms(dataset):
    return {
        "Visualization": {
            "Lighting": {"Sources": [[-1, -2, -1.6, 0]], "shadows": True},
            "operators": [{"type": "Particles", "dataset": dataset, "colormap": "Viridis", "data range": [0, 150],
                           "radius": 0.6}]},
        "Camera": {"viewpoint": [55, 35, 47], "viewcenter": [12, 10, 8], "viewup": [0, 0, 1], "aov": 35,
                   "dimensions": [192, 144]},
    }


class Catalyst(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = Server(BUILD / "bin", MPIEXEC, options=["--backend", "embree"])
        cls.addClassCleanup(cls.server.stop)
        cls.client = gxy.client.Client(port=cls.server.port, token_file=cls.server.token)
        cls.addClassCleanup(cls.client.close)
        cls.addClassCleanup(cls.client.request, "quit")
        for module in ("data", "viewer", "insitu"):
            cls.client.request(f"load {module}")
        cls.options = cls.server.folder / "options.json"
        cls.options.write_text(json.dumps({"token-file": str(cls.server.token), "reconnect": 0.2}))
        cls.windows = 0

    def run_simulation(self, layout, ranks, says="", **environment):
        """The stream has the name LAYOUTRANKS, since datasets of streams before are still there."""
        run = subprocess.run(
            [*MPIEXEC, "-n", str(ranks), PROGRAM, layout], timeout=100, capture_output=True, text=True, env={
                **os.environ, "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
                "CATALYST_IMPLEMENTATION_NAME": "galaxy", "CATALYST_IMPLEMENTATION_PATHS": str(BUILD / "lib" / "catalyst"),
                "GALAXY_INSITU": f"127.0.0.1:{self.server.port}", "GALAXY_INSITU_OPTIONS": str(self.options), **environment})
        self.assertEqual((run.returncode, run.stdout), (0, ""))
        self.assertRegex(run.stderr, f"^{says}$")

    def no_stream_is_left(self):
        for _ in range(600):
            if not self.client.request("insitu.streams")["streams"]:
                return
            time.sleep(0.05)
        self.fail("the stream before has not ended")

    def picture(self, dataset, view=state):
        type(self).windows += 1
        window = self.client.window(self.windows, size=(192, 144))
        window.set(view(dataset))
        picture = window.render(levels=[1]).rgba
        window.close()
        return picture

    def expected(self, of):
        """What the package gxy publishes: the infos of the fields, and a picture of the first."""
        height = wave(LAST)
        slope = height[..., np.newaxis] * np.array([1.0, 2.0, 3.0])
        name = f"expected-{of}"
        with Simulation(name, to=f"127.0.0.1:{self.server.port}", token_file=str(self.server.token)) as sim:
            sim.grid((48, 40, 32), spacing=(0.5, 0.5, 0.5), of=of)
            sim.field("height", height)
            sim.field("slope", slope)
            sim.publish_last(LAST, 1.0)
            sim.close(60)
        picture = self.picture(f"{name}.height")
        self.assertGreater(picture.astype(int).std(), 10)  # there is something to see
        return [self.info(f"{name}.{field}") for field in ("height", "slope")], picture

    def info(self, dataset):
        info = self.client.request(f"data.info {dataset}")["datasets"][0]
        return {key: info[key] for key in ("time", "points", "components", "range", "box")}

    def test_the_last_step_is_the_same_for_all_layouts_and_numbers_of_ranks(self):
        for of, layouts in (("points", ("plain", "ghosts", "blocks")), ("cells", ("cells",))):
            infos, picture = self.expected(of)
            self.assertEqual(infos[0]["range"], [wave(LAST).min(), wave(LAST).max()])
            for layout in layouts:
                for ranks in (1, 2, 3):
                    with self.subTest(layout=layout, ranks=ranks):
                        self.no_stream_is_left()
                        self.run_simulation(layout, ranks)
                        self.assertEqual([self.info(f"{layout}{ranks}.{field}") for field in ("height", "slope")], infos)
                        np.testing.assert_array_equal(self.picture(f"{layout}{ranks}.height"), picture)
                        origins = self.client.request(f"data.info {layout}{ranks}.height")["datasets"][0]["origins"]
                        self.assertEqual([origin["step"] for origin in origins], [LAST])

    def test_particles_beside_a_grid_are_the_same_on_all_numbers_of_ranks(self):
        n = np.arange(300)
        at = np.stack([n * 7919 % 97 / 4, n * 104729 % 79 / 4, n % 61 / 4 + LAST / 8], axis=1)
        with Simulation("expected-atoms", to=f"127.0.0.1:{self.server.port}", token_file=str(self.server.token)) as sim:
            sim.grid((48, 40, 32), spacing=(0.5, 0.5, 0.5))
            sim.field("height", wave(LAST))
            sim.points("atoms", at, ids=n.astype(np.int32), speed=n / 2)
            sim.publish_last(LAST, 1.0)
            sim.close(60)
        keys = ("time", "primitives", "range", "box")

        def info(dataset):
            found = self.client.request(f"data.info {dataset}")["datasets"][0]
            return {key: found[key] for key in keys}
        expected, picture = info("expected-atoms.speed"), self.picture("expected-atoms.speed", atoms)
        self.assertEqual((expected["primitives"], expected["range"]), (300, [0, 149.5]))
        self.assertGreater(picture.astype(int).std(), 10)
        for ranks in (1, 2, 3):
            with self.subTest(ranks=ranks):
                self.no_stream_is_left()
                self.run_simulation("atoms", ranks)
                self.assertEqual(info(f"atoms{ranks}.speed"), expected)
                np.testing.assert_array_equal(self.picture(f"atoms{ranks}.speed", atoms), picture)
                self.assertEqual(self.info(f"atoms{ranks}.height"), self.info("expected-atoms.height"))

    def test_a_step_that_one_rank_does_not_have_is_left_out_and_the_next_ones_are_published(self):
        infos, _ = self.expected("points")
        options = self.server.folder / "wait.json"
        options.write_text(json.dumps({**json.loads(self.options.read_text()), "policy": "wait", "time-out": 60}))
        ranks = 2
        for layout in ("gap", "late"):
            with self.subTest(layout=layout):
                self.no_stream_is_left()
                self.run_simulation(layout, ranks, says="(galaxy: rank 1: .*\n)+", GALAXY_INSITU_OPTIONS=str(options))
                self.assertEqual([self.info(f"{layout}{ranks}.{field}") for field in ("height", "slope")], infos)
                origins = self.client.request(f"data.info {layout}{ranks}.height")["datasets"][0]["origins"]
                self.assertEqual([origin["step"] for origin in origins], [LAST])

    def test_without_a_server_the_simulation_runs_to_its_end(self):
        self.run_simulation("plain", 2, GALAXY_INSITU="off")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])

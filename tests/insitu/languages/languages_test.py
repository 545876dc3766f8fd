# SPDX-License-Identifier: Apache-2.0
"""languages_test.py BUILD LANGUAGES MPIEXEC...: the example wave in all languages, on several numbers of ranks, and one server on
two ranks. The last step is the same for all, and the one that NumPy computes here: its range, and a picture to the bit."""
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
from gxy.insitu import Result, Simulation  # noqa: E402
from server import Server  # noqa: E402
import gxy.client  # noqa: E402

BUILD, LANGUAGES, MPIEXEC = pathlib.Path(sys.argv[1]).resolve(), sys.argv[2].split(";"), sys.argv[3:]
EXAMPLES = ROOT / "docs" / "examples" / "insitu"
LAST = 8  # step


def wave(step):
    """The field of a step, by z, y and x. All numbers are multiples of 2^-15 below 4, so that no operation rounds."""
    z, y, x = np.indices((32, 40, 48), dtype=np.float64)
    x = (x - 3 * step) / 32
    return x * (1 - x) * (1 + x) + (y - z) / 32


def state(dataset):
    """A view of the whole volume: translucent, with a surface and a slice."""
    return {
        "Visualization": {"operators": [{
            "type": "Volume", "dataset": dataset, "colormap": "Viridis", "data range": [-3, 3], "isovalues": [0.125],
            "slices": [[0, 0, 1, 15.25]], "opacity": 0.5, "volume rendering": True,
            "extinctionmap": [[-3, 0.01], [3, 0.1]]}]},
        "Camera": {"viewpoint": [110, 70, 95], "viewcenter": [23.5, 19.5, 15.5], "viewup": [0, 0, 1], "aov": 35,
                   "dimensions": [192, 144]},
    }


class Languages(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = Server(BUILD / "bin", MPIEXEC, options=["--backend", "embree"])
        cls.addClassCleanup(cls.server.stop)
        cls.client = gxy.client.Client(port=cls.server.port, token_file=cls.server.token)
        cls.addClassCleanup(cls.client.close)
        cls.addClassCleanup(cls.client.request, "quit")
        for module in ("data", "viewer", "insitu"):
            cls.client.request(f"load {module}")
        np.save(cls.server.folder / "expected.npy", wave(LAST))
        cls.options = cls.server.folder / "options.json"
        cls.options.write_text(json.dumps({"token-file": str(cls.server.token), "reconnect": 0.2}))
        cls.windows = 0

    def run_wave(self, language, ranks, **environment):
        """The example, as a user starts it."""
        program = [BUILD / "tests" / f"wave_{language}"]
        if language == "py":
            program = [sys.executable, "-B", EXAMPLES / "wave.py"]
        subprocess.run([*MPIEXEC, "-n", str(ranks), *program], check=True, timeout=100, env={
            **os.environ, "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
            "PYTHONPATH": str(ROOT / "python" / "src"), "GALAXY_INSITU": f"127.0.0.1:{self.server.port}",
            "GALAXY_INSITU_OPTIONS": str(self.options), **environment})

    def no_stream_is_left(self):
        """Waits for the end of the stream before, whose name the next one has."""
        for _ in range(600):
            if not self.client.request("insitu.streams")["streams"]:
                return
            time.sleep(0.05)
        self.fail("the stream before has not ended")

    def picture(self, dataset):
        type(self).windows += 1
        window = self.client.window(self.windows, size=(192, 144))
        window.set(state(dataset))
        picture = window.render(levels=[1]).rgba
        window.close()
        return picture

    def imported(self, like):
        """The picture of what NumPy has computed, in a file."""
        self.client.request(f"data.import like {like} " + json.dumps(
            {"Datasets": {"name": "expected", "type": "Volume", "filename": "expected.npy"}}))
        picture = self.picture("expected")
        self.assertGreater(picture.astype(int).std(), 10)  # there is something to see
        return picture

    def test_the_last_step_is_the_same_in_all_languages_and_on_all_numbers_of_ranks(self):
        generation, expected = 0, None
        for language in LANGUAGES:
            for ranks in (1, 2, 4):
                with self.subTest(language=language, ranks=ranks):
                    self.no_stream_is_left()
                    self.run_wave(language, ranks)
                    info = self.client.request("data.info wave.height")["datasets"][0]
                    self.assertGreater(info["generation"], generation)
                    generation = info["generation"]
                    self.assertEqual([origin["step"] for origin in info["origins"]], [LAST])
                    self.assertEqual((info["time"], info["points"], info["components"]), (1.0, [48, 40, 32], 1))
                    values = wave(LAST)
                    self.assertEqual(info["range"], [values.min(), values.max()])
                    if expected is None:
                        expected = self.imported("wave.height")
                    np.testing.assert_array_equal(self.picture("wave.height"), expected)

    def test_views_of_all_kinds_show_the_same(self):
        """Each step is another view of the same values, and is waited for."""
        values = wave(LAST)
        ghosts = np.full((36, 42, 50), np.nan)
        ghosts[2:-2, 1:-1, 1:-1] = values
        particles = np.zeros(values.shape, [("id", "i4"), ("height", "f8")])  # unaligned, too
        particles["height"] = values
        views = [
            {"array": values},
            {"array": ghosts[2:-2, 1:-1, 1:-1]},
            {"array": particles["height"]},
            {"array": np.asfortranarray(values)},
            {"array": np.ascontiguousarray(values[::-1, ::-1, ::-1])[::-1, ::-1, ::-1]},
            {"array": values.T, "order": "xyz"},
            {"array": np.ascontiguousarray(values.T), "order": "xyz"},
            {"array": np.repeat(values, 2, axis=2)[:, :, ::2, np.newaxis]},
        ]
        expected = None
        with Simulation("views", to=f"127.0.0.1:{self.server.port}", token_file=str(self.server.token), policy="wait",
                        time_out=60) as sim:
            sim.grid(size=(48, 40, 32))
            for step, view in enumerate(views, 1):
                with self.subTest(step=step):
                    sim.field("height", **view)
                    self.assertEqual(sim.publish(step, step), Result.TAKEN, sim.message())
                    self.client.request(f"data.wait views.height {step} 60")
                    if expected is None:
                        expected = self.imported("views.height")
                    np.testing.assert_array_equal(self.picture("views.height"), expected)
            self.assertEqual(sim.statistics().taken, len(views))
            self.assertEqual(sim.statistics().bytes, len(views) * values.nbytes)

    @unittest.skipUnless("py" in LANGUAGES, "there is no mpi4py")
    def test_a_server_runs_in_the_processes_of_a_simulation_in_python(self):
        trigger = {"name": "last", "when": {"every": 7}, "do": "batch", "exact": True,
                   "batch": {"prefix": "here-{step}", "format": "raw", "state": state("wave.height")}}
        options = self.server.folder / "here.json"
        options.write_text(json.dumps({"triggers": [trigger], "policy": "wait", "time-out": 60,
                                       "here": {"port": 0, "data": str(self.server.folder), "backend": "embree"}}))
        self.run_wave("py", 2, GALAXY_INSITU="here", GALAXY_INSITU_OPTIONS=str(options))
        self.assertEqual(len(list(self.server.folder.glob("here-*"))), 2)

    def test_without_a_server_they_run_to_their_end(self):
        for language in LANGUAGES:
            with self.subTest(language=language):
                self.run_wave(language, 1, GALAXY_INSITU="off")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])

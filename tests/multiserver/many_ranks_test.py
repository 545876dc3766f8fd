# SPDX-License-Identifier: Apache-2.0
"""many_ranks_test.py SOURCE PROGRAMS RANKS TEST MPIEXEC...: on as many ranks as RANKS says, far more than there are processors, pictures are
those of one rank, to the bit. A scene has everything: a volume, an isosurface, particles, samples of an isosurface, lines of a gradient through
them, shadows and ambient occlusion. TEST is one of those below, or ManyRanks for all."""
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

SOURCE, PROGRAMS, RANKS = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve(), int(sys.argv[3])
TEST, MPIEXEC = sys.argv[4], sys.argv[5:]
sys.path[:0] = [str(SOURCE / folder) for folder in ("tests/clients", "python/src")]
from server import Server  # noqa: E402
import gxy.client  # noqa: E402

# How ranks start: at low priority, which leaves the launcher the processors. Of Open MPI it is an error if a process ends before the
# launcher has heard that MPI has, so where there are hundreds, their shells wait for that.
LOW = ["sh", "-c", f'"$@"; status=$?; sleep {RANKS // 100 * 5}; exit $status', "sh", "nice", "-n", "19"]
SECONDS = 600  # that anything may take: hundreds of processes start on few processors
SIZE = [48, 36]
LOOK = {
    "Lighting": {"Sources": [[-1, -1.5, -0.7, 0]], "Ka": 0.4, "Kd": 0.7, "shadows": True, "ao count": 1, "ao radius": 0.3},
    "operators": [
        {"type": "Volume", "dataset": "turbulence", "volume rendering": True, "colormap": "Viridis",
         "extinctionmap": [[0, 0], [0.3, 0], [1, 8]], "isovalues": [0.75]},
        {"type": "Particles", "dataset": "particles", "radius": 0.01, "colormap": "Inferno"},
        {"type": "PathLines", "dataset": "lines", "radius": 0.008},
        {"type": "Particles", "dataset": "seeds", "radius": 0.02}],
}
SCENE = {
    "Datasets": [
        {"name": "turbulence", "type": "Volume", "filename": "turbulence.vti"},
        {"name": "particles", "type": "Particles", "filename": "particles.vtp"},
        {"name": "gradient", "type": "Volume", "filter": "Derive", "inputs": {"f": "turbulence"}, "expression": "grad(f)"},
        {"name": "seeds", "type": "Particles", "filter": "IsosurfaceSampler", "inputs": {"field": "turbulence"}, "isovalue": 0.5,
         "count": 40},
        {"name": "lines", "type": "PathLines", "filter": "StreamTracer", "inputs": {"vectors": "gradient", "seeds": "seeds"},
         "direction": "both", "length": 0.6}],
    "Visualization": LOOK,
    "Camera": {"viewpoint": [2.6, 1.7, 3.1], "viewcenter": [0, 0, 0], "viewup": [0, 1, 0], "aov": 38, "dimensions": SIZE},
}
# Without what filters make, for the window: the batch has them.
PLAIN = {**SCENE, "Datasets": SCENE["Datasets"][:2], "Visualization": {**LOOK, "operators": LOOK["operators"][:2]}}
STEP = {  # of a simulation
    "Datasets": [{"name": "NAME.oneBall", "type": "Volume"}],
    "Visualization": {"Lighting": LOOK["Lighting"], "operators": [
        {"type": "Volume", "dataset": "NAME.oneBall", "data range": [0, 1.7], "isovalues": [0.5], "colormap": "Viridis",
         "volume rendering": True, "extinctionmap": [[0, 0], [0.8, 0.5], [1.7, 2]]}]},
    "Camera": {**SCENE["Camera"], "viewpoint": [3, 2, 4]},
}


class ManyRanks(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        temporary = tempfile.TemporaryDirectory(prefix="galaxy-many-ranks-")
        cls.addClassCleanup(temporary.cleanup)
        cls.folder = pathlib.Path(temporary.name)
        cls.run_here("gxydata", "turbulence", "-r", 32, "turbulence.vti")
        cls.run_here("gxydata", "particles", "-r", 300, "particles.vtp")
        cls.run_here("gxydata", "radial", "-r", 24, "--array", "oneBall", "begin.vti")
        cls.run_here("gxydata", "radial", "-r", 24, "-t", 4, "--array", "oneBall", "end.vti")
        for name, state in {"scene": SCENE, "plain": PLAIN}.items():
            (cls.folder / f"{name}.json").write_text(json.dumps(state))
            cls.run_here("gxyrender", f"{name}.json", "-o", f"{name}-expected", "-q")

    @classmethod
    def run_here(cls, program, *options, launcher=(), environment=None):
        words = [*launcher, PROGRAMS / program, *options]
        done = subprocess.run([str(word) for word in words], cwd=cls.folder, text=True, timeout=SECONDS, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT,
                              env={**os.environ, "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1", **(environment or {})})
        if done.returncode != 0:
            raise AssertionError(f"{words}: exit status {done.returncode}\n{done.stdout}")

    def assert_same(self, picture, expected):
        found, wanted = ((self.folder / f"{name}_00000.png").read_bytes() for name in (picture, expected))
        self.assertTrue(found == wanted, f"{picture} differs from {expected}")

    def test_a_run_makes_the_picture_of_one_rank(self):
        self.run_here("gxyrender", "scene.json", "-o", "run", "-q", "--threads", 1, launcher=[*MPIEXEC, "-n", RANKS, *LOW])
        self.assert_same("run", "scene-expected")

    def test_so_does_a_server_for_clients_batches_and_simulations(self):
        server = Server(PROGRAMS, MPIEXEC, RANKS, ["--data", str(self.folder), "--threads", "1", "--rank-patience", str(SECONDS)],
                        seconds=SECONDS, wrapper=LOW)
        try:
            with gxy.client.Client(port=server.port, token_file=server.token) as client:
                for module in ("data", "insitu"):
                    client.request(f"load {module}")
                window = client.window(1, size=SIZE)
                client.request("data.import " + json.dumps({"Datasets": PLAIN["Datasets"]}))
                batch = {"prefix": "batch", "state": SCENE}
                client.request("viewer.batch " + json.dumps(batch))
                self.assert_same("batch", "scene-expected")
                window.set(PLAIN)
                gxy.client.write_png(self.folder / "window_00000.png", window.render(SECONDS).rgba)
                self.run_here("gxydiff", "--alpha", "window_00000.png", "plain-expected_00000.png")
                for senders, steps in ((4, 2), (16, 1)):
                    with self.subTest(senders=senders):
                        self.publish(server, senders, steps)
                client.request("quit")
        finally:
            status = server.stop(SECONDS)
        self.assertEqual(status, 0)

    def publish(self, server, senders, steps):
        """Steps of a simulation on so many ranks: a trigger makes a picture of each, which is that of the step's file."""
        name = f"of{senders}"
        state = json.loads(json.dumps(STEP).replace("NAME", name))
        triggers = [{"name": "movie", "when": {"every": 1}, "do": "batch", "exact": True,
                     "batch": {"prefix": name + "-{step}", "state": state}}]
        (self.folder / "options.json").write_text(json.dumps({"time-out": SECONDS, "triggers": triggers}))
        self.run_here("simsim", "begin.vti", "end_0001.vti", "-n", steps, "-d", 0, "-M", senders, "--policy", "wait", "--save", ".",
                      "--name", name, "-P", server.port, "--token-file", server.token,
                      environment={"GALAXY_INSITU_OPTIONS": str(self.folder / "options.json")})
        with gxy.client.Client(port=server.port, token_file=server.token) as client:
            client.request("load insitu")
            while client.request("insitu.streams")["streams"]:  # and so what the trigger has begun
                pass
        (self.folder / "step.json").write_text(json.dumps(state))
        for step in range(1, steps + 1):
            self.run_here("gxyrender", "step.json", "--dataset", f"{name}.oneBall={name}-{step}.vti", "-o", "file", "-q")
            self.assert_same(f"{name}-{step:08}", "file")


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], TEST], verbosity=2)

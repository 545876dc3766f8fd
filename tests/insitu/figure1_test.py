# SPDX-License-Identifier: Apache-2.0
"""figure1_test.py SOURCE PROGRAMS MPIEXEC...: figure 1 of the Galaxy paper, from a simulation that runs, on servers of 1, 2 and 4 ranks. simsim
publishes two steps. A trigger has the server make seeds on an isosurface, lines of the gradient through them, and a picture of each step
with slices of another field. These pictures, and the last step in a window on a view of a graph, are those that gxyrender makes of the
steps' files with the same state file, on as many ranks, to the bit."""
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time
import unittest

SOURCE, PROGRAMS, MPIEXEC = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve(), sys.argv[3:]
sys.path[:0] = [str(SOURCE / folder) for folder in ("tests/clients", "python/src")]
from server import Server  # noqa: E402
import gxy.client  # noqa: E402

FIELDS = ["eightBalls", "oneBall"]


def small(state):
    """The same at a size for tests."""
    state["Camera"]["dimensions"] = [160, 120]
    state["Renderer"]["rays per pixel"] = 1
    return state


class Figure1(unittest.TestCase):
    def test_each_step_has_the_picture_of_its_files(self):
        state = small(json.loads((SOURCE / "docs/examples/insitu/figure1.json").read_text()))
        with tempfile.TemporaryDirectory(prefix="galaxy-figure1-") as name:
            self.folder = pathlib.Path(name)
            (self.folder / "state.json").write_text(json.dumps(state))
            self.run_here(PROGRAMS / "gxydata", "radial", "-r", 24, "begin.vti")
            self.run_here(PROGRAMS / "gxydata", "radial", "-r", 24, "-t", 4, "end.vti")
            for ranks in (1, 2, 4):
                with self.subTest(ranks=ranks):
                    seen = self.publish(state, ranks)
                    for step in (1, 2):
                        self.assertEqual(self.render(step, ranks), seen[step], f"step {step}")
                    self.assertNotEqual(seen[1], seen[2])
            for kind in ("PathLines", "Particles", "Volume"):
                self.assert_seen(state, kind, seen[1])

    def publish(self, state, ranks):
        """The pictures of the steps that simsim publishes from three ranks to a server of so many."""
        server = Server(PROGRAMS, MPIEXEC, ranks, ["--data", str(self.folder)])
        try:
            options = {"time-out": 60, "triggers": [{"name": "movie", "when": {"every": 1}, "do": "batch", "exact": True,
                                                     "batch": {"prefix": "seen-{step}", "state": state}}]}
            (self.folder / "options.json").write_text(json.dumps(options))
            self.run_here(PROGRAMS / "simsim", "begin.vti", "end_0001.vti", *(word for field in FIELDS for word in ("--array", field)),
                          "-n", 2, "-d", 0, "-M", 3, "--policy", "wait", "--save", ".", "-P", server.port, "--token-file", server.token,
                          environment={"GALAXY_INSITU_OPTIONS": str(self.folder / "options.json")})
            with gxy.client.Client(port=server.port, token_file=server.token) as client:
                client.request("load insitu")
                end = time.monotonic() + 60
                while client.request("insitu.streams")["streams"]:  # and so what the trigger has begun
                    self.assertLess(time.monotonic(), end)
                    time.sleep(0.05)
                self.show_graph(client, state)
                client.request("quit")
        finally:
            self.assertEqual(server.stop(), 0)
        seen = {step: (self.folder / f"seen-{step:08}_00000.png").read_bytes() for step in (1, 2)}
        self.run_here(PROGRAMS / "gxydiff", "--alpha", "graph.png", "seen-00000002_00000.png")
        return seen

    def show_graph(self, client, state):
        """Leaves the picture of a view of a graph with the same document, which shows the last step."""
        document = json.loads(json.dumps(state))
        document["Visualization"]["name"] = "figure"
        client.request("load graph")
        client.request(f"graph.new fig1 {json.dumps(document)}")
        window = client.window(1, size=state["Camera"]["dimensions"])
        client.request('viewer.show 1 {"graph": "fig1", "view": "figure"}')
        nodes = client.request("graph.wait fig1")["nodes"]
        self.assertEqual({node["state"] for node in nodes}, {"done"}, nodes)
        gxy.client.write_png(self.folder / "graph.png", window.render().rgba)

    def render(self, step, ranks, state="state.json"):
        files = [word for field in FIELDS for word in ("--dataset", f"simsim.{field}=simsim-{step}.vti")]
        self.run_here(*MPIEXEC, "-n", ranks, PROGRAMS / "gxyrender", state, *files, "-o", "made", "-q")
        return (self.folder / "made_00000.png").read_bytes()

    def assert_seen(self, state, kind, picture):
        """Without the operator of this kind there would be another picture."""
        without = json.loads(json.dumps(state))
        operators = without["Visualization"]["operators"]
        operators[:] = [o for o in operators if o["type"] != kind]
        (self.folder / "without.json").write_text(json.dumps(without))
        self.assertNotEqual(self.render(1, 1, "without.json"), picture, kind)

    def run_here(self, *command, environment=None):
        done = subprocess.run([str(word) for word in command], cwd=self.folder, env={**os.environ, "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1", **(environment or {})}, text=True,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=120)
        self.assertEqual(done.returncode, 0, done.stdout)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])

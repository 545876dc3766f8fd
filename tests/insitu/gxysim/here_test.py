# SPDX-License-Identifier: Apache-2.0
"""here_test.py BUILD FORTRAN MPIEXEC...: a simulation of gxysim with a server beside, in its own processes, in the same MPI job, and loaded by
gxyserver. Triggers leave pictures of the same steps, which are the same to the bit, and the results of the simulation are those
of a run without Galaxy. FORTRAN is the program gxysim_heat_f90, empty if there is none."""
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT / folder) for folder in ("tests/clients", "python/src")]
from server import Server  # noqa: E402
import gxy.client  # noqa: E402

BUILD, FORTRAN, MPIEXEC = pathlib.Path(sys.argv[1]).resolve(), sys.argv[2], sys.argv[3:]
GXYSIM, GXYSERVER = BUILD / "bin" / "gxysim", BUILD / "bin" / "gxyserver"
STEPS, EVERY = 11, 5  # so that the last step is seen, too
# by simulation: arguments, and what its pictures show
SIMULATIONS = {
    "heat": (["--size", "20x18x16"], {
        "type": "Volume", "dataset": "heat.temperature", "colormap": "Viridis", "data range": [0, 1], "isovalues": [0.3],
        "slices": [[0, 0, 1, 0.55]], "volume rendering": True, "extinctionmap": [[0, 0.5], [1, 5]]}),
    "particles": (["--size", "500"], {
        "type": "Particles", "dataset": "particles.speed", "colormap": "Viridis", "data range": [0, 2], "radius": 0.05}),
}


class Here(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="galaxy-here-")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def options(self, simulation=None, **more):
        """The name of a file of options; with triggers for a simulation."""
        triggers = []
        if simulation:
            view = {"viewpoint": [7, 5, 9] if simulation == "particles" else [2.4, 1.6, 2.1], "viewcenter": [0.5, 0.5, 0.5],
                    "viewup": [0, 0, 1], "aov": 35, "dimensions": [96, 72]}
            state = {"Visualization": {"operators": [SIMULATIONS[simulation][1]]}, "Camera": view}
            triggers = [{"name": "movie", "when": {"every": EVERY}, "do": "batch", "exact": True,
                         "batch": {"prefix": "seen-{step}", "state": state}}]
        file = self.folder / "options.json"
        file.write_text(json.dumps({"policy": "wait", "time-out": 60, "triggers": triggers, **more}))
        return file

    def start(self, name, *command, options=None, to=None, **more):
        """Starts a command in a new folder, as a user does."""
        (self.folder / name).mkdir(exist_ok=True)
        environment = {**os.environ, "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
                       "GALAXY_INSITU_OPTIONS": str(options or "")}
        if to:
            environment["GALAXY_INSITU"] = to
        return subprocess.Popen([str(word) for word in command], cwd=self.folder / name, env=environment, text=True,
                                stdout=subprocess.PIPE, stderr=subprocess.STDOUT, **more)

    def run_to_its_end(self, *arguments, status=0, **more):
        process = self.start(*arguments, **more)
        text, _ = process.communicate(timeout=100)
        self.assertEqual(process.returncode, status, text)
        return text

    def pictures(self, name):
        return {file.name: file.read_bytes() for file in sorted((self.folder / name).glob("seen-*"))}

    def await_port(self, name):
        file = self.folder / name / "port"
        for _ in range(1200):
            if file.exists() and file.read_text():
                return int(file.read_text())
            time.sleep(0.05)
        self.fail("the server does not listen")

    def quit_when_done(self, port, result):
        """Stops a server once the simulation has its result and the streams have ended, and so what triggers have begun."""
        with gxy.client.Client(port=port) as client:
            client.request("load insitu")
            for _ in range(1200):
                if result.exists() and not client.request("insitu.streams")["streams"]:
                    break
                time.sleep(0.05)
            client.request("quit")

    def test_all_ways_show_the_same_and_the_simulation_computes_the_same(self):
        for simulation, (size, _) in SIMULATIONS.items():
            with self.subTest(simulation=simulation):
                self.compare_ways(simulation, [simulation, *size, "--steps", STEPS, "--output", "result.npy"])

    def compare_ways(self, simulation, arguments):
        (self.folder / simulation).mkdir()
        name = lambda way: f"{simulation}/{way}"  # noqa: E731
        options = self.options(simulation, here={"port": 0, "backend": "embree"})
        self.run_to_its_end(name("off"), *MPIEXEC, "-n", 3, GXYSIM, *arguments, to="off")

        (self.folder / name("beside")).mkdir()
        server = Server(BUILD / "bin", MPIEXEC, options=["--backend", "embree", "--data", str(self.folder / name("beside"))])
        beside = self.options(simulation, **{"token-file": str(server.token)})
        self.run_to_its_end(name("beside"), *MPIEXEC, "-n", 3, GXYSIM, *arguments, options=beside, to=f"127.0.0.1:{server.port}")
        with gxy.client.Client(port=server.port, token_file=server.token) as client:
            client.request("load insitu")
            for _ in range(1200):
                if not client.request("insitu.streams")["streams"]:
                    break
                time.sleep(0.05)
            client.request("quit")
        self.assertEqual(server.stop(), 0)

        options = self.options(simulation, here={"port": 0, "backend": "embree"})
        elsewhere = self.folder / simulation / "program"  # not beside Galaxy
        shutil.copy(GXYSIM, elsewhere)
        for ranks in (1, 2):
            self.run_to_its_end(name(f"here-{ranks}"), *MPIEXEC, "-n", ranks, elsewhere, *arguments, options=options, to="here")
        text = self.run_to_its_end(name("world"), *MPIEXEC, "-n", 2, GXYSIM, "--world", *arguments, ":", "-n", 2, GXYSERVER, "--world",
                                   "--port", 0, "--backend", "embree", options=options)
        self.assertIn("gxyserver: stopped", text)
        loaded = self.start(name("loaded"), *MPIEXEC, "-n", 2, GXYSERVER, "--port", 0, "--port-file", "port", "--backend", "embree",
                            "--simulation", "gxysim", "--", *arguments, options=options)
        self.quit_when_done(self.await_port(name("loaded")), self.folder / name("loaded") / "result.npy")
        text, _ = loaded.communicate(timeout=60)
        self.assertEqual(loaded.returncode, 0, text)

        result = (self.folder / name("off") / "result.npy").read_bytes()
        expected = self.pictures(name("beside"))
        self.assertEqual(len(expected), 3)
        self.assertEqual(len(set(expected.values())), 3, "the pictures differ")
        for way in ("beside", "here-1", "here-2", "world", "loaded"):
            with self.subTest(way=way):
                self.assertEqual((self.folder / name(way) / "result.npy").read_bytes(), result)
                found = self.pictures(name(way))
                self.assertEqual(list(found), list(expected), text if way == "loaded" else None)
                self.assertEqual(found, expected)

    @unittest.skipUnless(FORTRAN, "there is no Fortran compiler")
    def test_fortran_shows_what_c_shows(self):
        options = self.options("heat", here={"port": 0, "backend": "embree"})
        self.run_to_its_end("c", *MPIEXEC, "-n", 2, GXYSIM, "heat", "--size", "20x18x16", "--steps", STEPS, "--output", "result.npy",
                            options=options, to="here")
        program = [FORTRAN, 20, 18, 16, STEPS, "result.npy", "heat", 60]
        for ranks in (1, 2):
            self.run_to_its_end(f"here-{ranks}", *MPIEXEC, "-n", ranks, *program, options=options, to="here")
        text = self.run_to_its_end("world", *MPIEXEC, "-n", 2, *program, "--world", ":", "-n", 2, GXYSERVER, "--world", "--port", 0,
                                   "--backend", "embree", options=options)
        self.assertIn("gxyserver: stopped", text)
        self.run_to_its_end("off", *MPIEXEC, "-n", 2, *program, options=options, to="off")
        self.assertEqual(len(self.pictures("c")), 3)
        for way in ("here-1", "here-2", "world"):
            with self.subTest(way=way):
                self.assertEqual(self.pictures(way), self.pictures("c"))
        for way in ("off", "here-1", "here-2", "world"):
            with self.subTest(way=way):
                self.assertEqual((self.folder / way / "result.npy").read_bytes(), (self.folder / "c" / "result.npy").read_bytes())

    def test_a_server_that_is_stopped_does_not_stop_the_simulation(self):
        loaded = self.start("loaded", *MPIEXEC, "-n", 2, GXYSERVER, "--port", 0, "--port-file", "port", "--simulation", "gxysim", "--",
                            "heat", "--size", 16, "--steps", 80, "--seconds-per-step", 0.1, "--last", 0, "--output", "result.npy",
                            options=self.options(policy="skip", **{"time-out": None, "reconnect": 0}))
        with gxy.client.Client(port=self.await_port("loaded")) as client:
            client.request("quit")
        text, _ = loaded.communicate(timeout=60)
        self.assertEqual(loaded.returncode, 0, text)
        self.assertLess(text.index("gxyserver: stopped"), text.index("heat: step 80"))
        self.assertTrue((self.folder / "loaded" / "result.npy").exists())

    def test_what_cannot_be_is_told(self):
        arguments = ["heat", "--size", 16, "--steps", 2]
        for command, words, status in (
                (["--simulation", "nothing"], "there is no galaxy_nothing.so, looked for in", 1),
                (["--simulation", "data"], "has no function galaxy_simulation", 1),
                (["--simulation", "../x"], "expected a bare name", 1),
                (["--simulation", "gxysim", "--world"], "--world", 2)):
            with self.subTest(command=command):
                self.assertIn(words, self.run_to_its_end("wrong", GXYSERVER, "--port", 0, *command, status=status))
        for here, words in (({"bind": "somewhere"}, '"bind": found "somewhere"'), ({"port": -1}, '"port": expected an integer'), ({"ports": 0}, 'there is no "ports"'),
                            ({"port": 0, "backend": "none"}, "none")):
            with self.subTest(here=here):
                text = self.run_to_its_end("wrong", GXYSIM, *arguments, options=self.options(here=here), to="here")
                self.assertIn("step 2,", text)
                self.assertIn(words, text)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])

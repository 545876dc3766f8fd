# SPDX-License-Identifier: Apache-2.0
"""gxysim_test.py BUILD FORTRAN MPIEXEC...: the simulations of gxysim, on several numbers of ranks, off and publishing to one server on
two ranks. Their results are those of closed forms, the same to the bit everywhere, and what the server has in the end. FORTRAN: the
program gxysim_heat_f90, empty if there is none."""
import base64
import json
import os
import pathlib
import re
import struct
import subprocess
import sys
import unittest

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT / folder) for folder in ("tests/clients", "python/src")]
from server import Server  # noqa: E402
import gxy.client  # noqa: E402

BUILD, FORTRAN, MPIEXEC = pathlib.Path(sys.argv[1]).resolve(), sys.argv[2], sys.argv[3:]
STEPS = 24
# by simulation: size, the field of `--output`, and its others
SIMULATIONS = {"heat": ("20x18x16", "temperature"), "blobs": ("20x18x16", "density", "velocity"),
               "particles": ("2000", "speed", "velocity")}


def vti(path, values, of):
    """Writes values by z, y and x, of points or cells of the unit cube, to a file."""
    cells = [n - (of == "PointData") for n in values.shape[::-1]]
    extent = " ".join(f"0 {n}" for n in cells)
    kind = {"f4": "Float32", "f8": "Float64"}[values.dtype.str[1:]]
    data = base64.b64encode(struct.pack("<Q", values.nbytes) + values.tobytes()).decode()
    path.write_text(
        f'<VTKFile type="ImageData" version="1.0" byte_order="LittleEndian" header_type="UInt64"><ImageData '
        f'WholeExtent="{extent}" Origin="0 0 0" Spacing="{" ".join(repr(1 / n) for n in cells)}"><Piece Extent="{extent}">'
        f'<{of}><DataArray type="{kind}" Name="values" format="binary">{data}</DataArray></{of}>'
        '</Piece></ImageData></VTKFile>')


def state(dataset, least, most, particles=False):
    """A view of the whole: of a volume, translucent with a surface and a slice."""
    operator = {"type": "Particles", "radius": 0.05} if particles else {
        "type": "Volume", "isovalues": [(least + most) / 2], "slices": [[0, 0, 1, 0.55]], "opacity": 0.5,
        "volume rendering": True, "extinctionmap": [[least, 0.1], [most, 4]]}
    return {
        "Visualization": {"operators": [{**operator, "dataset": dataset, "colormap": "Viridis", "data range": [least, most]}]},
        "Camera": {"viewpoint": [7, 5, 9] if particles else [2.4, 1.6, 2.1], "viewcenter": [0.5, 0.5, 0.5],
                   "viewup": [0, 0, 1], "aov": 35, "dimensions": [192, 144]},
    }


class Gxysim(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = Server(BUILD / "bin", MPIEXEC, options=["--backend", "embree"])
        cls.addClassCleanup(cls.server.stop)
        cls.folder = cls.server.folder
        cls.client = gxy.client.Client(port=cls.server.port, token_file=cls.server.token)
        cls.addClassCleanup(cls.client.close)
        cls.addClassCleanup(cls.client.request, "quit")
        for module in ("data", "viewer", "insitu"):
            cls.client.request(f"load {module}")
        for name, more in {"skip": {}, "wait": {"policy": "wait", "time-out": 60}}.items():
            options = {"token-file": str(cls.server.token), "reconnect": 0.2, **more}
            (cls.folder / f"{name}.json").write_text(json.dumps(options))
        cls.windows = 0

    def start(self, ranks, *program, policy=None, status=0):
        """Runs a program to its end, as a user does, and returns what it prints. ranks: 0 without a launcher; policy: None if it is
        not to publish."""
        for file in ("result.npy", "fortran.npy"):
            if file in program:
                (self.folder / file).unlink(missing_ok=True)
        environment = {**os.environ, "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
                       "GALAXY_INSITU": f"127.0.0.1:{self.server.port}" if policy else "off"}
        if policy:
            environment["GALAXY_INSITU_OPTIONS"] = str(self.folder / f"{policy}.json")
        launcher = [*MPIEXEC, "-n", str(ranks)] if ranks else []
        done = subprocess.run([*launcher, *program], timeout=100, env=environment, cwd=self.folder,
                              capture_output=True, text=True)
        self.assertEqual(done.returncode, status, done.stdout + done.stderr)
        return done.stdout + done.stderr

    def gxysim(self, *options, ranks=1, **how):
        return self.start(ranks, BUILD / "bin" / "gxysim", *options, "--last", "60", **how)

    def result(self, *options, **how):
        """The array that gxysim writes, and what it prints."""
        text = self.gxysim(*options, "--output", "result.npy", **how)
        return np.load(self.folder / "result.npy"), text

    def picture(self, *view):
        type(self).windows += 1
        window = self.client.window(self.windows, size=(192, 144))
        window.set(state(*view))
        picture = window.render(levels=[1]).rgba
        window.close()
        self.assertGreater(picture.astype(int).std(), 10)  # there is something to see
        return picture

    def check_the_last_step(self, simulation, dataset, result):
        """The server's dataset is the last step, of which this is the array that gxysim writes."""
        particles = simulation == "particles"
        if particles:
            values, file = np.sqrt((result[:, 3:] ** 2).sum(1)).astype(np.float32), self.folder / "result.csv"
            file.write_text("x,y,z,speed\n" + "".join(
                ",".join(map(repr, row)) + "\n" for row in np.column_stack([result[:, :3], values]).tolist()))
        else:
            values, file = result, self.folder / "result.vti"
            vti(file, result, "PointData" if simulation == "heat" else "CellData")
        info = self.client.request(f"data.info {dataset}")["datasets"][0]
        self.assertEqual([origin["step"] for origin in info["origins"]], [STEPS])
        if particles:
            self.assertEqual(info["primitives"], len(result))
            np.testing.assert_array_equal(np.reshape(info["box"], (2, 3)), [result.min(0)[:3], result.max(0)[:3]])
        least, most = float(values.min()), float(values.max())
        self.assertEqual(info["range"], [least, most])
        self.client.request(f"data.import like {dataset} " + json.dumps(
            {"Datasets": {"name": "result", "type": "Particles" if particles else "Volume", "filename": file.name}}))
        np.testing.assert_array_equal(self.picture(dataset, least, most, particles),
                                      self.picture("result", least, most, particles))

    def test_results_are_the_same_to_the_bit_and_the_server_has_them(self):
        for simulation, (size, *fields) in SIMULATIONS.items():
            run = simulation, "--size", size, "--steps", str(STEPS)
            expected, text = self.result(*run)
            checksum = re.search("checksum [0-9a-f]{16}", text)[0]
            self.assertGreater(expected.std(), 0)
            for ranks, policy, *more in ((2, "wait"), (3, "skip", "--blocks", "1x3x1"), (4, None, "--blocks", "2x1x2")):
                with self.subTest(simulation=simulation, ranks=ranks, policy=policy):
                    name = f"{simulation}{ranks}"
                    for field in fields:
                        self.client.request(f"data.observe {name}.{field}")
                    found, text = self.result(*run, "--name", name, "--every", "2", *more, ranks=ranks, policy=policy)
                    self.assertEqual(found.tobytes(), expected.tobytes())
                    self.assertIn(checksum, text)
                    if simulation == "particles":
                        self.assertGreater(int(re.search(r"(\d+) move\(s\)", text)[1]), 20)
                    if policy:
                        self.assertIn(f"{name}: {STEPS // 2} step(s) offered", text)
                        self.check_the_last_step(simulation, f"{name}.{fields[0]}", expected)
                    if policy == "wait":
                        self.assertIn(f" {STEPS // 2 - 1} taken", text)

    def test_fortran_has_the_same_results_as_c(self):
        if not FORTRAN:
            self.skipTest("no Fortran compiler with MPI")
        size = SIMULATIONS["heat"][0]
        expected, _ = self.result("heat", "--size", size, "--steps", str(STEPS))
        for ranks in (1, 3):
            with self.subTest(ranks=ranks):
                self.start(ranks, FORTRAN, *size.split("x"), str(STEPS), "fortran.npy", f"fortran{ranks}", "60", policy="wait")
                self.assertEqual((self.folder / "fortran.npy").read_bytes(), (self.folder / "result.npy").read_bytes())
                self.check_the_last_step("heat", f"fortran{ranks}.temperature", expected)

    def test_heat_decays_as_a_sine_mode_does(self):
        """The mode is an eigenvector of the stencil, so that each step divides it by the same number; and it converges to
        exp(-3 pi^2 t) with the square of the spacing, the time step being as that."""
        n = np.array((17, 13, 10))
        c = (n - 1.0) ** 2 * 0.45 / ((n - 1.0) ** 2).sum()
        factor = 1 - 4 * (c * np.sin(np.pi / 2 / (n - 1)) ** 2).sum()
        x, y, z = (np.sin(np.pi * np.arange(m) / (m - 1)) for m in n)
        found, _ = self.result("heat", "--start", "sine", "--size", "17x13x10", "--steps", "40", ranks=2)
        np.testing.assert_allclose(found, factor ** 40 * z[:, None, None] * y[:, None] * x, atol=1e-14)
        errors = []
        for points, steps in ((9, 20), (17, 80)):
            found, _ = self.result("heat", "--start", "sine", "--size", str(points), "--steps", str(steps))
            errors.append(found.max() - np.exp(-3 * np.pi ** 2 * steps * 0.15 / (points - 1) ** 2))
        self.assertAlmostEqual(errors[0] / errors[1], 4, delta=0.3)

    def test_blobs_go_with_the_flow(self):
        """The flow has no divergence, so that a cell has the density of the place where its content was; nothing is lost."""
        def velocity(x):
            p, slope = 16 * (x * (1 - x)) ** 2, 32 * x * (1 - x) * (1 - 2 * x)
            return np.stack([p[0] * (slope[1] - slope[2]), -p[1] * slope[0], p[2] * slope[0]])

        def exact(cells, time):
            x = (np.indices((cells, cells, cells))[::-1] + 0.5) / cells
            for _ in range(20):  # back along the path, by the classical method of Runge and Kutta
                h = -time / 20
                k1 = velocity(x)
                k2 = velocity(x + h / 2 * k1)
                k3 = velocity(x + h / 2 * k2)
                x = x + h / 6 * (k1 + 2 * k2 + 2 * k3 + velocity(x + h * k3))
            blobs = ((0.3, 0.5, 0.5, 0.1, 1), (0.65, 0.7, 0.4, 0.08, 0.8), (0.6, 0.3, 0.7, 0.07, 0.9))
            return sum(a * np.exp(-((x.T - b) ** 2).sum(-1).T / (2 * r * r)) for *b, r, a in blobs)

        errors = []
        for cells, steps in ((24, 36), (48, 72)):
            found, _ = self.result("blobs", "--size", str(cells), "--steps", str(steps), ranks=2, policy="skip")
            start = exact(cells, 0)
            self.assertAlmostEqual(found.sum(dtype=float) / start.sum(), 1, delta=1e-6)
            self.assertGreaterEqual(found.min(), 0)
            self.assertLessEqual(found.max(), start.max())
            errors.append(abs(found - exact(cells, steps * 0.5 / (12.4 * cells))).mean())
        self.assertGreater(errors[0] / errors[1], 3)

        p = 16 * (np.arange(49) / 48 * (1 - np.arange(49) / 48)) ** 2
        mean, slope = (p[1:] + p[:-1]) / 2, np.diff(p) * 48
        x, y, z = np.ix_(range(48), range(48), range(48))
        speed = np.sqrt((mean[x] * (slope[y] - slope[z])) ** 2 + (mean[y] * slope[x]) ** 2 + (mean[z] * slope[x]) ** 2)
        info = self.client.request("data.info blobs.velocity")["datasets"][0]
        self.assertEqual((info["components"], info["origins"][0]["step"]), (3, steps))
        np.testing.assert_allclose(info["range"], [speed.min(), speed.max()], rtol=1e-6)

    def test_particles_go_round_as_another_method_says(self):
        """And keep their angular momentum, as any method of splitting does in a central field."""
        def change(state):
            x, v = state
            return np.stack([v, -x / ((x * x).sum(1) + 0.01)[:, None] ** 1.5])

        first, _ = self.result("particles", "--size", "500", "--steps", "1")
        last, _ = self.result("particles", "--size", "500", "--steps", "201", ranks=2)
        state, h = np.stack([first[:, :3], first[:, 3:]]), 0.01
        for _ in range(200):
            k1 = change(state)
            k2 = change(state + h / 2 * k1)
            k3 = change(state + h / 2 * k2)
            state = state + h / 6 * (k1 + 2 * k2 + 2 * k3 + change(state + h * k3))
        np.testing.assert_allclose(last[:, :3], state[0], atol=5e-3)
        np.testing.assert_allclose(np.cross(last[:, :3], last[:, 3:]), np.cross(first[:, :3], first[:, 3:]), atol=1e-12)

    def test_wrong_use_ends_with_one_clear_error(self):
        for options, text in {("waves",): "expected heat, blobs or particles, found 'waves'",
                              ("heat", "--steps", "0"): "--steps: expected a whole number from 1, found '0'",
                              ("heat", "--blocks", "2x2x1"): "--blocks: expected 1 block(s), as many as ranks, found 2x2x1",
                              ("blobs", "--size", "1x8x8"): "--size: expected"}.items():
            with self.subTest(options=options):
                self.assertEqual(self.gxysim(*options, ranks=0, status=2).count(f"gxysim: error: {text}"), 1)
        self.assertIn("result.npy: cannot be written", self.gxysim("heat", "--output", "no/result.npy", ranks=0, status=1))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])

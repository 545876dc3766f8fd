# SPDX-License-Identifier: Apache-2.0
"""lammps_test.py BUILD MPIEXEC...: LAMMPS as it is packaged, with the script of docs/examples/insitu, publishes its atoms to a server on two
ranks. They equal LAMMPS's own dump of the same step: their number, box and range of speeds, and a picture to the bit."""
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
from server import Server  # noqa: E402
import gxy.client  # noqa: E402

BUILD, MPIEXEC = pathlib.Path(sys.argv[1]).resolve(), sys.argv[2:]
HERE = pathlib.Path(__file__).resolve().parent
LAST = 60  # step


def atoms_of(dump):
    """The rows id, x, y, z, vx, vy, vz of the last step of a dump."""
    step = dump.split("ITEM: TIMESTEP\n")[-1]
    assert step.startswith(f"{LAST}\n")
    return np.array([[float(word) for word in line.split()] for line in step.split("ITEM: ATOMS")[1].splitlines()[1:]])


def state(dataset):
    return {
        "Visualization": {
            "Lighting": {"Sources": [[-1, -2, -1.6, 0]], "shadows": True},
            "operators": [{"type": "Particles", "dataset": dataset, "colormap": "Viridis", "data range": [0, 5],
                           "radius": 0.4}]},
        "Camera": {"viewpoint": [24, 18, 22], "viewcenter": [5, 4.2, 3.4], "viewup": [0, 0, 1], "aov": 28,
                   "dimensions": [192, 144]},
    }


class Lammps(unittest.TestCase):
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
        cls.options.write_text(json.dumps({"token-file": str(cls.server.token), "policy": "wait", "time-out": 60}))
        cls.windows = 0

    def run_lammps(self, ranks, to):
        """The dump that LAMMPS writes."""
        dump = self.server.folder / "dump.txt"
        dump.unlink(missing_ok=True)
        subprocess.run([*MPIEXEC, "-n", str(ranks), sys.executable, "-B", ROOT / "docs/examples/insitu/melt.py", HERE / "in.melt",
                        str(LAST)], cwd=self.server.folder, check=True, timeout=100, stdout=subprocess.DEVNULL, env={
            **os.environ, "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
            "PYTHONPATH": str(ROOT / "python" / "src"), "GALAXY_INSITU": to, "GALAXY_INSITU_OPTIONS": str(self.options)})
        for _ in range(600):  # so that the next run may have the same name
            if not self.client.request("insitu.streams")["streams"]:
                return dump.read_text()
            time.sleep(0.05)
        self.fail("the stream has not ended")

    def picture(self, dataset):
        type(self).windows += 1
        window = self.client.window(self.windows, size=(192, 144))
        window.set(state(dataset))
        picture = window.render(levels=[1]).rgba
        window.close()
        return picture

    def test_its_atoms_are_those_of_its_own_dump(self):
        for ranks in (1, 2, 3):
            with self.subTest(ranks=ranks):
                dump = self.run_lammps(ranks, f"127.0.0.1:{self.server.port}")
                self.assertEqual(dump, self.run_lammps(ranks, "off"), "LAMMPS computes something else when it publishes")
                atoms = atoms_of(dump)
                info = self.client.request("data.info lammps.velocity")["datasets"][0]
                self.assertEqual(([o["step"] for o in info["origins"]], info["primitives"]), ([LAST], len(atoms)))
                speeds = np.sqrt(np.sum(atoms[:, 4:] ** 2, axis=1)).astype(np.float32)
                np.testing.assert_allclose(info["range"], [speeds.min(), speeds.max()], rtol=2e-7)
                np.testing.assert_array_equal(np.reshape(info["box"], -1),
                                              np.concatenate([atoms[:, 1:4].min(axis=0), atoms[:, 1:4].max(axis=0)]))
                rows = ["x,y,z,velocity:0,velocity:1,velocity:2"] + [",".join(repr(v) for v in atom[1:].tolist()) for atom in atoms]
                (self.server.folder / "atoms.csv").write_text("\n".join(rows) + "\n")
                self.client.request("data.import like lammps.velocity " + json.dumps(
                    {"Datasets": {"name": "dump", "type": "Particles", "filename": "atoms.csv", "array": "velocity"}}))
                expected = self.picture("dump")
                self.assertGreater(expected.astype(int).std(), 10)  # there is something to see
                np.testing.assert_array_equal(self.picture("lammps.velocity"), expected)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])

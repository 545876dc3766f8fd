# SPDX-License-Identifier: Apache-2.0
"""volume_test.py BUILD MPIEXEC...: cells of all types from several ranks of a simulation to several ranks of a server, under MPI. Each step is
compared, by its numbers and by a picture to the bit, with the same step in one file."""
import json
import os
import pathlib
import subprocess
import sys
import time
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT / folder) for folder in ("tests/clients", "python/src")]
from server import Server  # noqa: E402
import gxy.client  # noqa: E402

BUILD, MPIEXEC = pathlib.Path(sys.argv[1]).resolve(), sys.argv[2:]
PROGRAMS, SIMULATION, STEPS = BUILD / "bin", BUILD / "tests" / "volume_simulation", (1, 2, 3, 4)


def state(dataset, **more):
    return {
        "Visualization": {"operators": [{
            "type": "Volume", "dataset": dataset, "colormap": "Viridis", "data range": [0, 4], "isovalues": [1.2],
            "slices": [[1, 0.2, 0, 0.4]], "volume rendering": True, "extinctionmap": [[0, 0.1], [4, 3]], **more}]},
        "Camera": {"viewpoint": [2.6, 1.9, 2.2], "viewcenter": [0.5, 0.5, 0.5], "viewup": [0, 0, 1], "aov": 30, "dimensions": [120, 90]},
    }


class Volumes(unittest.TestCase):
    def test_each_step_is_that_of_a_file_on_all_numbers_of_ranks(self):
        for ranks, servers in ((3, 2), (2, 3)):
            with self.subTest(ranks=ranks, servers=servers):
                self.compare(ranks, servers)

    def compare(self, ranks, servers):
        server = Server(PROGRAMS, MPIEXEC, servers, ["--backend", "embree"])
        try:
            subprocess.run([str(SIMULATION), str(server.folder / "file")], check=True, timeout=60)
            with gxy.client.Client(port=server.port, token_file=server.token) as client:
                for module in ("data", "viewer", "insitu"):
                    client.request(f"load {module}")
                self.publish(server, client, ranks)
                for step in STEPS:
                    self.compare_step(server, client, step)
                client.request("quit")
        finally:
            self.assertEqual(server.stop(), 0)

    def publish(self, server, client, ranks):
        """A trigger leaves a picture of each step."""
        options = {"policy": "wait", "time-out": 60, "token-file": str(server.token),
                   "triggers": [{"name": "movie", "when": {"every": 1}, "do": "batch", "exact": True,
                                 "batch": {"prefix": "seen-{step}", "state": state("cube.value")}}]}
        (server.folder / "options.json").write_text(json.dumps(options))
        subprocess.run([*MPIEXEC, "-n", str(ranks), str(SIMULATION)], check=True, timeout=60, env={
            **os.environ, "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
            "GALAXY_INSITU": f"127.0.0.1:{server.port}", "GALAXY_INSITU_OPTIONS": str(server.folder / "options.json")})
        for _ in range(600):
            if not client.request("insitu.streams")["streams"]:  # and so what triggers have begun
                return
            time.sleep(0.05)
        self.fail("the stream has not ended")

    def compare_step(self, server, client, step):
        client.request("data.import like cube.value " + json.dumps(
            {"Datasets": {"name": "file", "type": "Volume", "filename": f"file.{step}.vtu"}}))
        client.request("viewer.batch " + json.dumps({"prefix": f"file-{step}", "state": state("file")}))
        seen, expected = (server.folder / name for name in (f"seen-{step:08}_00000.png", f"file-{step}_00000.png"))
        self.assertGreater(expected.stat().st_size, 1000, "there is something to be seen")
        self.assertEqual(seen.read_bytes(), expected.read_bytes(), f"step {step}")
        if step == STEPS[-1]:
            self.compare_cells(server, client, step)
            found, imported = (client.request(f"data.info {name}")["datasets"][0] for name in ("cube.value", "file"))
            for key in ("range", "box", "components", "partitions"):
                self.assertEqual(found[key], imported[key], key)
            # Ranks have points in common, which a file has once.
            self.assertGreater(found["mesh"].pop("merged points"), 0)
            self.assertEqual(found["mesh"], imported["mesh"])

    def compare_cells(self, server, client, step):
        """A field of cells, as it is and smooth."""
        client.request("data.import like cube.load " + json.dumps(
            {"Datasets": {"name": "cells", "type": "Volume", "filename": f"file.{step}.vtu", "array": "load"}}))
        for cells in ("flat", "smooth"):
            for name, dataset in (("ours", "cube.load"), ("theirs", "cells")):
                client.request("viewer.batch " + json.dumps(
                    {"prefix": f"{name}-{cells}", "state": state(dataset, cells=cells, isovalues=[])}))
            seen, expected = (server.folder / f"{name}-{cells}_00000.png" for name in ("ours", "theirs"))
            self.assertGreater(expected.stat().st_size, 1000, "there is something to be seen")
            self.assertEqual(seen.read_bytes(), expected.read_bytes(), cells)
        flat, smooth = ((server.folder / f"ours-{cells}_00000.png").read_bytes() for cells in ("flat", "smooth"))
        self.assertNotEqual(flat, smooth)
        client.request("data.export cube.load exported.vtu")
        client.request("data.import like cube.load " + json.dumps(
            {"Datasets": {"name": "exported", "type": "Volume", "filename": "exported.vtu"}}))
        client.request("viewer.batch " + json.dumps({"prefix": "exported", "state": state("exported", cells="smooth", isovalues=[])}))
        self.assertEqual((server.folder / "exported_00000.png").read_bytes(), smooth)
        arrays = client.fetch("cube.load")
        self.assertEqual(arrays["structure"]["points"].shape, (arrays["points"], 3))
        self.assertEqual(len(arrays["fields"]["load"]), arrays["cells"])
        self.assertEqual((arrays["values"], len(arrays["structure"]["offsets"])), ("cells", arrays["cells"] + 1))
        found, imported = (client.request(f"data.info {name}")["datasets"][0] for name in ("cube.load", "cells"))
        self.assertEqual((found["mesh"]["values"], found["range"]), (imported["mesh"]["values"], imported["range"]))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])

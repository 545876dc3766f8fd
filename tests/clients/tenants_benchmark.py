#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""tenants_benchmark.py PROGRAMS: what a tenant's frames lose to another tenant's windows, and what these lose.

One tenant asks for 256 x 256 pixels of an isosurface again and again, on a server of one rank: alone, and beside windows of
another tenant (1000 x 1000 pixels, 64 rays a pixel, 64 occlusion rays a hit), which never end. Prints the median and the 90th
percentile of the frames' times, and the rays a second that the windows get of the rays that they get without the frames.
"""
import argparse
import contextlib
import json
import pathlib
import statistics
import subprocess
import sys
import time

from server import Server

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "python" / "src"))
import gxy.client  # noqa: E402

CAMERA = {"viewpoint": [1.9, 1.4, 2.3], "viewcenter": [0.5, 0.5, 0.5], "viewup": [0, 1, 0], "aov": 30,
          "dimensions": [256, 256]}


WINDOWS = 16  # of a client


def scene(occlusion, rays):
    return {"Renderer": {"rays per pixel": rays}, "Camera": CAMERA, "Visualization": {
        "Lighting": {"shadows": occlusion > 0, "ao count": occlusion, "ao radius": 0.5},
        "operators": [{"type": "Volume", "dataset": "turbulence", "colormap": "Viridis", "data range": [0, 1],
                       "isovalues": [0.5]}]}}


class Bench:
    def __init__(self, light, heavy, arguments):
        """`light`: a client; `heavy`: clients of the other tenant, each with its part of the windows."""
        self._light, self._arguments = light, arguments
        for client in (light, *heavy):
            client.request("load viewer")
        for client in (light, heavy[0]):
            client.request("load data")
            client.request("import " + json.dumps({"Datasets": {"name": "turbulence", "type": "Volume",
                                                                "filename": "turbulence.vti"}}))
        self._window = light.window(1, size=[256, 256])
        self._window.set(scene(0, 1))
        self._windows = [heavy[i // WINDOWS].window(i % WINDOWS + 1, size=[1000, 1000]) for i in range(arguments.windows)]
        self.frames(10)
        begin = self.rays()
        self.frames(10)
        self._rays_a_frame = (self.rays() - begin) / 10

    def rays(self):
        return sum(rank["rays"]["traced"] for rank in self._light.request("stat")["ranks"])

    def frames(self, number):
        """Seconds that each takes, from the request to the whole picture."""
        times = []
        for _ in range(number):
            begin = time.monotonic()
            self._window.render(timeout=600, levels=[1])
            times.append(time.monotonic() - begin)
        return times

    def begin_windows(self):
        for window in self._windows:
            window.set(scene(64, 64))
            window.start(levels=[1])

    def end_windows(self):
        for window in self._windows:
            window.close()

    def rate(self, deed):
        """Rays a second of the windows meanwhile, and what the deed returns."""
        begin, rays = time.monotonic(), self.rays()
        frames = deed()
        rays = self.rays() - rays - self._rays_a_frame * len(frames or [])
        return rays / (time.monotonic() - begin), frames

    def run(self):
        a = self._arguments
        alone = self.frames(a.frames)
        self.begin_windows()
        rates, beside = [], []
        for _ in range(a.turns):
            rate_alone, _ = self.rate(lambda: time.sleep(a.seconds))
            rate_beside, times = self.rate(lambda: self.frames(a.frames))
            rates.append(rate_beside / rate_alone)
            beside += times
        self.end_windows()
        alone += self.frames(a.frames)
        print("| 256 x 256 | median, ms | 9 of 10 below, ms | longest, ms |\n|---|---|---|---|")
        for name, times in (("alone", alone), (f"beside {a.windows} windows", beside)):
            ms = sorted(1e3 * t for t in times)
            print(f"| {name} | {statistics.median(ms):.1f} | {ms[len(ms) * 9 // 10]:.1f} | {ms[-1]:.1f} |")
        print(f"\nmedian {statistics.median(beside) / statistics.median(alone):.2f} times that alone, 9 of 10 below "
              f"{sorted(beside)[len(beside) * 9 // 10] / sorted(alone)[len(alone) * 9 // 10]:.2f} times; the windows keep "
              f"{statistics.median(rates):.2f} of their rate ({min(rates):.2f} to {max(rates):.2f})")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("programs", type=pathlib.Path, help="the folder of gxyserver and gxydata")
    parser.add_argument("--windows", type=int, default=30)
    parser.add_argument("--frames", type=int, default=60, help="of a turn")
    parser.add_argument("--seconds", type=float, default=3, help="of a turn, of the windows without the frames")
    parser.add_argument("--turns", type=int, default=5)
    parser.add_argument("--ranks", type=int, default=1)
    parser.add_argument("--threads", type=int, default=0, help="of each rank")
    parser.add_argument("--mpiexec", default="mpirun --bind-to none --oversubscribe")
    arguments = parser.parse_args()
    server = Server(arguments.programs, arguments.mpiexec.split(), arguments.ranks,
                    ["--tenant", "second", "--threads", str(arguments.threads)])
    try:
        subprocess.run([server.programs / "gxydata", "turbulence", "-r", "128", "turbulence.vti"], cwd=server.folder,
                       check=True, stdout=subprocess.DEVNULL)
        second = gxy.client.token_file(server.port, "second")
        with contextlib.ExitStack() as stack:
            light = stack.enter_context(gxy.client.Client(port=server.port, token_file=server.token))
            heavy = [stack.enter_context(gxy.client.Client(port=server.port, token_file=second))
                     for _ in range(0, max(arguments.windows, 1), WINDOWS)]
            Bench(light, heavy, arguments).run()
    finally:
        server.stop()


if __name__ == "__main__":
    sys.exit(main())

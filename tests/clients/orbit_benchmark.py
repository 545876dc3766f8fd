#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""orbit_benchmark.py PROGRAMS: the orbit of Galaxy's paper, section 5, on a server, as a batch whose PNGs go to the client.

500 frames of 1920 x 1080 about a volume (turbulence, 256^3), a mesh (1,046,528 triangles) and a set of particles (1,000,000
spheres), the last two with a shadow and an occlusion ray a hit; with 1, 10 and 50 frames in flight, on 1, 2 and 4 ranks; then
two tenants at once, with 10 each. Hours on a laptop; --short takes minutes: 60 frames of 480 x 270. Prints tables of frames
per second; pictures of one frame must be the same in all of them, else it fails.
"""
import argparse
import hashlib
import json
import math
import pathlib
import subprocess
import sys
import threading
import time

from server import Server

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "python" / "src"))
import gxy.client  # noqa: E402

LIGHT = {"Sources": [[3, 1, 4, 2]], "shadows": True, "ao count": 1, "ao radius": 0.3}
SCENES = {  # what is made, and how it is shown
    "volume": (["turbulence", "-r", "256", "volume.vti"],
               {"operators": [{"type": "Volume", "dataset": "volume", "colormap": "Viridis", "volume rendering": True,
                               "data range": [0, 1], "extinctionmap": [[0, 0], [0.3, 0], [1, 8]]}]}),
    "mesh": (["sphere-mesh", "-r", "512", "mesh.vtp"],
             {"Lighting": LIGHT, "operators": [{"type": "Triangles", "dataset": "mesh", "colormap": "Viridis"}]}),
    "particles": (["particles", "-r", "1000000", "particles.vtp"],
                  {"Lighting": LIGHT, "operators": [{"type": "Particles", "dataset": "particles", "colormap": "Inferno",
                                                     "radius0": 0.005, "radius1": 0.005}]}),
}


class Failure(Exception):
    pass


def state_of(scene, box, frames, size):
    """The whole orbit: about the box's middle, from so near that it fills the picture's height."""
    making, visualization = SCENES[scene]
    kind = visualization["operators"][0]["type"]
    low, high = box
    center = [(a + b) / 2 for a, b in zip(low, high)]
    distance = 1.15 * math.dist(low, high)
    cameras = []
    for i in range(frames):
        angle = 2 * math.pi * i / frames
        offset = [distance * math.sin(angle), 0.3 * distance, distance * math.cos(angle)]
        cameras.append({"viewpoint": [c + o for c, o in zip(center, offset)], "viewcenter": center, "viewup": [0, 1, 0],
                        "aov": 35, "dimensions": size})
    return {"Datasets": [{"name": scene, "type": kind, "filename": making[-1]}], "Visualization": visualization,
            "Cameras": cameras}


class Race:
    """Orbits that begin together: the frames per second of each until the first has ended."""

    def __init__(self, tokens):
        self._frames = dict.fromkeys(tokens, 0)
        self._ready = threading.Barrier(len(tokens), action=self._start, timeout=600)
        self._end = threading.Lock()
        self.rates = None

    def _start(self):
        self._begin = time.monotonic()

    def ready(self):
        self._ready.wait()

    def frame(self, token):
        self._frames[token] += 1

    def end(self):
        with self._end:
            if self.rates is None:
                seconds = time.monotonic() - self._begin
                self.rates = {token: frames / seconds for token, frames in self._frames.items()}


class Bench:
    def __init__(self, arguments):
        self._arguments = arguments
        self._sums = {}  # of pictures, by scene and name

    def serve(self, ranks):
        server = Server(self._arguments.programs, self._arguments.mpiexec.split(), ranks,
                        ["--tenant", "second", "--tenant-frames", "64"])
        for making, _ in SCENES.values():
            subprocess.run([server.programs / "gxydata", *making], cwd=server.folder, check=True, stdout=subprocess.DEVNULL)
        return server

    def orbit(self, server, scene, in_flight, token, race=None):
        """Frames per second, by token; waits for the others of the race when all is warm."""
        race = race or Race([token])

        def take(_, header, content):
            race.frame(token)
            digest = hashlib.sha256(content).hexdigest()
            if self._sums.setdefault((scene, header["name"]), digest) != digest:
                wrong.append(header["name"])

        wrong = []
        with gxy.client.Client(port=server.port, token_file=token, on_file=take) as client:
            client.request("load data")
            client.request("load viewer")
            making, visualization = SCENES[scene]
            if not any(d["name"] == scene for d in client.request("list")["datasets"]):
                client.request("import " + json.dumps({"Datasets": {
                    "name": scene, "type": visualization["operators"][0]["type"], "filename": making[-1]}}))
            box = client.request(f"info {scene}")["datasets"][0]["box"]
            state = state_of(scene, box, self._arguments.frames, self._arguments.size)
            # The server keeps a scene while somebody shows it.
            window = client.window(1, size=[64, 64])
            window.set({"Visualization": visualization, "Camera": state["Cameras"][0]})
            window.render(timeout=600)
            race.ready()
            client.request("batch " + json.dumps({"state": state, "to": "client", "concurrent": in_flight}))
            race.end()
        if wrong:
            raise Failure(f"{scene}: {len(wrong)} pictures are not those of the runs before, {wrong[0]} for one")
        return race.rates

    def run(self):
        a = self._arguments
        print("| scene | ranks | " + " | ".join(f"{n} in flight" for n in a.in_flight) + " | two tenants, 10 each |")
        print("|---|---|" + "---|" * (len(a.in_flight) + 1))
        for ranks in a.ranks:
            server = self.serve(ranks)
            try:
                own, other = server.token, self.second(server)
                for scene in a.scenes:
                    row = [f"{self.orbit(server, scene, n, own)[own]:.2f}" for n in a.in_flight]
                    both = self.together(server, scene, (own, other))
                    print(f"| {scene} | {ranks} | {' | '.join(row)} | {both[0]:.2f} + {both[1]:.2f} |", flush=True)
            finally:
                server.stop()

    @staticmethod
    def second(server):
        return pathlib.Path(gxy.client.token_file(server.port, "second"))

    def together(self, server, scene, tokens):
        race, done = Race(tokens), []

        def one(token):
            self.orbit(server, scene, 10, token, race)
            done.append(token)

        threads = [threading.Thread(target=one, args=(token,)) for token in tokens]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        if len(done) < len(tokens):
            raise Failure(f"{scene}: the orbit of one of two tenants failed")
        return [race.rates[token] for token in tokens]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("programs", type=pathlib.Path, help="the folder of gxyserver and gxydata")
    parser.add_argument("--short", action="store_true", help="60 frames of 480 x 270")
    parser.add_argument("--frames", type=int)
    parser.add_argument("--size", type=int, nargs=2)
    parser.add_argument("--ranks", type=int, nargs="+", default=[1, 2, 4])
    parser.add_argument("--in-flight", type=int, nargs="+", default=[1, 10, 50])
    parser.add_argument("--scenes", nargs="+", choices=SCENES, default=list(SCENES))
    parser.add_argument("--mpiexec", default="mpirun --bind-to none --oversubscribe")
    arguments = parser.parse_args()
    arguments.frames = arguments.frames or (60 if arguments.short else 500)
    arguments.size = arguments.size or ([480, 270] if arguments.short else [1920, 1080])
    try:
        Bench(arguments).run()
    except (Failure, gxy.client.GalaxyError) as e:
        print(f"orbit_benchmark.py: error: {e}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""orbit_benchmark.py PROGRAMS: figure 2 of Galaxy's paper (section 5), on a server, as batches whose PNGs go to the client.

A camera goes about a volume (turbulence, 1380 x 840 x 720 floats), a mesh (11.6 million triangles) and particles, the last two
with a shadow and an occlusion ray a hit, in 500 frames of 1920 x 1080, with 1, 10 and 50 of them in flight, on 1 to 16 ranks.
--frames 20 takes every 25th of the 500 views, so that the work of a frame stays the same. The data are made by gxydata in the
folder --data, and kept there. Prints a table, a row for each scene, number of ranks and frames in flight:

frames/s    between the request and the last picture at the client
CPU s       of all ranks, for a frame
messages    between ranks for a frame: of rays, of contributions, all; and their megabytes
ledger      the most that the ledgers of all ranks have held so far, summed, in megabytes
processes   the most that all ranks' processes have held so far, in megabytes (resident, looked at four times a second)

The same goes to OUT.json, and a chart of the frames a second to OUT.svg. What OUT.json has already of the same views and data
is not run again, so that a run may be interrupted, or done in parts. A server whose ranks together hold more than --memory
gigabytes is stopped, and its rows are left out. Pictures of one view must be the same in all runs, else the program fails.
--short takes tiny data and pictures, and half a minute.
"""
import argparse
import contextlib
import hashlib
import json
import math
import os
import pathlib
import subprocess
import sys
import threading
import time

from orbit_chart import chart
from server import Server

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "python" / "src"))
import gxy.client  # noqa: E402

VIEWS = 500
LIGHT = {"Sources": [[3, 1, 4, 2]], "shadows": True, "ao count": 1, "ao radius": 0.3}


class Failure(Exception):
    pass


class Scene:
    """`making`: the words of gxydata that make the file `file`; `visualization`: of the dataset, which is called as the scene."""

    def __init__(self, name, making, file, visualization):
        self.name, self.making, self.file, self.visualization = name, making, file, visualization
        self.type = visualization["operators"][0]["type"]

    def made(self, programs, folder):
        """The file, which is made if it is not there."""
        path = folder / self.file
        if not path.exists():
            partial = folder / f"partial-{self.file}"
            print(f"making {path}", file=sys.stderr)
            subprocess.run([programs / "gxydata", *self.making, partial], check=True, stdout=subprocess.DEVNULL)
            partial.rename(path)
        return path

    def state(self, box, frames, size):
        """The views of the orbit, about the box's middle, from so near that it fills the picture's height."""
        low, high = box
        center = [(a + b) / 2 for a, b in zip(low, high)]
        distance = 1.15 * math.dist(low, high)
        cameras = []
        for view in views(frames):
            angle = 2 * math.pi * view / VIEWS
            offset = [distance * math.sin(angle), 0.3 * distance, distance * math.cos(angle)]
            cameras.append({"viewpoint": [c + o for c, o in zip(center, offset)], "viewcenter": center,
                            "viewup": [0, 1, 0], "aov": 35, "dimensions": size})
        return {"Datasets": [{"name": self.name, "type": self.type, "filename": self.file}],
                "Visualization": self.visualization, "Cameras": cameras}


def views(frames):
    """Which of the orbit's views are taken."""
    return [i * VIEWS // frames for i in range(frames)]


def scenes_of(short, particles):
    """The scenes by name; `particles`: their number, or None."""
    grid, rows, particles = ("40,24,20", 40, particles or 2000) if short else ("1380,840,720", 1703, particles or 50_000_000)
    radius = 0.5 * particles ** (-1 / 3)
    volume = {"type": "Volume", "dataset": "volume", "colormap": "Viridis", "volume rendering": True, "data range": [0, 1],
              "extinctionmap": [[0, 0], [0.3, 0], [1, 8]]}
    scenes = [
        Scene("volume", ["turbulence", "-r", grid], f"turbulence-{grid.replace(',', 'x')}.vti", {"operators": [volume]}),
        Scene("mesh", ["sphere-mesh", "-r", str(rows), "--displacement", "0.1"], f"sphere-{rows}.vtp",
              {"Lighting": LIGHT, "operators": [{"type": "Triangles", "dataset": "mesh", "colormap": "Viridis"}]}),
        Scene("particles", ["particles", "-r", str(particles)], f"particles-{particles}.vtp",
              {"Lighting": LIGHT, "operators": [{"type": "Particles", "dataset": "particles", "colormap": "Inferno",
                                                 "radius0": radius, "radius1": radius}]})]
    return {scene.name: scene for scene in scenes}


class Ranks:
    """The processes of a server's ranks: their memory, which a thread watches, and their processor time."""

    def __init__(self, server, limit):
        """Ends the server once they hold more than `limit` bytes."""
        self.peak, self.passed = 0, False
        self._server, self._limit, self._ends = server, limit, threading.Event()
        self._thread = threading.Thread(target=self._watch)
        self._thread.start()

    def processes(self):
        """The processes below the one that starts the ranks."""
        below = [self._server.process]
        for pid in below:
            with contextlib.suppress(OSError):
                for thread in os.listdir(f"/proc/{pid}/task"):
                    below += map(int, pathlib.Path(f"/proc/{pid}/task/{thread}/children").read_text().split())
        return below[1:]

    def cpu_seconds(self):
        ticks = 0
        for pid in self.processes():
            with contextlib.suppress(OSError):
                ticks += sum(map(int, pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[11:13]))
        return ticks / os.sysconf("SC_CLK_TCK")

    def look(self):
        """Of the memory that the processes hold now, `peak` is the most."""
        pages = 0
        for pid in self.processes():
            with contextlib.suppress(OSError):
                pages += int(pathlib.Path(f"/proc/{pid}/statm").read_text().split()[1])
        self.peak = max(self.peak, pages * os.sysconf("SC_PAGE_SIZE"))

    def end(self):
        self._ends.set()
        self._thread.join()

    def _watch(self):
        while not self._ends.wait(0.25):
            self.look()
            if self.peak > self._limit and not self.passed:
                self.passed = True
                self._server.terminate()


COUNTS = ("rays", "contributions", "all")


def counters(client, ranks):
    """What the ranks have done so far, summed: messages and bytes by COUNTS, processor time; and their memory."""
    told = client.request("stat")["ranks"]
    ranks.look()
    sums = {"cpu": ranks.cpu_seconds(), "ledger": sum(r["memory"]["peak"] for r in told)}
    for what in ("messages", "bytes"):
        sums[f"rays {what}"] = sum(r["rays"][what] for r in told)
        sums[f"contributions {what}"] = sum(r["contributions"][what] for r in told)
        sums[f"all {what}"] = sum(r[what] for r in told)
    return sums


class Orbit:
    """One scene on one server."""

    def __init__(self, client, ranks, scene, folder, frames, size):
        self._client, self._ranks, self._scene = client, ranks, scene
        for module in ("data", "viewer"):
            client.request(f"load {module}")
        begin = time.monotonic()
        client.request("import " + json.dumps({"Datasets": {
            "name": scene.name, "type": scene.type, "filename": str(folder / scene.file)}}))
        self._seconds = [time.monotonic() - begin]
        self._state = scene.state(client.request(f"info {scene.name}")["datasets"][0]["box"], frames, size)
        # The server keeps a scene while somebody shows it.
        window = client.window(1, size=[64, 64])
        window.set({"Visualization": scene.visualization, "Camera": self._state["Cameras"][0]})
        window.render(timeout=None)
        self._seconds.append(time.monotonic() - begin - self._seconds[0])

    def run(self, in_flight):
        """A row of the table."""
        before, begin = counters(self._client, self._ranks), time.monotonic()
        self._client.request("batch " + json.dumps({"state": self._state, "to": "client", "concurrent": in_flight}))
        seconds, after = time.monotonic() - begin, counters(self._client, self._ranks)
        frames = len(self._state["Cameras"])
        row = {"scene": self._scene.name, "in flight": in_flight, "frames": frames, "frames/s": frames / seconds,
               "CPU s": (after["cpu"] - before["cpu"]) / frames, "import s": self._seconds[0], "scene s": self._seconds[1],
               "ledger": after["ledger"], "processes": self._ranks.peak}
        for what in ("messages", "bytes"):
            row[what] = [(after[f"{c} {what}"] - before[f"{c} {what}"]) / frames for c in COUNTS]
        return row


class Bench:
    def __init__(self, arguments):
        self._arguments = arguments
        self._what = {"frames": arguments.frames, "size": arguments.size, "cores": len(os.sched_getaffinity(0)),
                      "data": {scene.name: scene.file for scene in scenes_of(arguments.short, arguments.particles).values()}}
        self._results = arguments.out.with_suffix(".json")
        self.rows, self._sums = [], {}  # of pictures, by scene and view
        if self._results.exists():
            known = json.loads(self._results.read_text())
            if known["what"] != self._what:
                raise Failure(f"{self._results} is of {known['what']}, expected {self._what}; name another --out")
            self.rows, self._sums = known["rows"], known["pictures"]

    def is_known(self, scene, ranks, in_flight):
        return any((r["scene"], r["ranks"], r["in flight"]) == (scene.name, ranks, in_flight) for r in self.rows)

    def run(self):
        a = self._arguments
        print("| scene | ranks | in flight | frames/s | CPU s | messages: rays, contributions, all | MB | ledger, MB "
              "| processes, MB |")
        print("|---|---|---|---|---|---|---|---|---|", flush=True)
        for row in self.rows:
            self.show(row)
        for scene in a.scenes.values():
            scene.made(a.programs, a.data)
            for ranks in a.ranks:
                missing = [n for n in a.in_flight if not self.is_known(scene, ranks, n)]
                if missing:
                    self.serve(scene, ranks, missing)

    def serve(self, scene, number, numbers_in_flight):
        a = self._arguments
        server = Server(a.programs, a.mpiexec.split(), number,
                        ["--data", a.data, "--memory", str(int(a.memory * 1e9)), "--tenant-frames", "64"])
        ranks = Ranks(server, a.memory * 1e9)
        try:
            with gxy.client.Client(port=server.port, token_file=server.token, on_file=self.take(scene)) as client:
                orbit = Orbit(client, ranks, scene, a.data, a.frames, a.size)
                for in_flight in numbers_in_flight:
                    self.add({"ranks": number, **orbit.run(in_flight)})
                client.request("quit")
        except gxy.client.GalaxyError as e:
            if not ranks.passed:
                raise Failure(f"{scene.name} on {number} ranks: {e}\n{server.log()}") from e
            print(f"| {scene.name} | {number} | | more than {a.memory:g} GB | | | | | |", flush=True)
        finally:
            ranks.end()
            server.stop()

    def take(self, scene):
        """What compares each picture that comes with that of the same view in earlier runs."""
        numbers = views(self._arguments.frames)

        def compare(_, header, content):
            view = numbers[int(header["name"].rsplit("_", 1)[1].split(".")[0])]
            digest = hashlib.sha256(content).hexdigest()
            if self._sums.setdefault(f"{scene.name} {view}", digest) != digest:
                self._wrong = f"{scene.name}: the picture of view {view} is not that of the runs before"

        return compare

    _wrong = None

    def add(self, row):
        if self._wrong:
            raise Failure(self._wrong)
        self.rows.append(row)
        self.show(row)
        a = self._arguments
        self._results.write_text(json.dumps({"what": self._what, "rows": self.rows, "pictures": self._sums}, indent=1) + "\n")
        a.out.with_suffix(".svg").write_text(chart(self.rows, f"{a.frames} frames of {a.size[0]} x {a.size[1]}; "
                                                              f"all ranks share {self._what['cores']} cores"))

    @staticmethod
    def show(row):
        lists = [", ".join(f"{n:.0f}" for n in row["messages"]), ", ".join(f"{n / 1e6:.2f}" for n in row["bytes"])]
        print(f"| {row['scene']} | {row['ranks']} | {row['in flight']} | {row['frames/s']:.3g} | {row['CPU s']:.3g} | "
              f"{' | '.join(lists)} | {row['ledger'] / 1e6:.0f} | {row['processes'] / 1e6:.0f} |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("programs", type=pathlib.Path, help="the folder of gxyserver and gxydata")
    parser.add_argument("--data", type=pathlib.Path, required=True, help="a folder for the data")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("orbit"), help="of OUT.json and OUT.svg (orbit)")
    parser.add_argument("--short", action="store_true", help="tiny data, 4 frames of 96 x 54")
    parser.add_argument("--frames", type=int, help="of the 500 views; 1 to 500")
    parser.add_argument("--size", type=int, nargs=2)
    parser.add_argument("--ranks", type=int, nargs="+", default=[1, 2, 4, 8, 16])
    parser.add_argument("--in-flight", type=int, nargs="+", default=[1, 10, 50])
    parser.add_argument("--scenes", nargs="+", choices=["volume", "mesh", "particles"])
    parser.add_argument("--particles", type=int, help="how many (50000000)")
    parser.add_argument("--memory", type=float, default=16, help="GB that all ranks together may hold (16)")
    parser.add_argument("--mpiexec", 
                        default="mpirun --bind-to none --oversubscribe --mca mpi_yield_when_idle 1 "
                                "--mca btl_vader_single_copy_mechanism none")
    arguments = parser.parse_args()
    arguments.frames = arguments.frames or (4 if arguments.short else VIEWS)
    arguments.size = arguments.size or ([96, 54] if arguments.short else [1920, 1080])
    arguments.programs = arguments.programs.resolve()
    arguments.data.mkdir(parents=True, exist_ok=True)
    arguments.data = arguments.data.resolve()
    scenes = scenes_of(arguments.short, arguments.particles)
    arguments.scenes = {name: scenes[name] for name in arguments.scenes or scenes}
    try:
        Bench(arguments).run()
    except (Failure, subprocess.CalledProcessError) as e:
        print(f"orbit_benchmark.py: error: {e}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""remote_benchmark.py PROGRAMS: what a 1080p window of gxyviewer shows, on this machine and over slow links.

PROGRAMS: the folder of a build with tests (build/release/bin). Prints the table of docs/performance.md: frames a second while
the camera turns, what they are, and the time from a single change of the camera to the first pixels, and to the complete
lossless picture (which is asked for 250 ms after the change).
"""
import argparse
import json
import pathlib
import shutil
import subprocess

from link import Link
from server import Server

ROOT = pathlib.Path(__file__).resolve().parents[2]
LINKS = {"this machine": None, "100 Mbit/s, 10 ms": (100e6, 0.005), "20 Mbit/s, 40 ms": (20e6, 0.02),
         "2 Mbit/s, 40 ms": (2e6, 0.02)}
SCENES = {"performance/window.json": ["radial", "-r", "128", "radial.vti"], "particles.json": ["particles", "-r", "100000", "particles.vtp"]}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("programs", type=pathlib.Path)
    parser.add_argument("--ranks", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=10)
    parser.add_argument("--links", nargs="*", choices=LINKS, help="these only")
    parser.add_argument("--mpiexec", default="mpirun --bind-to none --oversubscribe")
    arguments = parser.parse_args()
    server = Server(arguments.programs, arguments.mpiexec.split(), arguments.ranks)
    try:
        print("| scene | link | frames/s | longest gap, ms | scale, quality | kB a frame | latency, ms | first pixels, ms "
              "| complete, ms |\n|---|---|---|---|---|---|---|---|---|")
        for scene, making in SCENES.items():
            subprocess.run([server.programs / "gxydata", *making], cwd=server.folder, check=True, stdout=subprocess.DEVNULL)
            shutil.copy(ROOT / "docs" / "examples" / scene, server.folder)
            for name in arguments.links or LINKS:
                link = Link(server.port, *LINKS[name]) if LINKS[name] else None
                done = subprocess.run(
                    [server.programs / "viewer_benchmark", pathlib.Path(scene).name, "-P", str(link.port if link else server.port),
                     "--token-file", server.token, "--seconds", str(arguments.seconds)],
                    cwd=server.folder, check=True, stdout=subprocess.PIPE, text=True)
                if link:
                    link.stop()
                m = json.loads(done.stdout)
                print(f"| {scene} | {name} | {m['frames per second']:.1f} | {1000 * m['longest interval']:.0f} "
                      f"| 1/{m['scale']}, {m['quality']} | {m['bytes per frame'] / 1000:.0f} | {1000 * m['latency']:.0f} "
                      f"| {1000 * m['first pixels']:.0f} | {1000 * m['complete']:.0f} |", flush=True)
    finally:
        server.stop()


if __name__ == "__main__":
    main()

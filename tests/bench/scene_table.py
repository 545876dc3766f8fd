#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""scene_table.py PROGRAMS: the table of docs/experiments/0011-scenes-on-several-ranks.md, in Markdown.

Makes the data, renders the states of docs/examples/performance on 1, 2, 4 and 8 ranks by gxyrender of the folder PROGRAMS
(such as build/release/bin), and prints a row for each. The time of a frame is a fifth of what a run of six frames, one after
the other, takes longer than a run of one: the first frame pays for memory that was never touched, which on a virtual machine
may take longer than the picture. Of two such pairs the one that took less. Pictures of a scene must be the same on any
number of ranks, else it fails. Minutes; --short takes seconds: two scenes of tiny data and pictures, on 1 and 2 ranks, to
see that it works.
"""
import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
STATES = ["volume", "isosurface", "isosurface-ao", "particles", "mesh", "mixed"]
DATA = [("turbulence", 256, 24, "turbulence.vti"), ("particles", 1_000_000, 2000, "particles.vtp"),
        ("sphere-mesh", 512, 16, "mesh.vtp")]


def total(path):
    """A column: the sum of a counter over all ranks, in millions."""
    return lambda ranks: sum(at(r, path) for r in ranks) / 1e6


def at(rank, path):
    for key in path.split("."):
        rank = rank[key]
    return rank


FRAMES = 6
TIMES = {  # heading: seconds of the ranks' counters
    "s": lambda ranks: max(at(r, "seconds.render") for r in ranks),
    "CPU s": lambda ranks: sum(at(r, "seconds.cpu render") for r in ranks),
}
COLUMNS = {  # heading: value of the counters of one frame, digits
    "M samples": (total("volumes.samples"), 1),
    "M rays": (lambda ranks: total("rays.spawned")(ranks) + total("rays.secondaries")(ranks), 2),
    "M forwarded": (total("rays.forwarded"), 2),
    "MB rays": (total("messages.ray bytes"), 1),
    "MB contributions": (total("messages.contribution bytes"), 1),
    "ledger MB": (total("memory.ledger total"), 0),
    "peak MB of a process": (lambda ranks: max(at(r, "memory.process peak") for r in ranks) / 1e6, 0),
}


def rendered(programs, folder, state, ranks, frames, options):
    """One run: counters of its ranks, and the bytes of its first picture."""
    name = f"{state}-{ranks}-{frames}"
    document = json.loads((ROOT / "docs" / "examples" / "performance" / f"{state}.json").read_text())
    document["Cameras"] = [document.pop("Camera")] * frames
    (folder / f"{name}.json").write_text(json.dumps(document))
    command = [ROOT / "tools" / "galaxy", "run", "-n", str(ranks), programs / "gxyrender", f"{name}.json", "-o", name,
               "--format", "raw", "--quiet", "--concurrent", "1", "--stats", f"{name}.stats.json", *options]
    subprocess.run(command, cwd=folder, check=True, stdout=sys.stderr)
    return (json.loads((folder / f"{name}.stats.json").read_text())["ranks"],
            (folder / f"{name}_00000.raw").read_bytes())


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("programs", type=pathlib.Path)
    parser.add_argument("--short", action="store_true")
    arguments = parser.parse_args()
    programs = arguments.programs.resolve()
    states, numbers, runs, options = STATES, [1, 2, 4, 8], 2, []
    if arguments.short:
        states, numbers, runs, options = ["mesh", "mixed"], [1, 2], 1, ["--size", "64x64"]
    headings = ["scene", "ranks", *TIMES, *COLUMNS]
    print("| " + " | ".join(headings) + " |")
    print("|" + "---|" * len(headings), flush=True)
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        for kind, size, tiny, file in DATA:
            subprocess.run([programs / "gxydata", kind, "-r", str(tiny if arguments.short else size), file], cwd=folder,
                           check=True, stdout=sys.stderr)
        for state in states:
            pictures = set()
            for ranks in numbers:
                times = []
                for _ in range(runs):
                    one, picture = rendered(programs, folder, state, ranks, 1, options)
                    more, same = rendered(programs, folder, state, ranks, FRAMES, options)
                    times.append([(value(more) - value(one)) / (FRAMES - 1) for value in TIMES.values()])
                    pictures |= {picture, same}
                row = [f"{value:.2f}" for value in min(times)]
                row += [f"{value(one):.{digits}f}" for value, digits in COLUMNS.values()]
                print(f"| {state} | {ranks} | " + " | ".join(row) + " |", flush=True)
            if len(pictures) != 1:
                sys.exit(f"scene_table.py: pictures of {state} differ between runs")


if __name__ == "__main__":
    main()

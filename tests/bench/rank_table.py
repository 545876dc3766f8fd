#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""rank_table.py PROGRAMS: the tables of docs/experiments/0020-many-ranks.md, in Markdown.

Makes small data, renders docs/examples/performance/mixed.json (a volume, an isosurface and particles, with shadows and ambient
occlusion) on 1 to 256 ranks by gxyrender of the folder PROGRAMS (such as build/release/bin), and prints what was sent between
the ranks, by kind: messages and bytes of all ranks together, and the most that one rank has sent and has received. "frame" is
what a run of two pictures has more than a run of one; "start" is what all ranks do together before: the import, the scene,
and what they agree about. The last table says how what the busiest rank has grows with the number of ranks, from 8 on, as a
power of it, and what that gives for 1,000.

Fails if a picture differs from that on one rank. Many ranks share a machine's cores here, so times say nothing. Ranks run at
low priority, and where there are hundreds their shells wait for a moment: of Open MPI it is an error if a process ends before
mpirun has heard that MPI has.
"""
import argparse
import json
import math
import pathlib
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
SENT, RECEIVED = ("messages sent", "bytes sent"), ("messages received", "bytes received")


def low(ranks):
    return ["sh", "-c", f'"$@"; status=$?; sleep {ranks // 100 * 5}; exit $status', "sh", "nice", "-n", "19"]


def rendered(programs, folder, ranks, frames, size):
    """One run: traffic of its ranks, and its pictures, which show the same."""
    name = f"{ranks}-{frames}"
    document = json.loads((ROOT / "docs" / "examples" / "performance" / "mixed.json").read_text())
    document["Cameras"] = [document.pop("Camera")] * frames
    (folder / f"{name}.json").write_text(json.dumps(document))
    command = [ROOT / "tools" / "galaxy", "run", "-n", str(ranks), *low(ranks), programs / "gxyrender", f"{name}.json", "-o", name,
               "--format", "raw", "--quiet", "--concurrent", "1", "--threads", "1", "--size", f"{size}x{size}",
               "--stats", f"{name}.stats.json"]
    begin = time.monotonic()
    subprocess.run(command, cwd=folder, check=True, stdout=sys.stderr)
    seconds = time.monotonic() - begin
    stats = json.loads((folder / f"{name}.stats.json").read_text())["ranks"]
    pictures = {path.read_bytes() for path in folder.glob(f"{name}_*.raw")}
    return [rank["messages"] for rank in stats], pictures, seconds


def counts(rank, kind):
    found = rank["kinds"].get(kind, {})
    return [found.get(key, 0) for key in SENT + RECEIVED]


def parts(one, two):
    """The traffic of a frame and of the start, as {kind: [counts of each rank]}."""
    kinds = sorted({kind for rank in two for kind in rank["kinds"]} - {"collective"})
    frame = {kind: [[b - a for a, b in zip(counts(r1, kind), counts(r2, kind))] for r1, r2 in zip(one, two)] for kind in kinds}
    return frame, {"collective": [counts(rank, "collective") for rank in one]}


def row(of):
    """Sum of messages, most sent and received by a rank; the same of bytes."""
    columns = list(zip(*of))
    return [sum(columns[0]), max(columns[0]), max(columns[2]), sum(columns[1]), max(columns[1]), max(columns[3])]


def growth(points):
    """Exponent of a power law through points (ranks, value), and its value at 1,000 ranks."""
    points = [(n, v) for n, v in points if n >= 8 and v > 0]
    if len(points) < 2:
        return None
    xs, ys = [math.log(n) for n, _ in points], [math.log(v) for _, v in points]
    mx, my = sum(xs) / len(xs), sum(ys) / len(ys)
    slope = sum((x - mx) * (y - my) for x, y in zip(xs, ys)) / sum((x - mx) ** 2 for x in xs)
    return slope, math.exp(my + slope * (math.log(1000) - mx))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("programs", type=pathlib.Path)
    parser.add_argument("--ranks", type=lambda text: [int(n) for n in text.split(",")], default=[1, 2, 4, 8, 16, 64, 256])
    parser.add_argument("--size", type=int, default=64, help="pixels of a side of the picture")
    parser.add_argument("--cells", type=int, default=48, help="points of the volume on each axis")
    arguments = parser.parse_args()
    programs = arguments.programs.resolve()
    tables = {"frame": {}, "start": {}}
    expected = None
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        for kind, size, file in [("turbulence", arguments.cells, "turbulence.vti"), ("particles", 2000, "particles.vtp")]:
            subprocess.run([programs / "gxydata", kind, "-r", str(size), file], cwd=folder, check=True, stdout=sys.stderr)
        for ranks in arguments.ranks:
            one, first, seconds = rendered(programs, folder, ranks, 1, arguments.size)
            two, both, _ = rendered(programs, folder, ranks, 2, arguments.size)
            expected = expected or first
            if first != expected or both != expected or len(expected) != 1:
                sys.exit(f"rank_table.py: a picture on {ranks} ranks differs from that on {arguments.ranks[0]}")
            for name, part in zip(tables, parts(one, two)):
                for kind, of in part.items():
                    tables[name].setdefault(kind, {})[ranks] = row(of)
            print(f"{ranks} ranks: the same picture; {seconds:.1f} s; most ranks that one has exchanged messages with: "
                  f"{max(r['partners'] for r in two)}; waves of a frame: "
                  f"{two[0]['completion waves'] - one[0]['completion waves']}", flush=True)
    headings = ["kind", "ranks", "messages", "most sent", "most received", "bytes", "most sent", "most received"]
    for name, table in tables.items():
        print(f"\n{name}:\n\n| " + " | ".join(headings) + " |\n|" + "---|" * len(headings))
        for kind, rows in table.items():
            for ranks, numbers in rows.items():
                if any(numbers):
                    print(f"| {kind} | {ranks} | " + " | ".join(f"{n:,}" for n in numbers) + " |")
    print("\n| part | kind | what of the busiest rank | grows as ranks to the power | at 1,000 ranks |\n|---|---|---|---|---|")
    columns = {"messages sent": 1, "messages received": 2, "bytes sent": 4, "bytes received": 5}
    for name, table in tables.items():
        for kind, rows in table.items():
            for what, column in columns.items():
                fit = growth([(ranks, numbers[column]) for ranks, numbers in rows.items()])
                if fit:
                    print(f"| {name} | {kind} | {what} | {fit[0]:.2f} | {fit[1]:,.0f} |")


if __name__ == "__main__":
    main()

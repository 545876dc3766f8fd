#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""insitu_bench.py PROGRAMS: what it costs a simulation to publish its steps, and how fast they are there.

Measures gxy_publish() where no step is taken, copies of arrays beside memcpy, whole steps from M ranks of a simulation to N ranks of
a server beside plain TCP between as many processes, the time from a publish to the event `updated` at a client, and the processor time
of a simulation with and without a server. All in one run on one machine, in turns, so that ratios hold on others; of the turns, what was
best. Prints tables and writes all numbers with --json. Fails where anything is sent or a system call is made for a step that is not taken,
where a step is left out, or where the results of the simulation differ. Minutes; --quick takes seconds with tiny data, to see that it works.
"""
import argparse
import json
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile
import threading
import time

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT / folder) for folder in ("tests/clients", "python/src")]
from server import Server  # noqa: E402
import gxy.client  # noqa: E402

PARTS = ["publishes", "copies", "carries", "overhead", "transfers", "latencies"]
TICKS = os.sysconf("SC_CLK_TCK")
ENVIRONMENT = {name: value for name, value in os.environ.items() if not name.startswith("GALAXY_INSITU")}
ENVIRONMENT.update(OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")


class Failure(Exception):
    pass


def check(holds, what):
    if not holds:
        raise Failure(what)


def table(headings, rows):
    print("| " + " | ".join(headings) + " |\n|" + "---|" * len(headings))
    for row in rows:
        print("| " + " | ".join(row) + " |")
    print(flush=True)


class Serving:
    """A server on some ranks, and a client of it."""

    def __init__(self, arguments, ranks):
        self._server = Server(arguments.programs, arguments.mpiexec.split(), ranks)
        self.to = [f"127.0.0.1:{self._server.port}", str(self._server.token)]
        self.events = []
        self.client = self.connect(self._event)
        self.client.request("load insitu")

    def connect(self, on_event=None):
        client = gxy.client.Client(port=self._server.port, token_file=self._server.token, on_event=on_event)
        client.request("load data")
        return client

    def _event(self, event):
        self.events.append((time.monotonic(), event))

    def processor_seconds(self):
        """Of all ranks so far."""
        ticks = 0
        for stat in pathlib.Path("/proc").glob("[0-9]*/stat"):
            try:
                name, rest = stat.read_text().rsplit(")", 1)
            except OSError:
                continue
            fields = rest.split()
            if name.endswith("(gxyserver") and int(fields[1]) == self._server._process.pid:
                ticks += int(fields[11]) + int(fields[12])
        return ticks / TICKS

    def stream(self, name):
        for stream in self.client.request("insitu.streams")["streams"]:
            if stream["name"] == name:
                return stream
        raise Failure(f"there is no stream {name}")

    def await_end(self, name):
        end = time.monotonic() + 30
        while any(s["name"] == name for s in self.client.request("insitu.streams")["streams"]):
            check(time.monotonic() < end, f"stream {name} does not end")
            time.sleep(0.01)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        try:
            self.client.request("quit")
            self.client.close()
        except gxy.client.GalaxyError:
            pass
        self._server.stop()


class Bench:
    def __init__(self, arguments):
        self._arguments, self._program = arguments, arguments.programs / "insitu_benchmark"
        self.numbers = {}

    def part(self, *words):
        done = subprocess.run([self._program, *map(str, words)], env=ENVIRONMENT, capture_output=True, text=True, timeout=300)
        check(done.returncode == 0, done.stderr)
        return json.loads(done.stdout)

    # Steps that are not taken.
    def publishes(self, serving):
        calls = self._arguments.calls
        found = {"off": self.part("publish", "", "", calls), "connected": self.part("publish", *serving.to, calls)}
        rows = []
        for name, f in found.items():
            check(f["other results"] == 0 and f["bytes on the wire"] == 0 and not f["calls with system calls"],
                  f"gxy_publish, {name}: it is not silent: {f}")
            rows.append([name] + [f"{f[n]:.3f}" for n in ("median us", "99.9 % us", "longest us", "clock us")] +
                        [str(f[n]) for n in ("bytes on the wire", "calls with system calls", "waits", "waits of all threads")])
        self.numbers["publish"] = found
        print(f"gxy_publish() that is not taken, {calls} calls")
        table(["", "median, us", "99.9 %, us", "longest, us", "two clock readings, us", "bytes on the wire",
               "calls with system calls", "waits of the thread", "of all threads"], rows)

    # Copies.
    def copies(self):
        turns = [self.part("copy", *self._arguments.block, 5) for _ in range(self._arguments.repeats)]
        self.numbers["copy"] = turns
        rows = []
        for layout in turns[0]:
            rate, plain = (max(turn[layout][n] for turn in turns) for n in ("GB/s", "memcpy GB/s"))
            rows.append([layout, f"{rate:.2f}", f"{plain:.2f}", f"{100 * rate / plain:.0f} %"])
        print("copies of", "x".join(map(str, self._arguments.block)), "values")
        table(["layout", "GB/s", "memcpy, GB/s", "of it"], rows)

    # From a slot into another process.
    def carries(self):
        size = 4
        for n in self._arguments.block:
            size *= n
        turns = [self.part("carry", size, 4 if self._arguments.quick else 32) for _ in range(self._arguments.repeats)]
        self.numbers["carry"] = turns
        print(f"a slot of {size} bytes, filled and read by another process, CPU s/GB of both")
        table(list(turns[0]), [[f"{turn[way]:.3f}" for way in turn] for turn in turns])

    # Whole steps.
    def steps(self, serving, side, ranks, steps, pause=0.0):
        """What ranks of a simulation, the server's processors, and the stream say of `steps` steps."""
        warm = 2
        processes = [subprocess.Popen([self._program, "rank", *serving.to, *map(str, (rank, ranks, side, warm, steps, pause))],
                                      env=ENVIRONMENT, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
                     for rank in range(ranks)]
        try:
            for p in processes:
                check(p.stdout.readline() == "ready\n", "a rank of the simulation has failed")
            before, seconds = serving.stream("bench"), serving.processor_seconds()
            for p in processes:
                print("go", file=p.stdin, flush=True)
            answers = [p.stdout.readline() for p in processes]
            check(all(answers), "a rank of the simulation has failed")
            found = [json.loads(answer) for answer in answers]
            seconds = serving.processor_seconds() - seconds
            after = serving.stream("bench")
        finally:
            for p in processes:
                p.stdin.close()
            for p in processes:
                p.wait(30)
        serving.await_end("bench")
        check(after["published"] - before["published"] == steps, f"of {steps} steps, some are left out: {after}")
        gigabytes = 4e-9 * side**3 * steps
        stages = {name: (s - before["seconds"][name]) / steps for name, s in after["seconds"].items()}
        return {"MB/s": 1e3 * gigabytes / (max(f["end"] for f in found) - min(f["begin"] for f in found)),
                "transfer MB/s": 1e3 * gigabytes / steps / stages["collect"],
                "simulation CPU s/GB": sum(f["processor seconds"] for f in found) / gigabytes,
                "server CPU s/GB": seconds / gigabytes, "stages": stages, "begins": [f["begins"] for f in found]}

    def transfers(self, servings):
        a = self._arguments
        rows, all_found = [], []
        for side in a.sizes:
            count = max(3, min(200, round(a.gigabytes / (4e-9 * side**3))))
            for ranks in a.ranks:
                for n, serving in servings.items():
                    raw, ours = [], []
                    for _ in range(a.repeats):
                        raw.append(self.part("raw", ranks, n, 4 * side**3 // ranks, count))
                        ours.append(self.steps(serving, side, ranks, count))
                    all_found.append({"side": side, "simulation ranks": ranks, "server ranks": n, "steps": count,
                                      "raw TCP": raw, "galaxy": ours})
                    best, plain = max(ours, key=lambda f: f["transfer MB/s"]), max(raw, key=lambda f: f["MB/s"])
                    least = {name: min(o["stages"][name] for o in ours) for name in best["stages"]}
                    rows.append([f"{side}^3, {ranks} to {n}", f"{max(o['MB/s'] for o in ours):.0f}", f"{best['transfer MB/s']:.0f}",
                                 f"{plain['MB/s']:.0f}", f"{100 * best['transfer MB/s'] / plain['MB/s']:.0f} %"] +
                                [f"{min(o[end + ' CPU s/GB'] for o in ours):.2f}" for end in ("simulation", "server")] +
                                [f"{min(r['sender CPU s/GB'] for r in raw):.2f} + {min(r['receiver CPU s/GB'] for r in raw):.2f}"] +
                                [f"{1e3 * least[name]:.1f}" for name in ("reserve", "collect", "complete")])
        self.numbers["transfer"] = all_found
        print("steps of float32, all of them taken; CPU s/GB with everything that a step takes")
        table(["size, ranks", "whole steps, MB/s", "first to last byte, MB/s", "plain TCP, MB/s", "of it", "CPU s/GB: simulation", "server",
               "plain TCP", "ms a step: reserve", "collect", "complete"], rows)

    # From a publish to the event.
    def latencies(self, serving, n):
        a = self._arguments
        serving.client.request("observe bench.f")
        rows, all_found = [], []
        for side in a.sizes:
            for ranks in a.ranks:
                serving.events.clear()
                found = self.steps(serving, side, ranks, a.latencies, pause=0.05)
                seen = {event["step"]: at for at, event in serving.events if event.get("name") == "bench.f"}
                begins = [max(of_step) for of_step in zip(*found["begins"])]
                late = [1e3 * (seen[3 + i] - begin) for i, begin in enumerate(begins)]
                all_found.append({"side": side, "simulation ranks": ranks, "server ranks": n, "ms": late})
                rows.append([f"{side}^3, {ranks} to {n}", f"{min(late):.1f}", f"{statistics.median(late):.1f}", f"{max(late):.1f}"])
        self.numbers["latency"] = all_found
        print(f"from the last rank's publish to `updated` at a client, ms, {a.latencies} steps")
        table(["size, ranks", "least", "median", "most"], rows)

    # What a simulation loses.
    def overhead(self, serving):
        a = self._arguments
        rows, all_found = [], []
        with tempfile.TemporaryDirectory(prefix="galaxy-bench-") as folder:
            options = pathlib.Path(folder) / "options.json"
            options.write_text(json.dumps({"token-file": serving.to[1], "reconnect": 0.2}))

            def seconds(ranks, how, name):
                """Processor seconds of the simulation's processes and seconds by the clock, its results, and the steps that were taken."""
                output = pathlib.Path(folder) / "result.npy"
                environment = {**ENVIRONMENT, "GALAXY_INSITU": "off" if how == "off" else serving.to[0],
                               "GALAXY_INSITU_OPTIONS": str(options)}
                launcher = [*a.mpiexec.split(), "-n", str(ranks)] if ranks > 1 else []
                began = time.monotonic()
                process = subprocess.Popen([*launcher, a.programs / "gxysim", "blobs", "--size", str(a.blobs_side), "--steps",
                                            str(a.blobs_steps), "--name", name, "--last", "0", "--output", output],
                                           env=environment, stdout=subprocess.DEVNULL)
                _, status, usage = os.wait4(process.pid, 0)
                process.returncode = os.waitstatus_to_exitcode(status)
                check(process.returncode == 0, "gxysim has failed")
                found = usage.ru_utime + usage.ru_stime, time.monotonic() - began, output.read_bytes()
                taken = sum(1 for _, event in list(serving.events) if event.get("name") == f"{name}.density")
                return found + (taken,)

            for ranks in a.blobs_ranks:
                times, expected, taken = {}, None, 0
                for turn in range(a.repeats):
                    for how in ("off", "skipping", "observed"):
                        name = f"{how}{ranks}x{turn}"
                        if how == "observed":
                            serving.client.request(f"observe {name}.density")
                        processor, wall, result, steps = seconds(ranks, how, name)
                        check(result == (expected or result), "the simulation's results differ")
                        expected = result
                        times.setdefault(how, []).append((processor, wall))
                        taken += steps if how == "observed" else 0
                all_found.append({"ranks": ranks, "side": a.blobs_side, "steps": a.blobs_steps, "seconds": times, "taken": taken / a.repeats})
                least = {how: [min(t[i] for t in all_times) for i in (0, 1)] for how, all_times in times.items()}
                off = least["off"]
                rows.append([f"{a.blobs_side}^3", str(ranks), f"{1e3 * off[1] / a.blobs_steps:.0f}", f"{off[0]:.2f}"] +
                            [f"{least[how][0]:.2f} ({100 * (least[how][0] / off[0] - 1):+.1f} %)" for how in ("skipping", "observed")] +
                            [f"{100 * (least['observed'][1] / off[1] - 1):+.1f} %", f"{taken / a.repeats:.0f} of {a.blobs_steps}"])
        self.numbers["overhead"] = all_found
        print("gxysim blobs: processor seconds of its processes; its results are the same to the bit")
        table(["cells", "ranks", "ms a step", "off", "connected, nobody looks", "a client observes", "by the clock", "steps taken"], rows)

    def run(self):
        a = self._arguments
        self.numbers["load"] = os.getloadavg()
        with Serving(a, max(a.servers)) as serving:
            if "publishes" in a.parts:
                self.publishes(serving)
            if "copies" in a.parts:
                self.copies()
            if "carries" in a.parts:
                self.carries()
            if "overhead" in a.parts:
                self.overhead(serving)
            if "transfers" in a.parts:
                servings = {n: serving if n == max(a.servers) else Serving(a, n) for n in a.servers}
                try:
                    self.transfers(servings)
                finally:
                    for other in servings.values():
                        if other is not serving:
                            other.__exit__()
            if "latencies" in a.parts:
                self.latencies(serving, max(a.servers))
        print("load before and after:", *(f"{load:.1f}" for load in (self.numbers["load"][0], os.getloadavg()[0])))
        if a.json:
            a.json.write_text(json.dumps(self.numbers, indent=1))


def numbers(text):
    return [int(n) for n in text.split(",")]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("programs", type=pathlib.Path, help="the folder of gxyserver, gxysim and insitu_benchmark")
    parser.add_argument("--quick", action="store_true", help="tiny data, seconds")
    parser.add_argument("--parts", type=lambda text: text.split(","), default=PARTS, help="of " + ",".join(PARTS))
    parser.add_argument("--sizes", type=numbers, default=[64, 128, 256], help="points along an axis")
    parser.add_argument("--ranks", type=numbers, default=[1, 4], help="of the simulation")
    parser.add_argument("--servers", type=numbers, default=[1, 2], help="ranks of the server")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--json", type=pathlib.Path, help="a file for all numbers")
    parser.add_argument("--mpiexec", default="mpirun --bind-to none --oversubscribe")
    arguments = parser.parse_args()
    arguments.programs = arguments.programs.resolve()
    arguments.calls, arguments.block, arguments.gigabytes, arguments.latencies = 200000, (256, 256, 128), 1.0, 20
    arguments.blobs_side, arguments.blobs_steps, arguments.blobs_ranks = 128, 40, [1, 2]
    if arguments.quick:
        arguments.calls, arguments.block, arguments.gigabytes, arguments.latencies = 1000, (16, 16, 16), 0, 3
        arguments.sizes, arguments.ranks, arguments.servers, arguments.repeats = [16], [2], [2], 1
        arguments.blobs_side, arguments.blobs_steps, arguments.blobs_ranks = 16, 3, [1]
    try:
        Bench(arguments).run()
    except (Failure, gxy.client.GalaxyError) as e:
        sys.exit(f"insitu_bench.py: error: {e}")


if __name__ == "__main__":
    sys.exit(main())

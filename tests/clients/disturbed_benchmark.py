#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""disturbed_benchmark.py PROGRAMS: what a client's frames lose to others that die, talk nonsense, fall silent or read slowly.

One client renders a window of 640 x 360 again and again, on a server of one rank and one thread. In turns of some seconds it is
alone, or beside 20 clients a second that ask for a frame and are cut off somewhere in it, 20 a second that send random bytes, 50 that
connect and say nothing, and 4 that read their picture at 10 kB/s. Prints frames per second of each turn and the median of
their ratios; pictures must be those of the first turn to the bit, else it fails. The others run in a process of their own: on
less than two free cores their own work is measured, too.
"""
import argparse
import hashlib
import json
import multiprocessing
import pathlib
import random
import socket
import statistics
import struct
import sys
import threading
import time

from server import STATE, Server

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "python" / "src"))
import gxy.client  # noqa: E402

CAMERAS = [{**STATE["Camera"], "viewpoint": [3 - 0.5 * i, 2, 4]} for i in range(8)]
RESET = struct.pack("ii", 1, 0)  # closing cuts off: no farewell


def cut_off(port, token, seed):
    chance = random.Random(seed)
    client = gxy.client.Client(port=port, token_file=token, name="dies")
    client._socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, RESET)
    window = client.window(1, size=[64, 36])
    window.set(STATE)
    client.send('viewer.render 1 {"encoding": "zlib"}')
    time.sleep(chance.uniform(0, 0.02))
    client.close()


def nonsense(port, seed):
    with socket.create_connection(("127.0.0.1", port)) as s:
        s.sendall(random.Random(seed).randbytes(1000))


def slow(port, token, over):
    """Takes 1000 bytes ten times a second of what it asked for."""
    client = gxy.client.Client(port=port, token_file=token, name="slow")
    read = client._read

    def slowly(size):
        data = bytearray()
        while len(data) < size:
            if over.is_set():
                raise gxy.client.GalaxyError("read enough")
            data += read(min(1000, size - len(data)))
            time.sleep(0.1 if size > 1000 else 0)
        return data

    client._read = slowly
    window = client.window(1, size=[640, 360])
    window.set(STATE)
    client.send('viewer.render 1 {"encoding": "zlib"}')
    over.wait()
    client.close()


def disturb(port, token, ready, over, counted):
    """Until `over`: all of them; counts those that were cut off or sent nonsense."""
    def again_and_again(deed):
        seed = 0
        while not over.wait(0.05):
            seed += 1
            try:
                deed(seed)
                with counted.get_lock():
                    counted.value += 1
            except (OSError, gxy.client.GalaxyError):
                pass  # that is what they are for

    silent = [socket.create_connection(("127.0.0.1", port)) for _ in range(50)]
    deeds = [threading.Thread(target=slow, args=(port, token, over)) for _ in range(4)]
    deeds.append(threading.Thread(target=again_and_again, args=(lambda seed: cut_off(port, token, seed),)))
    deeds.append(threading.Thread(target=again_and_again, args=(lambda seed: nonsense(port, seed),)))
    for deed in deeds:
        deed.start()
    ready.set()
    for deed in deeds:
        deed.join()
    for s in silent:
        s.close()


def frames_per_second(window, seconds, sums):
    begin, frames = time.monotonic(), 0
    while time.monotonic() - begin < seconds:
        i = frames % len(CAMERAS)
        window.set({"Camera": CAMERAS[i]})
        digest = hashlib.sha256(window.render(levels=[1]).rgba).hexdigest()
        if sums.setdefault(i, digest) != digest:
            sys.exit("disturbed_benchmark.py: error: a picture is not that of the first turn")
        frames += 1
    return frames / (time.monotonic() - begin)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("programs", type=pathlib.Path, help="the folder of gxyserver and gxydata")
    parser.add_argument("--seconds", type=float, default=5, help="of a turn")
    parser.add_argument("--turns", type=int, default=8, help="alone and beside the others, each")
    parser.add_argument("--mpiexec", default="mpirun --bind-to none --oversubscribe")
    arguments = parser.parse_args()
    server = Server(arguments.programs, arguments.mpiexec.split(), 1, ["--threads", "1"])
    counted, sums, ratios = multiprocessing.Value("i"), {}, []
    try:
        with gxy.client.Client(port=server.port, token_file=server.token) as client:
            client.request("load data")
            client.request("import " + json.dumps({"Datasets": STATE["Datasets"]}))
            window = client.window(1, size=[640, 360])
            window.set(STATE)
            frames_per_second(window, 1, sums)  # all is warm then
            print("| alone | beside the others | ratio |\n|---|---|---|")
            for _ in range(arguments.turns):
                alone = frames_per_second(window, arguments.seconds, sums)
                ready, over = multiprocessing.Event(), multiprocessing.Event()
                others = multiprocessing.Process(target=disturb, args=(server.port, server.token, ready, over, counted))
                others.start()
                ready.wait()
                time.sleep(1)
                beside = frames_per_second(window, arguments.seconds, sums)
                over.set()
                others.join()
                ratios.append(beside / alone)
                print(f"| {alone:.2f} | {beside:.2f} | {ratios[-1]:.3f} |", flush=True)
    finally:
        server.stop()
    print(f"\nmedian {statistics.median(ratios):.3f}; {counted.value} others were cut off or talked nonsense")


if __name__ == "__main__":
    sys.exit(main())

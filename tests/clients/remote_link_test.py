# SPDX-License-Identifier: Apache-2.0
"""remote_link_test.py PROGRAMS MPIEXEC...: windows over slow links get fewer pixels, the server keeps no more, and a picture
at rest is the whole one. Counters and bits are asserted; how fast it is, remote_benchmark.py says."""
import copy
import json
import pathlib
import subprocess
import sys
import threading
import unittest

import numpy as np

from link import Link
from server import STATE, Server

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "python" / "src"))
import gxy.client  # noqa: E402

PROGRAMS, MPIEXEC = pathlib.Path(sys.argv[1]).resolve(), sys.argv[2:]
WIDTH, HEIGHT = 640, 480
PICTURE = WIDTH * HEIGHT * 4  # bytes


def setUpModule():
    global server, administrator
    server = Server(PROGRAMS, MPIEXEC)
    administrator = gxy.client.Client(port=server.port, token_file=server.token)


def tearDownModule():
    administrator.close()
    server.stop()


def link(bits_per_second, case):
    made = Link(server.port, bits_per_second, 0.02)
    case.addCleanup(made.stop)
    return made


def counters(name):
    """Those of the client of this name; {} when there is none."""
    clients = administrator.request("stat")["clients"]
    return next((client for client in clients if client["client"] == name), {})


def cameras(count):
    for i in range(count):
        yield {**STATE["Camera"], "viewpoint": [3 - 0.1 * i, 2, 4]}


class SlowLink(unittest.TestCase):
    def test_the_viewer_asks_for_what_the_link_carries_and_at_rest_for_all(self):
        rate, passes = 2e6, 3
        state = copy.deepcopy(STATE)
        state["Renderer"]["rays per pixel"] = passes
        state["Camera"]["dimensions"] = [WIDTH, HEIGHT]
        (server.folder / "scene.json").write_text(json.dumps(state))
        slow = link(rate, self)
        viewer = subprocess.Popen(
            [PROGRAMS / "viewer_benchmark", "scene.json", "-P", str(slow.port), "--token-file", server.token, "--width",
             str(WIDTH), "--height", str(HEIGHT), "--seconds", "3", "--changes", "1", "--passes", str(passes),
             "--picture", "rest.png"], cwd=server.folder, stdout=subprocess.PIPE, text=True)
        most, ended = 0, threading.Event()

        def watch():
            nonlocal most
            while not ended.wait(0.1):
                most = max(most, counters("viewer_benchmark").get("most queued bytes", 0))

        watcher = threading.Thread(target=watch)
        watcher.start()
        measured = json.loads(viewer.communicate(timeout=200)[0])
        ended.set()
        watcher.join()
        self.assertEqual(viewer.returncode, 0)
        self.assertGreater(measured["frames"], 3, "it goes on while the camera moves")
        self.assertLess(measured["bytes per frame"], 2 * 0.06 * rate / 8, "a frame is what the link carries in its time")
        self.assertLess(most, 2 * PICTURE, "a pass of each level at most waits in the server")
        subprocess.run([PROGRAMS / "gxyrender", "scene.json", "-o", "whole"], cwd=server.folder, check=True,
                       stdout=subprocess.DEVNULL)
        subprocess.run([PROGRAMS / "gxydiff", "--alpha", "rest.png", "whole_00000.png"], cwd=server.folder, check=True)

    def test_a_reader_that_is_flooded_gets_the_newest_picture_and_the_server_keeps_one(self):
        wanted = list(cameras(40))
        for wait in (False, True):
            with self.subTest(wait=wait):
                slow = link(4e6, self)
                with gxy.client.Client(port=slow.port, token_file=server.token, name="flooded") as client:
                    window = client.window(1, size=(WIDTH, HEIGHT))
                    window.set({name: value for name, value in STATE.items() if name != "Camera"})
                    frames = [window.start(Camera=camera, levels=[4, 1], wait=wait) for camera in wanted]
                    last = window.wait(frames[-1])
                    seen = counters("flooded")
                    ends = {number: picture.end["status"] for number, picture in window._ends.items()}
                    self.assertEqual(sorted(ends), frames, "each frame ends once")
                    self.assertEqual(ends[frames[-1]], "complete")
                    self.assertLess(seen["most queued bytes"], 2 * PICTURE)
                    if not wait:  # else each comes when the machine has answered the one before, and may be whole by then
                        self.assertGreater(sum(status == "superseded" for status in ends.values()), len(frames) // 2)
                        self.assertLess(slow.bytes, len(frames) * PICTURE // 8, "most pixels were never sent")
                with gxy.client.Client(port=server.port, token_file=server.token) as client:
                    window = client.window(1, size=(WIDTH, HEIGHT))
                    window.set({name: value for name, value in STATE.items() if name != "Camera"})
                    expected = window.render(Camera=wanted[-1], levels=[1])
                self.assertTrue(np.array_equal(last.rgba, expected.rgba), "to the bit what a fast reader gets")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)

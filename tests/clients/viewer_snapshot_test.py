# SPDX-License-Identifier: Apache-2.0
"""viewer_snapshot_test.py PROGRAMS MPIEXEC...: gxyviewer without a display: pictures, and what it says of errors."""
import copy
import json
import os
import pathlib
import socket
import subprocess
import sys
import unittest

from server import STATE, Server

PROGRAMS, MPIEXEC = pathlib.Path(sys.argv[1]).resolve(), sys.argv[2:]


def setUpModule():
    global server
    server = Server(PROGRAMS, MPIEXEC)
    (server.folder / "scene.json").write_text(json.dumps(STATE))


def tearDownModule():
    server.stop()


def without_display():
    return {name: value for name, value in os.environ.items() if name != "DISPLAY"}


class Snapshot(unittest.TestCase):
    def view(self, *arguments, port=None, token=None, **environment):
        return subprocess.run([PROGRAMS / "gxyviewer", "-P", str(port or server.port), "--token-file",
                               token or server.token, *arguments], cwd=server.folder, capture_output=True, text=True,
                              timeout=120, env={**without_display(), **environment})

    def fails(self, done, *words, status=1):
        self.assertEqual(done.returncode, status, done.stderr)
        for word in words:
            self.assertIn(word, done.stderr)

    def test_it_is_the_picture_that_gxyrender_writes_to_the_bit(self):
        done = self.view("--snapshot", "snapshot.png", "scene.json")
        self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "", ""))
        subprocess.run([PROGRAMS / "gxyrender", "scene.json", "-o", "batch"], cwd=server.folder, check=True,
                       stdout=subprocess.DEVNULL)
        subprocess.run([PROGRAMS / "gxydiff", "--alpha", "snapshot.png", "batch_00000.png"], cwd=server.folder, check=True)

    def test_it_has_the_annotations_that_the_state_asks_for(self):
        state = copy.deepcopy(STATE)
        state["Annotations"] = {"legend": True, "axes": True, "outline": True, "text": "as gxyrender draws it"}
        (server.folder / "annotated.json").write_text(json.dumps(state))
        self.assertEqual(self.view("--snapshot", "annotated.png", "annotated.json").returncode, 0)
        subprocess.run([PROGRAMS / "gxyrender", "annotated.json", "-o", "annotated"], cwd=server.folder, check=True,
                       stdout=subprocess.DEVNULL)
        equal = [PROGRAMS / "gxydiff", "annotated.png", "annotated_00000.png", "--max", "0.012"]
        subprocess.run(equal, cwd=server.folder, check=True)  # blended in 8 bits, so three levels
        equal[2] = "batch_00000.png"
        subprocess.run([PROGRAMS / "gxyrender", "scene.json", "-o", "batch"], cwd=server.folder, check=True,
                       stdout=subprocess.DEVNULL)
        self.assertEqual(subprocess.run(equal, cwd=server.folder, stdout=subprocess.DEVNULL).returncode, 1)

    def test_size_and_passes_are_options(self):
        done = self.view("--snapshot", "small.png", "--size", "64x48", "--passes", "3", "scene.json")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        png = (server.folder / "small.png").read_bytes()
        self.assertEqual((int.from_bytes(png[16:20], "big"), int.from_bytes(png[20:24], "big")), (64, 48))

    def test_a_window_that_the_server_would_refuse_is_refused_before_it_takes_memory(self):
        self.fails(self.view("--snapshot", "x.png", "--size", "99999x99999", "scene.json"),
                   "99999 x 99999: expected at most 33177600 pixels")

    def test_no_server_is_said(self):
        with socket.socket() as taken:  # bound and not listening: nobody answers there
            taken.bind(("127.0.0.1", 0))
            done = self.view("--snapshot", "x.png", "scene.json", port=taken.getsockname()[1])
        self.fails(done, "cannot connect", "is a server running there?")

    def test_a_wrong_token_is_said(self):
        (server.folder / "wrong").write_text("0" * 64 + "\n")
        self.fails(self.view("--snapshot", "x.png", "scene.json", token="wrong"), "token")

    def test_a_wrong_state_file_is_said_with_its_place(self):
        (server.folder / "wrong.json").write_text('{\n "Camera": 3\n}')
        self.fails(self.view("--snapshot", "x.png", "wrong.json"), "wrong.json:2:12", "camera")
        (server.folder / "empty.json").write_text("{}")
        self.fails(self.view("--snapshot", "x.png", "empty.json"), "empty.json", "Visualization")
        self.fails(self.view("--snapshot", "x.png", "nosuch.json"), "nosuch.json")

    def test_data_that_are_not_there_are_named(self):
        state = copy.deepcopy(STATE)
        state["Datasets"][0].update(name="lost", filename="lost.vti")
        state["Visualization"]["operators"][0]["dataset"] = "lost"
        (server.folder / "lost.json").write_text(json.dumps(state))
        self.fails(self.view("--snapshot", "x.png", "lost.json"), "lost.vti")
        self.assertFalse((server.folder / "x.png").exists())

    def test_a_picture_that_cannot_be_written_is_named(self):
        self.fails(self.view("--snapshot", "nowhere/x.png", "scene.json"), "nowhere/x.png")

    def test_without_a_display_there_is_a_message_and_no_crash(self):
        self.fails(self.view("scene.json"), "DISPLAY is not set", "--snapshot")
        self.fails(self.view("scene.json", DISPLAY="127.0.0.1:9999"), "no display at 127.0.0.1:9999", "--snapshot")

    def test_wrong_usage_has_status_2_and_help_0(self):
        self.fails(self.view(), "file is required", status=2)
        for size in ("3", "0x100", "100x0", "100x-5", "64x48x", "wide"):
            self.fails(self.view("--size", size, "scene.json"), "WIDTHxHEIGHT", status=2)
        self.fails(self.view("--snapshot", "x.jpg", "scene.json"), "ends with .png", "x.jpg", status=2)
        done = self.view("--help")
        self.assertEqual(done.returncode, 0)
        self.assertIn("--snapshot", done.stdout)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)

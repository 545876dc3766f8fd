# SPDX-License-Identifier: Apache-2.0
"""python_client_test.py PROGRAMS MPIEXEC...: the client in tools/python and a real server on two ranks."""
import copy
import json
import pathlib
import queue
import socket
import struct
import subprocess
import sys
import threading
import time
import unittest

import numpy as np

from server import STATE, Server

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tools" / "python"))
import galaxy  # noqa: E402

PROGRAMS, MPIEXEC = pathlib.Path(sys.argv[1]).resolve(), sys.argv[2:]


def setUpModule():
    global server
    server = Server(PROGRAMS, MPIEXEC)


def tearDownModule():
    try:
        with connect() as client:
            client.request("quit")
    finally:
        status = server.stop()
    assert status == 0, f"the server ended with status {status} after quit"


def connect(**options):
    return galaxy.Client(port=server.port, token_file=server.token, **options)


class Bytes(unittest.TestCase):
    """What the server does with bytes that no client should send; sent by hand."""

    PREAMBLE = b"GALAXY\r\n" + struct.pack("<II", 1, 0)

    def answer(self, *parts):
        """All that the server sends until it closes."""
        with socket.create_connection(("127.0.0.1", server.port), timeout=20) as connection:
            connection.sendall(b"".join(parts))
            received = b""
            while more := connection.recv(65536):
                received += more
        return received

    @staticmethod
    def frame(channel, number, payload):
        return struct.pack("<QHHI", len(payload), channel, 0, number) + payload

    def hello(self):
        return self.frame(0, 0, b"hello " + json.dumps({"token": server.token.read_text().strip(),
                                                        "client": "bytes"}).encode())

    def test_another_magic_is_hung_up_on_without_a_word(self):
        self.assertEqual(b"", self.answer(b"galaxy\r\n" + struct.pack("<II", 1, 0)))

    def test_another_version_is_told_so(self):
        self.assertIn(b"bye ", self.answer(b"GALAXY\r\n" + struct.pack("<II", 2, 0)))

    def test_a_frame_before_hello_is_a_violation(self):
        received = self.answer(self.PREAMBLE, self.frame(1, 1, b"help"))
        self.assertIn(b"bye ", received)
        self.assertNotIn(b"welcome", received)

    def test_channels_of_the_server_are_closed_to_clients(self):
        for channel in (2, 3, 4, 5, 6, 65535):
            self.assertIn(b"bye ", self.answer(self.PREAMBLE, self.hello(), self.frame(channel, 1, b"{}")), channel)

    def test_request_0_is_a_violation(self):
        self.assertIn(b"bye ", self.answer(self.PREAMBLE, self.hello(), self.frame(1, 0, b"help")))

    def test_an_id_may_not_be_used_twice_at_a_time(self):
        wait = self.frame(1, 7, b"data.wait nothing 1 30")
        self.assertIn(b"bye ", self.answer(self.PREAMBLE, self.hello(), self.frame(1, 6, b"load data"), wait, wait))

    def test_a_length_beyond_the_limit_is_a_violation_before_its_bytes_come(self):
        self.assertIn(b"bye ", self.answer(self.PREAMBLE, self.hello(), struct.pack("<QHHI", 1 << 40, 1, 0, 1)))

    def test_pings_of_the_client_are_answered(self):
        received = self.answer(self.PREAMBLE, self.hello(), self.frame(0, 0, b"ping 12345678901234567890"),
                               self.frame(6, 0, b""))
        self.assertIn(b"pong 12345678901234567890", received)


class Session(unittest.TestCase):
    def test_the_welcome_has_all_that_the_page_promises(self):
        with connect() as client:
            self.assertEqual(client.welcome["ranks"], 2)
            self.assertIs(client.welcome["administrator"], True)
            self.assertEqual(set(client.welcome["limits"]), {"request bytes", "requests", "windows", "pixels", "clients"})
            self.assertLessEqual({"server", "session", "tenant"}, set(client.welcome))

    def test_a_wrong_token_is_refused(self):
        with self.assertRaisesRegex(galaxy.GalaxyError, "token"):
            galaxy.Client(port=server.port, token="0" * 64)

    def test_no_token_file_is_an_error_that_names_it(self):
        with self.assertRaisesRegex(galaxy.GalaxyError, "/nowhere/token.*is a server running"):
            galaxy.Client(port=server.port, token_file="/nowhere/token")

    def test_another_machine_is_sent_no_token_by_itself(self):
        for host in ("192.0.2.1", "2001:db8::1", "0.0.0.0"):
            with self.assertRaisesRegex(galaxy.GalaxyError, f"host {host} is another machine.*clear text"):
                galaxy.Client(host, server.port)

    def test_this_machine_is_sent_none_where_there_is_none(self):
        for host in ("127.0.0.1", "localhost"):
            with self.assertRaisesRegex(galaxy.GalaxyError, f"token is wrong.*none was sent: .*{server.port}.token"):
                galaxy.Client(host, server.port)

    def test_no_server_is_an_error_that_says_so(self):
        with socket.socket() as taken:  # bound and not listening: nobody answers there
            taken.bind(("127.0.0.1", 0))
            with self.assertRaisesRegex(galaxy.GalaxyError, "is a server running there"):
                galaxy.Client(port=taken.getsockname()[1], token="")

    def test_errors_are_raised_and_the_connection_goes_on(self):
        with connect() as client:
            with self.assertRaisesRegex(galaxy.GalaxyError, "nosuchverb"):
                client.request("nosuchverb")
            with self.assertRaises(galaxy.GalaxyError):
                client.request("load ../../etc/passwd")
            self.assertEqual(client.request('echo "a b";')["text"].strip('"'), "a b")

    def test_requests_may_overtake_what_is_long_and_cancel_it(self):
        with connect() as client:
            client.request("load data")
            number, waiting = client.send("wait nothing 1 60")
            client.request("list")
            self.assertFalse(waiting.done())
            client.request(f"cancel {number}")
            with self.assertRaisesRegex(galaxy.GalaxyError, "cancelled"):
                waiting.result(20)

    def test_every_verb_of_help_has_the_members_of_the_page(self):
        with connect() as client:
            for module in ("data", "viewer"):
                client.request(f"load {module}")
            verbs = client.request("help")["verbs"]
            for verb in verbs:
                self.assertEqual(set(verb), {"verb", "arguments", "help"})
            page = (pathlib.Path(__file__).resolve().parents[2] / "docs" / "protocol.md").read_text()
            for verb in verbs:
                self.assertIn(f"| `{verb['verb'].split('.')[-1]}", page)
            self.assertEqual(client.request("modules")["loaded"], ["data", "viewer"])

    def test_stat_has_the_members_of_the_page(self):
        with connect(name="counter") as client:
            stat = client.request("stat")
        self.assertEqual([rank["rank"] for rank in stat["ranks"]], [0, 1])
        for rank in stat["ranks"]:
            self.assertLessEqual({"memory", "rays", "frames", "messages", "bytes", "packets"}, set(rank))
            self.assertLessEqual({"ledger", "peak", "resident", "limit", "by purpose"}, set(rank["memory"]))
            self.assertLessEqual({"traced", "forwarded", "retired", "in flight"}, set(rank["rays"]))
        mine = [c for c in stat["clients"] if c["client"] == "counter"]
        self.assertEqual(len(mine), 1)
        self.assertLessEqual({"session", "tenant", "queued bytes", "sent bytes", "received bytes", "tiles sent",
                              "tiles dropped", "requests"}, set(mine[0]))
        self.assertIn("seconds", stat)


class Data(unittest.TestCase):
    def test_what_is_imported_can_be_asked_for_and_is_told_of(self):
        events = queue.Queue()
        with connect(on_event=events.put) as client:
            client.request("load data")
            client.request("observe")
            reply = client.request('import {"Datasets": [{"name": "mine", "type": "Volume", '
                                   '"filename": "balls.vti", "array": "oneBall"}]}')
            self.assertEqual(reply["datasets"], ["mine"])
            info = client.request("info mine")["datasets"][0]
            self.assertEqual(info["points"], [24, 24, 24])
            self.assertEqual((info["type"], info["scope"], info["generation"]), ("Volume", "private", 1))
            np.testing.assert_allclose(info["box"], [[-1, -1, -1], [1, 1, 1]], atol=1e-6)
            np.testing.assert_allclose(client.request("range mine")["range"], info["range"])
            client.request("publish mine")
            client.request("rename mine yours")
            client.request("drop yours")
            told = []
            while not told or told[-1] != ("dropped", "yours", "shared"):
                event = events.get(timeout=20)
                if event.get("name") in ("mine", "yours"):
                    told.append((event["event"], event["name"], event["scope"]))
            self.assertEqual(told[0], ("added", "mine", "private"))
            self.assertIn(("renamed", "mine", "shared"), told)

    def test_arrays_of_datasets_are_fetched(self):
        with connect() as client:
            client.request("load data")
            client.request('import {"Datasets": [{"name": "balls", "type": "Volume", "filename": "balls.vti", "array": "oneBall"}]}')
            volume = client.fetch("balls")
            (name, values), = volume["fields"].items()
            self.assertEqual((name, values.shape, volume["dimensions"]), ("oneBall", (24, 24, 24), [24, 24, 24]))
            known = client.request("range balls")["range"]
            np.testing.assert_allclose([values.min(), values.max()], known, rtol=1e-6)
            client.request("load analysis")
            client.request('make {"name": "seeds", "filter": "Seeds", "inputs": {"domain": "balls"}, "dimensions": [2, 3, 4]}')
            seeds = client.fetch("seeds")
            self.assertEqual((seeds["type"], seeds["primitives"], seeds["fields"]), ("Particles", 24, {}))
            x = volume["origin"][0] + volume["spacing"][0] * 23 * np.array([0.25, 0.75])
            np.testing.assert_allclose(np.unique(seeds["structure"]["points"][:, 0]), x, atol=1e-12)
            np.testing.assert_array_equal(seeds["structure"]["ids"], np.arange(24))
            with self.assertRaisesRegex(galaxy.GalaxyError, "nothing"):
                client.fetch("nothing")
            for made in ("seeds", "balls"):
                client.request(f"drop {made}")

    def test_files_outside_the_data_folders_cannot_be_reached(self):
        with connect() as client:
            client.request("load data")
            for name in ("/etc/passwd", "../../etc/passwd"):
                with self.assertRaisesRegex(galaxy.GalaxyError, "no such file that may be read"):
                    client.request("import " + json.dumps({"Datasets": {"type": "Triangles", "filename": name}}))


class Pixels(unittest.TestCase):
    def setUp(self):
        self.events = queue.Queue()
        self.client = connect(on_event=self.events.put)
        self.addCleanup(self.client.close)
        self.window = self.client.window(1, size=STATE["Camera"]["dimensions"], follow=True)
        self.window.set(STATE)

    def test_a_picture_is_the_one_that_gxyrender_writes_to_the_bit(self):
        picture = self.window.render(levels=[8, 3, 1])
        self.assertEqual(picture.rgba.shape, (260, 300, 4))
        self.assertEqual({scale: level.shape[:2] for scale, level in picture.levels.items()},
                         {8: (33, 38), 3: (87, 100), 1: (260, 300)})
        galaxy.write_png(server.folder / "client.png", picture.rgba)
        (server.folder / "state.json").write_text(json.dumps(STATE))
        subprocess.run([PROGRAMS / "gxyrender", "state.json", "-o", "batch"], cwd=server.folder, check=True,
                       stdout=subprocess.DEVNULL)
        subprocess.run([PROGRAMS / "gxydiff", "--alpha", "client.png", "batch_00000.png"], cwd=server.folder, check=True)

    def test_passes_are_counted_and_change_what_is_seen(self):
        one = self.window.render(levels=[1])
        many = self.window.render(levels=[1], passes=4)
        self.assertEqual((one.end["passes"], many.end["passes"]), (1, 4))
        difference = np.abs(one.rgba.astype(int) - many.rgba)
        self.assertGreater(difference.max(), 0)
        self.assertLess(difference.mean(), 8)

    def test_the_newest_of_many_frames_is_the_one_that_stays(self):
        camera = copy.deepcopy(STATE["Camera"])
        frames = []
        for i in range(20):
            camera["viewpoint"] = [3 - 0.05 * i, 2, 4]
            frames.append(self.window.start(Camera=camera))
        self.assertEqual(frames, list(range(frames[0], frames[0] + 20)))
        last = self.window.wait(frames[-1])
        self.assertEqual(last.end["status"], "complete")
        expected = self.window.render()
        np.testing.assert_array_equal(last.rgba, expected.rgba)

    def test_a_new_generation_is_rendered_by_itself(self):
        before = self.window.render()
        self.client.request("load data")
        self.client.request('import {"Datasets": [{"name": "balls", "type": "Volume", "filename": "balls.vti", '
                            '"array": "eightBalls"}]}')
        while self.events.get(timeout=20)["event"] != "frame":
            pass
        after = self.window.wait(before.frame + 1)
        self.assertGreater(after.end["generations"]["balls"], before.end["generations"]["balls"])
        self.assertGreater(np.abs(after.rgba.astype(int) - before.rgba).max(), 50)
        self.client.request("drop balls")

    def test_a_picture_that_is_superseded_is_that_of_the_newer_frame(self):
        pictures = []
        thread = threading.Thread(target=lambda: pictures.append(self.window.render(passes=4096)))
        thread.start()
        while not self.client.request("viewer.windows")["windows"][0]["frame"]:
            time.sleep(0.01)
        newest = self.window.start()
        thread.join()
        self.assertEqual(pictures[0].frame, newest)

    def test_a_frame_is_cancelled(self):
        frame = self.window.start(passes=4096)
        self.client.request("cancel_frame 1")
        self.assertEqual(self.window.wait(frame).end["status"], "cancelled")

    def test_tiles_of_another_encoding_fail_their_frame_only(self):
        frame = self.client.request(f"viewer.render {self.window.number}")["frame"]  # zstd
        end = self.window.wait(frame).end
        self.assertEqual(end["status"], "failed")
        self.assertIn("expected zlib", end["error"])
        self.assertIsNotNone(self.window.render().rgba)

    def test_wrong_options_are_errors_that_name_them(self):
        for options, expected in (({"passes": 0}, "passes"), ({"levels": [1, 4]}, "levels"), ({"level": [1]}, "render")):
            with self.assertRaisesRegex(galaxy.GalaxyError, expected):
                self.window.start(**options)

    def test_a_batch_comes_as_the_files_that_it_would_have_written(self):
        files = []
        with connect(on_file=lambda number, about, content: files.append((number, about, content))) as client:
            client.request("load viewer")
            state = json.dumps(STATE)
            written = client.request(f'batch {{"state": {state}, "prefix": "written"}}')["pictures"]
            number, reply = client.send(f'viewer.batch {{"state": {state}, "to": "client"}}')
            reply.result(60)
        self.assertEqual(written, ["written_00000.png"])
        self.assertEqual([f[0] for f in files], [number])
        self.assertEqual((files[0][1]["index"], files[0][1]["of"]), (0, 1))
        self.assertEqual(files[0][2], (server.folder / "written_00000.png").read_bytes())


class Program(unittest.TestCase):
    def run_it(self, *arguments):
        return subprocess.run([sys.executable, galaxy.__file__, "-P", str(server.port), "--token-file", server.token,
                               *arguments], cwd=server.folder, capture_output=True, text=True)

    def test_a_state_file_becomes_a_picture(self):
        (server.folder / "scene.json").write_text(json.dumps(STATE))
        done = self.run_it("scene.json", "-o", "scene.png")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertEqual((server.folder / "scene.png").read_bytes()[:8], b"\x89PNG\r\n\x1a\n")

    def test_what_fails_is_said_and_the_status_is_1(self):
        done = self.run_it("nosuch.json")
        self.assertEqual(done.returncode, 1)
        self.assertIn("nosuch.json", done.stderr)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)

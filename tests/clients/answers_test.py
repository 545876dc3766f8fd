# SPDX-License-Identifier: Apache-2.0
"""answers_test.py PROGRAMS: what clients make of answers that no good server gives, and of ends that come early. The server
is a stand-in that answers as each test says."""
import fcntl
import json
import os
import pathlib
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import unittest
import unittest.mock
import zlib

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "python" / "src"))
import gxy.client  # noqa: E402

PROGRAMS = pathlib.Path(sys.argv[1]).resolve()
SOURCES = pathlib.Path(gxy.client.__file__).parents[1]
GXY = [sys.executable, "-B", "-m", "gxy"]
CONTROL, REPLY, EVENT, PIXELS, FILE = 0, 2, 3, 4, 5
STATE = {"Datasets": [{"name": "a b", "type": "Volume", "filename": "x.vol"}],
         "Visualization": {"operators": [{"type": "Volume", "dataset": "a b", "volume rendering": True}]},
         "Camera": {"viewpoint": [0, 0, 3], "viewcenter": [0, 0, 0], "dimensions": [16, 16]}}


class StandIn:
    """Serves one client. `answers`: replies by statement, bytes; others are answered by `ok`, and
    those of which it is None by nothing. `frames`: by statement, what is
    sent before its reply, pairs of channel and payload. After the reply of a statement in `last` it says bye. What was asked is
    in `asked`, and pongs."""

    def __init__(self, answers=None, events=(), last=None, limits=None, frames=None):
        self._answers, self._frames = {} if answers is None else answers, frames or {}
        self._events, self._last = events, last
        self._welcome = {"server": "stand-in", "session": 1, "tenant": "t", "administrator": True, "ranks": 1,
                         "limits": limits or {}}
        self.asked = []
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.port = self._listener.getsockname()[1]
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._listener.close()

    def _serve(self):
        try:
            connection, _ = self._listener.accept()
        except OSError:
            return  # nobody came
        with connection, connection.makefile("rb") as stream:
            def send(channel, number, payload):
                connection.sendall(struct.pack("<QHHI", len(payload), channel, 0, number) + payload)

            connection.sendall(b"GALAXY\r\n" + struct.pack("<II", 1, 0))
            stream.read(16)
            try:
                while header := stream.read(16):
                    size, channel, _, number = struct.unpack("<QHHI", header)
                    text = stream.read(size).decode()
                    if text.startswith("pong "):
                        self.asked.append(text)
                    elif channel == CONTROL:
                        send(CONTROL, 0, b"welcome " + json.dumps(self._welcome).encode())
                        for event in self._events:
                            send(EVENT, 0, event)
                    if channel == CONTROL:
                        continue
                    self.asked.append(text)
                    for frame in self._frames.get(text, ()):
                        send(frame[0], number if frame[0] == FILE else 0, frame[1])
                    answer = self._answers.get(text, b"ok")
                    if answer is not None:
                        send(REPLY, number, answer)
                    if text == self._last:
                        send(CONTROL, 0, b"bye the server stops")
                        return
            except OSError:
                pass  # the client has gone

    def ended(self):
        """Waits until the client has gone; what it had asked."""
        self._thread.join(60)
        return self.asked


def pixels(kind, frame, data, tile=(0, 0, 4, 4), size=None):
    """A record of window 1, of a picture of 8 x 8 pixels; `size`: as its header says it."""
    return struct.pack("<IIQ8IHHIQ", kind, 1, frame, 8, 8, 1, 0, *tile, 3, 0, 0, len(data) if size is None else size) + data


def end(frame, status="complete"):
    return PIXELS, pixels(3, frame, json.dumps({"status": status}).encode(), (0, 0, 0, 0))


class Python(unittest.TestCase):
    def client(self, server, **options):
        client = gxy.client.Client(port=server.port, token="", **options)
        self.addCleanup(client.close)
        return client

    def test_replies_that_mean_nothing_are_errors_and_the_connection_goes_on(self):
        answers = {"binary": b"error: last read: '\xa0'", "list": b"ok [1, 2]", "half": b"ok {", "other": b"yes",
                   "deep": b"ok " + b"[" * 100000}
        with StandIn(answers) as server:
            client = self.client(server)
            for statement, expected in (("binary", "last read: '\ufffd'"), ("list", "JSON object"), ("half", "reply: "),
                                        ("other", "expected `ok`"), ("deep", "reply: ")):
                with self.assertRaisesRegex(gxy.client.GalaxyError, expected):
                    client.request(statement, timeout=60)
            self.assertEqual(client.request("echo", timeout=60), {})

    def test_a_callback_that_fails_is_logged_and_ends_nothing(self):
        with StandIn(events=[b'{"event": "added"}']) as server, self.assertLogs("galaxy") as logged:
            client = self.client(server, on_event=lambda event: event["nosuch"])
            client.request("echo", timeout=60)
        self.assertIn("nosuch", logged.output[0])

    def test_a_request_that_is_too_long_is_not_sent(self):
        with StandIn(limits={"request bytes": 100}) as server:
            client = self.client(server)
            with self.assertRaisesRegex(gxy.client.GalaxyError, "a request of 101 bytes, expected at most 100"):
                client.request("x" * 101, timeout=60)
            client.request("x" * 100, timeout=60)
        self.assertEqual(server.asked, ["x" * 100])

    def test_after_the_end_requests_are_errors(self):
        with StandIn(last="quit") as server:
            client = self.client(server)
            client.request("quit", timeout=60)
            for _ in range(3):
                with self.assertRaisesRegex(gxy.client.GalaxyError, "the connection has ended"):
                    client.request("list", timeout=60)

    def test_requests_that_are_out_when_the_connection_ends_are_errors(self):
        with StandIn({"never": None}, last="never") as server:
            client = self.client(server)
            with self.assertRaisesRegex(gxy.client.GalaxyError, "the connection has ended: the server stops"):
                client.request("never", timeout=60)

    def test_a_request_that_nobody_waits_for_any_more_ends_nothing(self):
        with StandIn({"first": b'ok {"text": "late"}'}) as server:
            client = self.client(server)
            client.send("first")[1].cancel()
            self.assertEqual(client.request("second", timeout=60), {})


    def test_pings_are_answered_before_what_comes_after_them(self):
        with StandIn(frames={"echo": [(CONTROL, b"ping 17")]}) as server:
            client = self.client(server)
            client.request("echo", timeout=60)
            client.request("list", timeout=60)
        self.assertEqual(server.asked, ["echo", "pong 17", "list"])

    def test_ids_begin_anew_after_the_largest(self):
        with StandIn() as server:
            client = self.client(server)
            client._next_id = 0xFFFFFFFF
            self.assertEqual([client.send("echo")[0] for _ in range(3)], [0xFFFFFFFF, 1, 2])

    def test_the_token_of_a_server_that_was_killed_is_not_used(self):
        with tempfile.TemporaryDirectory(prefix="galaxy-answers-") as folder, \
                unittest.mock.patch.dict(os.environ, {"XDG_RUNTIME_DIR": folder}):
            path = pathlib.Path(gxy.client.token_file(1))
            path.parent.mkdir()
            path.write_text("0" * 64 + "\n")
            token, reason = gxy.client._token_for("127.0.0.1", 1)
            self.assertEqual(token, "")
            self.assertIn("a server that was killed has left this token", reason)
            with open(path, encoding="ascii") as server:
                fcntl.flock(server, fcntl.LOCK_EX)
                self.assertEqual(gxy.client._token_for("127.0.0.1", 1), ("0" * 64, None))

    def window(self, frames, last=None):
        """A window of a server that answers `echo` after these frames."""
        server = StandIn(frames={"echo": frames}, last=last)
        self.addCleanup(server.__exit__)
        client = self.client(server)
        window = client.window(1)
        client.request("echo", timeout=60)
        return window

    def test_who_waits_for_a_frame_gets_the_newest_that_has_ended(self):
        window = self.window([end(1, "superseded"), end(2), end(3)])
        self.assertEqual((window.wait(1, 60).frame, window.wait(3, 60).frame), (3, 3))

    def test_a_window_that_was_closed_leaves_nothing_to_the_next_of_its_number(self):
        window = self.window([end(1)])
        self.assertEqual(window.wait(1, 60).frame, 1)
        window.close()
        with self.assertRaisesRegex(gxy.client.GalaxyError, "frame 1 has not ended after 0 s"):
            window._client.window(1).wait(1, 0)

    def test_of_ends_of_frames_the_newest_64_are_kept(self):
        self.assertEqual(sorted(self.window([end(frame) for frame in range(1, 101)])._ends), list(range(37, 101)))

    def test_pixels_that_mean_nothing_end_the_connection_with_the_reason(self):
        data = zlib.compress(bytes(64))
        for record, reason in ((pixels(1, 1, data, (5, 0, 4, 4)), "a tile of 4 x 4, expected one inside 8 x 8"),
                               (pixels(1, 1, data, (0, 5, 4, 4)), "a tile of 4 x 4, expected one inside 8 x 8"),
                               (pixels(1, 1, data, size=len(data) + 1), "their header says"),
                               (pixels(1, 1, zlib.compress(bytes(63))), "a tile of 63 bytes, expected 4 x 4 x 4"),
                               (pixels(3, 1, b"{}", (0, 0, 0, 0), 3), "their header says 3")):
            with self.assertRaisesRegex(gxy.client.GalaxyError, reason):
                self.window([(PIXELS, record)])

    def test_who_waits_for_a_frame_hears_that_the_connection_has_ended(self):
        window = self.window([], last="echo")
        with self.assertRaisesRegex(gxy.client.GalaxyError, "the connection has ended: the server stops"):
            window.wait(1, 20)


class Programs(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="galaxy-answers-")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def run_it(self, program, server, *arguments):
        return subprocess.run([*program, "-P", str(server.port), "--token-file", "-", *arguments], cwd=self.folder,
                              capture_output=True, timeout=120)

    def gxy(self, server, *arguments):
        return subprocess.run([*GXY, "--server", f"localhost:{server.port}", "--token-file", "-", *arguments], cwd=self.folder,
                              capture_output=True, timeout=120, env={**os.environ, "PYTHONPATH": str(SOURCES)})

    def say(self, server, *arguments):
        return self.run_it([PROGRAMS / "msdata"], server, *arguments)

    def test_a_reply_that_is_no_object_is_an_error_and_the_next_statement_runs(self):
        with StandIn({"arr": b"ok [1, 2]", "half": b"ok {", "deep": b'ok {"a": ' + b"[" * 100000}) as server:
            done = self.say(server, "-c", "arr; half; deep; echo b")
        self.assertEqual(server.asked, ["load data", "arr", "half", "deep", "echo b"])
        self.assertEqual(done.returncode, 1)
        self.assertIn(b"error: reply: expected a JSON object, found array", done.stderr)

    def test_a_long_listing_is_one_however_long(self):
        listing = b'ok {"datasets": [' + b",".join([b'{"name": "x"}'] * 600000) + b'], "text": "many"}'
        with StandIn({"list": listing}) as server:
            done = self.say(server, "-c", "list")
        self.assertEqual((done.returncode, done.stdout, done.stderr), (0, b"  many\n", b""))

    def test_statements_that_were_not_sent_are_told(self):
        for arguments in (["-c", "import a; import b; import c"], ["-c", "import a; import b", "-c", "import c"]):
            with StandIn(last="import b") as server:
                done = self.say(server, *arguments)
            self.assertEqual(server.asked, ["load data", "import a", "import b"])
            self.assertIn(done.returncode, (1, 2), "it was sent into a connection that had ended, or not sent at all")
            self.assertIn(b"the connection has ended: ", done.stderr)

    def test_a_statement_that_failed_is_seen_in_the_exit_status_also_of_json(self):
        for options in ([], ["--json"]):
            with StandIn({"bad": b"error: no"}) as server:
                self.assertEqual(self.say(server, *options, "-c", "bad; good").returncode, 1)
            with StandIn() as server:
                self.assertEqual(self.say(server, *options, "-c", "good").returncode, 0)

    def test_exit_leaves_all_that_follows(self):
        (self.folder / "script").write_text("three;")
        with StandIn() as server:
            done = self.say(server, "-c", "one; exit; two", "-c", "two", "script")
        self.assertEqual((server.ended(), done.returncode), (["load data", "one"], 0))

    def test_a_picture_that_cannot_be_written_is_seen_in_the_exit_status_also_of_json(self):
        (self.folder / "taken").mkdir()
        for options in ([], ["--json"]):
            for name, status in ((b"taken", 1), (b"free", 0)):
                header = b'{"name": "' + name + b'"}'
                with StandIn(frames={"one": [(FILE, struct.pack("<I", len(header)) + header + b"picture")]}) as server:
                    self.assertEqual(self.say(server, *options, "-c", "one").returncode, status, (options, name))
        self.assertEqual((self.folder / "free").read_bytes(), b"picture")

    def test_statements_of_the_command_line_are_all_there_are(self):
        with StandIn() as server:
            done = subprocess.run([PROGRAMS / "msdata", "-P", str(server.port), "--token-file", "-", "-c", "one"],
                                  cwd=self.folder, input=b"two;", capture_output=True, timeout=120)
        self.assertEqual((server.ended(), done.returncode), (["load data", "one"], 0))

    def test_msdata_answers_pings(self):
        with StandIn(frames={"one": [(CONTROL, b"ping 17")]}) as server:
            self.say(server, "-c", "one; two")
        self.assertEqual(server.ended(), ["load data", "one", "pong 17", "two"])

    def test_a_picture_whose_header_does_not_fit_ends_the_connection(self):
        for record in (b"", struct.pack("<I", 5) + b"{}", struct.pack("<I", 0xFFFFFFFF) + b"{}"):
            with StandIn(frames={"one": [(FILE, record)]}) as server:
                done = self.say(server, "-c", "one; two")
            self.assertIn(b"its header does not fit", done.stderr)
            self.assertNotEqual(done.returncode, 0)

    def test_the_program_gxy_asks_for_the_cameras_size_and_for_the_passes_that_were_said(self):
        (self.folder / "scene.json").write_text(json.dumps(STATE))
        with StandIn(RenderFails()) as server:
            self.gxy(server, "--passes", "3", "scene.json")
        asked = {text.split("{")[0]: json.loads(text[text.index("{"):]) for text in server.ended() if "{" in text}
        self.assertEqual(asked["viewer.window 1 "], {"size": [16, 16]})
        self.assertEqual(asked["viewer.render 1 "]["passes"], 3)

    def test_the_program_gxy_tells_warnings(self):
        (self.folder / "scene.json").write_text(json.dumps(STATE))
        with StandIn(Warns()) as server:
            done = self.gxy(server, "scene.json")
        self.assertEqual(done.stderr, b"gxy: warning: key x means nothing\ngxy: error: nothing to render\n")
        self.assertEqual(done.returncode, 1)

    def test_the_last_one_may_end_the_connection(self):
        with StandIn(last="quit") as server:
            done = self.say(server, "-c", "quit;")
        self.assertEqual((done.returncode, done.stderr), (0, b""))

    def test_nothing_that_a_server_says_moves_the_terminal(self):
        evil = "\x1b]0;title\x07 \u009b2J \x7f fine \u00e9"
        answers = {"one": b"ok " + json.dumps({"text": evil}).encode(), "two": b"error: " + evil.encode() + b"\xff",
                   "three": b"ok " + json.dumps({"value": evil}).encode()}
        event = json.dumps({"event": "added", "name": evil, "generation": 1}).encode()
        for options in ([], ["--json"]):
            with StandIn(answers, events=[event]) as server:
                done = self.say(server, *options, "-c", "one; two; three")
            said = (done.stdout + done.stderr).decode()
            self.assertEqual([c for c in said if (c < " " and c != "\n") or "\x7f" <= c <= "\x9f"], [], said)
            self.assertIn("fine \u00e9", said)
        replies = [json.loads(line) for line in done.stdout.decode().splitlines()]
        self.assertEqual([r["reply"]["text"] for r in replies if r.get("statement") == "one"], [evil])

    def test_the_viewer_asks_for_its_own_data_only_and_survives_that_they_go(self):
        (self.folder / "scene.json").write_text(json.dumps(STATE))
        with StandIn(RenderFails({'data.info "a b"': b"error: there is none"})) as server:
            done = self.run_it([PROGRAMS / "gxyviewer"], server, "--snapshot", "x.png", "scene.json")
        self.assertIn('data.info "a b"', server.asked)
        self.assertNotIn("data.info", server.asked)
        self.assertEqual(done.returncode, 1)
        self.assertIn(b"nothing to render", done.stderr)

    def test_the_program_gxy_says_what_is_wrong_with_a_state_file(self):
        for text, words in (("[]", b"expected a JSON object"), ('{"Cameras": []}', b"`Cameras` is empty"), ("{", b"error: ")):
            (self.folder / "state.json").write_text(text)
            with StandIn() as server:
                done = self.gxy(server, "state.json")
            self.assertEqual(done.returncode, 1)
            self.assertTrue(done.stderr.startswith(b"gxy: error: "), done.stderr)
            self.assertIn(words, done.stderr)

    def test_the_program_gxy_says_that_numpy_is_missing(self):
        (self.folder / "numpy.py").write_text("raise ImportError('No module named numpy')")
        done = subprocess.run([*GXY, "state.json"], cwd=self.folder, capture_output=True,
                              env={"PYTHONPATH": f"{self.folder}:{SOURCES}"}, timeout=60)
        self.assertEqual(done.returncode, 1)
        self.assertIn(b"need NumPy", done.stderr)
        self.assertNotIn(b"Traceback", done.stderr)


class RenderFails(dict):
    """Answers, with an error for every frame."""

    def get(self, statement, default=None):
        return b"error: nothing to render" if statement.startswith("viewer.render") else super().get(statement, default)


class Warns(RenderFails):
    """The same, with a warning for what a window is to show."""

    def get(self, statement, default=None):
        if statement.startswith("viewer.set"):
            return b'ok {"warnings": ["key x means nothing"]}'
        return super().get(statement, default)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)

# SPDX-License-Identifier: Apache-2.0
"""session_test.py PROGRAMS MPIEXEC...: connecting, data, steps of a simulation, events, and errors of connections, from Python."""
import json
import os
import pathlib
import socket
import subprocess
import sys
import threading
import unittest

import numpy as np

from galaxy_case import PROGRAMS, MPIEXEC, SOURCE, OnRanks, Server, gxy, main


class Sessions(OnRanks):
    def test_a_file_becomes_data(self):
        balls = self.session.open("balls.vti", array="oneBall", name="mine")
        self.assertEqual((balls.name, balls.type, balls.generation), ("mine", "Volume", 1))
        values = balls.values()
        self.assertEqual(values.shape, (24, 24, 24))
        np.testing.assert_allclose(balls.range, (values.min(), values.max()), rtol=1e-6)
        np.testing.assert_allclose(balls.box, [[-1, -1, -1], [1, 1, 1]], atol=1e-6)
        np.testing.assert_array_equal(balls.values("oneBall"), values)
        self.assertEqual(self.session.open("balls.vti", array="eightBalls", name="mine", type="Volume").generation, 2)
        self.assertEqual(self.session["mine"].name, "mine")
        self.assertEqual([data.name for data in self.session], ["mine"])
        self.assertIn("mine", self.session)
        with self.assertRaisesRegex(gxy.GalaxyError, "no field 'nothing', expected one of .*eightBalls"):
            balls.values("nothing")
        self.assertEqual(pathlib.Path(balls.export("again.vti")).name, "again.vti")
        again = self.session.open("again.vti", like=balls)
        np.testing.assert_array_equal(again.values(), balls.values())
        kept = balls.copy("kept")
        balls.drop()
        np.testing.assert_array_equal(kept.values(), again.values())
        kept.drop()
        with self.assertRaisesRegex(gxy.GalaxyError, 'mine.*there are: again'):
            self.session["mine"]
        with self.assertRaises(gxy.GalaxyError):
            balls.range

    def test_files_that_the_server_cannot_read_are_errors(self):
        with self.assertRaisesRegex(gxy.GalaxyError, "no_such.vti"):
            self.session.open("no_such.vti")
        with self.assertRaisesRegex(gxy.GalaxyError, "no such file that may be read"):
            self.session.open("/etc/passwd", type="Volume")
        with self.assertRaisesRegex(gxy.GalaxyError, "nothing"):
            self.session.open("balls.vti", array="nothing")

    def test_arrays_are_given_to_the_server(self):
        rng = np.random.default_rng(1)
        array = rng.random((5, 6, 7), np.float32)
        data = self.session.put("heat.T", array, origin=(1, 2, 3), spacing=0.5, step=3)
        self.assertEqual((data.name, data.generation, data.info["origins"][0]["step"]), ("heat.T", 1, 3))
        np.testing.assert_array_equal(data.values(), array)
        np.testing.assert_allclose(data.box, [[1, 2, 3], [4, 4.5, 5]])
        np.testing.assert_array_equal(self.session.put("heat.T", array[::-1], step=4, time=0.25).values(), array[::-1])
        self.assertEqual((data.generation, data.info["time"]), (2, 0.25))
        vectors = rng.random((3, 4, 5, 3), np.float32)
        flow = self.session.put("flow.u", vectors[:, ::-1], spacing=(1, 2, 3))
        np.testing.assert_array_equal(flow.values(), vectors[:, ::-1])
        self.assertEqual(flow.info["components"], 3)
        doubles = np.linspace(0, 1, 60).reshape(3, 4, 5)
        np.testing.assert_allclose(self.session.put("heat.p", doubles, like=data, origin=(1, 2, 3), spacing=0.5).values(), doubles,
                                   atol=1e-7)
        for name in ("T", ".T", "heat."):
            with self.assertRaisesRegex(gxy.GalaxyError, 'expected "STREAM.FIELD"'):
                self.session.put(name, array)
        with self.assertRaisesRegex(gxy.GalaxyError, r"shape \(4,\), expected \(nz, ny, nx\)"):
            self.session.put("heat.T", np.zeros(4))
        with self.assertRaisesRegex(gxy.GalaxyError, "heat.T: field 'T': dtype"):
            self.session.put("heat.T", np.zeros((2, 2, 2), complex))

    def test_the_server_counts_the_values_of_a_histogram(self):
        values = np.arange(60.0).reshape(3, 4, 5)
        data = self.session.put("heat.T", values)
        for options, expected in (({}, np.histogram(values, 256)), ({"bins": 4}, np.histogram(values, 4))):
            counts, edges = data.histogram(**options)
            self.assertEqual((counts.dtype, edges.dtype), (np.int64, np.float64))
            np.testing.assert_array_equal(counts, expected[0])
            np.testing.assert_allclose(edges, expected[1])
        vectors = np.stack([values, 3 * values, 4 * values], axis=-1)
        flow = self.session.put("flow.u", vectors)
        for component, expected in ((1, vectors[..., 1]), (None, np.linalg.norm(vectors, axis=-1))):
            counts, edges = flow.histogram_async(7, component).result(60)
            np.testing.assert_allclose((edges[0], edges[-1]), (expected.min(), expected.max()), rtol=1e-6)
            np.testing.assert_array_equal(counts, np.histogram(expected, 7)[0])
        with self.assertRaisesRegex(gxy.GalaxyError, "1 to 4096"):
            data.histogram(0)

    def test_arrays_that_cannot_be_given_say_why(self):
        code = ("import gxy, numpy, sys\n"
                "with gxy.connect(sys.argv[1], sys.argv[2]) as session:\n"
                "    try:\n"
                "        session.put('heat.T', numpy.zeros((2, 3, 4)), timeout=5)\n"
                "    except gxy.GalaxyError as error:\n"
                "        print(error)\n")
        for changed, words in (({"LD_LIBRARY_PATH": "/nowhere"}, "Galaxy's library for simulations was not found. Expected it"),
                               ({"GALAXY_INSITU": "off"}, "publishing is off: the environment variable GALAXY_INSITU says so")):
            done = subprocess.run([sys.executable, "-B", "-c", code, f"localhost:{self.server.port}", self.server.token], text=True,
                                  capture_output=True, timeout=60,
                                  env={**os.environ, "PYTHONPATH": str(SOURCE / "python/src"), **changed})
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            self.assertIn(words, done.stdout)

    def test_steps_of_a_simulation_are_seen_until_it_ends(self):
        seen, names = [], ["simsim.eightBalls", "simsim.oneBall"]
        future = self.session.wait_async(names[1], timeout=60)
        graph = self.session.graph("follows")
        graph.live(names[1])
        view = graph.view(graph.volume(names[1], isovalues=[0.5], data_range=[0, 2]), size=(40, 30))
        simulation = subprocess.Popen(
            [PROGRAMS / "simsim", "balls.vti", "balls.vti", "--array", "oneBall", "--array", "eightBalls", "-n", "6", "-d", "0", "-M", "2",
             "--policy", "wait", "-P", str(self.server.port), "--token-file", self.server.token], cwd=self.server.folder,
            stdout=subprocess.DEVNULL, env={**os.environ, "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"})
        self.addCleanup(simulation.wait)
        self.assertEqual(future.result(60).name, names[1])
        for step in self.session[names[1]].steps(timeout=60):
            picture = view.render()
            seen.append(step)
            self.assertEqual(picture.size, (40, 30))
        self.assertEqual(simulation.wait(60), 0)
        self.assertEqual((seen, seen[-1]), (sorted(set(seen)), 6))
        self.assertEqual(list(self.session[names[0]].steps(timeout=60)), [6])  # what was there last

    def test_steps_of_other_data_are_their_generations(self):
        steps = self.session.open("balls.vti", array="oneBall", name="mine").steps(timeout=60)
        self.assertEqual(next(steps), 1)
        self.session.open("balls.vti", array="eightBalls", name="mine")
        self.assertEqual(next(steps), 2)
        with self.assertRaisesRegex(gxy.Timeout, 'dataset "mine": no newer step after 0.1 s'):
            list(self.session["mine"].steps(timeout=0.1))
        later = self.session.open("balls.vti", array="oneBall", name="mine").steps(timeout=60)
        self.assertEqual(next(later), 3)
        self.session["mine"].drop()
        with self.assertRaisesRegex(gxy.GalaxyError, "mine"):
            next(later)

    def test_waiting_ends_in_time(self):
        with self.assertRaisesRegex(gxy.Timeout, "no answer to `data.wait .*nothing.* after 0.1 s") as raised:
            self.session.wait("nothing", timeout=0.1)
        self.assertIsInstance(raised.exception, TimeoutError)
        self.assertIsInstance(raised.exception, gxy.GalaxyError)
        graph = self.session.graph("g")
        graph.live("nothing")
        view = graph.view(graph.volume("nothing"), size=(8, 8))
        with self.assertRaisesRegex(gxy.Timeout, 'view "view" is waiting, .* after 0.2 s'):
            view.render(timeout=0.2)
        with self.assertRaises(gxy.Timeout):
            graph["nothing"].wait(timeout=0.2)
        self.session.open("balls.vti", name="nothing")
        self.assertEqual(view.render().size, (8, 8))
        with self.assertRaises(gxy.Timeout):
            view.render(size=(2000, 2000), passes=4096, timeout=0.3)
        self.assertEqual(view.render(size=(8, 8)).end["passes"], 1)

    def test_events_are_told_on_a_thread_of_their_own(self):
        told, threads, done = [], set(), threading.Event()

        def hear(event):
            told.append((event["event"], event["name"], self.session.graphs))  # it may use the session
            threads.add(threading.current_thread().name)
            if event["name"] == "two":
                done.set()
            raise ValueError("which is logged, and changes nothing")

        off = self.session.on(hear, "added")
        self.session.ask("data.observe")
        with self.assertLogs("galaxy"):
            self.session.open("balls.vti", name="one")
            self.session.open("balls.vti", name="two")
            self.assertTrue(done.wait(20))
        off()
        off()
        self.session.open("balls.vti", name="three")
        self.assertEqual([event[:2] for event in told], [("added", "one"), ("added", "two")])
        self.assertEqual(threads, {"gxy callbacks"})

    def test_no_thread_is_left_after_close(self):
        before = threading.enumerate()
        session = self.connect()
        session.on(lambda event: None)
        waits = [session.wait_async("nothing"), session.open_async("balls.vti", name="there")]
        self.assertEqual(waits[1].result(60).name, "there")
        session.close()
        session.close()
        with self.assertRaisesRegex(gxy.GalaxyError, "the connection has ended"):
            waits[0].result(20)
        with self.assertRaisesRegex(gxy.GalaxyError, "the connection has ended"):
            session.data
        self.assert_no_thread_left(before)

    def test_errors_of_a_rank_name_it(self):
        error = gxy.GalaxyError("rank 2: Datasets[\"a \\\"b\"]: `x[3].y`: wrong")
        self.assertEqual((error.rank, error.node, error.path), (2, 'a "b', ["Datasets", 'a "b', "x", 3, "y"]))
        plain = gxy.GalaxyError("something else")
        self.assertEqual((plain.rank, plain.node, plain.path), (None, None, None))

    def test_the_program_leaves_a_picture_of_a_state_file(self):
        (self.server.folder / "scene.json").write_text("""{"Datasets": [{"name": "balls", "type": "Volume", "filename": "balls.vti"}],
            "Visualization": {"operators": [{"type": "Volume", "dataset": "balls", "isovalues": [0.4]}]},
            "Camera": {"viewpoint": [3, 2, 4], "viewcenter": [0, 0, 0], "dimensions": [120, 90]}}""")
        done = self.program("scene.json", "-o", "out.png", "--size", "64x48", "--passes", "2")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        state = json.loads((self.server.folder / "scene.json").read_text())
        state["Renderer"] = {"rays per pixel": 2}
        (self.server.folder / "two.json").write_text(json.dumps(state))
        self.run_here("gxyrender", "two.json", "-o", "two", "--size", "64x48")
        self.run_here("gxydiff", "--alpha", "out.png", "two_00000.png")
        for wrong in (["--size", "64"], ["--server", "a:b:c"], ["--passes", "x"], []):
            self.assertEqual(self.program(*wrong, *(["scene.json"] if wrong else [])).returncode, 2, wrong)
        self.assertEqual(self.program("missing.json").returncode, 1)
        self.assertIn("missing.json", self.program("missing.json").stderr)

    def program(self, *arguments):
        return subprocess.run([sys.executable, "-B", "-m", "gxy", "--token-file", self.server.token, "--server",
                               f"localhost:{self.server.port}", *arguments], cwd=self.server.folder, capture_output=True, text=True,
                              env={**os.environ, "PYTHONPATH": str(SOURCE / "python/src")}, timeout=120)


class OnOneRank(Sessions, unittest.TestCase):
    ranks = 1


class OnThreeRanks(Sessions, unittest.TestCase):
    ranks = 3


class Connections(unittest.TestCase):
    def test_who_cannot_connect_is_told_why(self):
        with socket.socket() as taken:  # bound and not listening: nobody answers there
            taken.bind(("127.0.0.1", 0))
            with self.assertRaisesRegex(gxy.GalaxyError, "is a server running there"):
                gxy.connect(f"localhost:{taken.getsockname()[1]}", "-")
        with self.assertRaisesRegex(gxy.GalaxyError, "/nowhere: No such file"):
            gxy.connect("localhost:5001", "/nowhere")
        with self.assertRaisesRegex(gxy.GalaxyError, "another machine"):
            gxy.connect("192.0.2.1:5001")
        for wrong in ("a:b", "", ":5001", "host:0", "host:70000", "a b"):
            with self.assertRaisesRegex(gxy.GalaxyError, "expected HOST:PORT"):
                gxy.client.split_address(wrong)
        self.assertEqual(gxy.client.split_address("[::1]:80"), ("::1", 80))
        self.assertEqual(gxy.client.split_address("login1"), ("login1", 5001))

    def test_a_server_that_says_nothing_is_given_up(self):
        before = threading.enumerate()
        with socket.create_server(("127.0.0.1", 0)) as silent:
            with self.assertRaisesRegex(gxy.GalaxyError, "timed out"):
                gxy.connect(f"127.0.0.1:{silent.getsockname()[1]}", "-", timeout=0.2)
        self.assertEqual(set(threading.enumerate()), set(before))

    def test_a_wrong_token_is_refused(self):
        server = Server(PROGRAMS, MPIEXEC, 1)
        self.addCleanup(server.stop)
        (server.folder / "other").write_text("0" * 64)
        with self.assertRaisesRegex(gxy.GalaxyError, "token is wrong"):
            gxy.connect(f"localhost:{server.port}", str(server.folder / "other"))

    def test_a_server_that_goes_ends_all_that_wait(self):
        server = Server(PROGRAMS, MPIEXEC, 1)
        self.addCleanup(server.stop)
        before = threading.enumerate()
        session = gxy.connect(f"localhost:{server.port}", str(server.token))
        graph = session.graph("g")
        graph.live("nothing")
        waits = [session.wait_async("nothing"), graph["nothing"].wait_async(), graph.view(graph.volume("nothing")).render_async(timeout=None)]
        steps = session._threads.start(lambda: list(gxy.Data(session, "nothing").steps()))
        with gxy.connect(f"localhost:{server.port}", str(server.token)) as other:
            other.ask("quit")
        for wait in [*waits, steps]:
            with self.assertRaisesRegex(gxy.GalaxyError, "the connection has ended"):
                wait.result(30)
        with self.assertRaisesRegex(gxy.GalaxyError, "the connection has ended"):
            graph.document
        session.close()
        self.assertEqual(set(threading.enumerate()), set(before))


if __name__ == "__main__":
    main()

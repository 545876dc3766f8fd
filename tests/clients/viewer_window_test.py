# SPDX-License-Identifier: Apache-2.0
"""viewer_window_test.py PROGRAMS XVFB XDOTOOL MPIEXEC...: gxyviewer on a real server and a display, with real events.

What the mouse must do to the camera are the formulas of VTK's trackball camera style, which ParaView has too: a drag by
d pixels turns by 200 d / size degrees, a notch of the wheel divides the distance by 1.1^2.
"""
import copy
import json
import math
import pathlib
import signal
import subprocess
import sys
import time
import unittest

import numpy as np

from display import Display
from server import STATE, Server

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "python" / "src"))
import gxy.client  # noqa: E402

PROGRAMS, XVFB, XDOTOOL, MPIEXEC = pathlib.Path(sys.argv[1]).resolve(), sys.argv[2], sys.argv[3], sys.argv[4:]
WIDTH, HEIGHT = STATE["Camera"]["dimensions"]
CENTER = (WIDTH // 2, HEIGHT // 2)
STATUS_ROWS = 40  # at the bottom of the window, where text is written over the picture

# Without occlusion, so that a frame at rest is one pass and has the bits of any other client's.
SCENE = copy.deepcopy(STATE)
SCENE["Visualization"]["Lighting"]["ao count"] = 0


def setUpModule():
    global server, display, client
    server = Server(PROGRAMS, MPIEXEC)
    display = Display(XVFB, XDOTOOL)
    client = gxy.client.Client(port=server.port, token_file=server.token)
    client.request("load data")
    client.request("import " + json.dumps({"Datasets": SCENE["Datasets"]}))


def tearDownModule():
    client.close()
    display.stop()
    server.stop()


def until(condition, what):
    """Waits for what the other processes do; only a failure takes the whole minute."""
    end = time.monotonic() + 60
    while not condition():
        if time.monotonic() > end:
            raise AssertionError(f"after a minute, not yet: {what}")
        time.sleep(0.02)


def over_black(rgba):
    """As a window shows it, row 0 at the top."""
    color = rgba[..., :3].astype(int) * rgba[..., 3:]
    return ((color + 127) // 255).astype(np.uint8)[::-1]


class ViewerCase(unittest.TestCase):
    PASSES, SCENE = 1, SCENE
    PLAIN = True
    OPTIONS = None  # of the number of passes; None: PASSES
    LEVELS = 40  # that a picture has at least, so that there is something to see

    def setUp(self):
        (server.folder / "scene.json").write_text(json.dumps(self.SCENE))
        self.saved = server.folder / "view.json"
        self.viewer = subprocess.Popen(
            [PROGRAMS / "gxyviewer", "-P", str(server.port), "--token-file", server.token, "--output", "view",
             *(["--plain"] if self.PLAIN else []),
             *(["--passes", str(self.PASSES)] if self.OPTIONS is None else self.OPTIONS), "scene.json"],
            cwd=server.folder, env=display.environment, stderr=subprocess.PIPE, text=True)
        self.addCleanup(self.end)
        display.do("mousemove", *CENTER)
        self.wait_for_picture(scene=self.SCENE if "Visualization" in self.SCENE else SCENE)

    def end(self):
        if self.viewer.poll() is None:
            self.viewer.kill()
        self.viewer.communicate()
        for file in server.folder.glob("view*"):
            file.unlink()

    def key(self, key):
        display.do("key", key)

    def camera(self, index=0):
        """Where it looks from now, as the state file says that it writes; it shows the camera of that index."""
        self.saved.unlink(missing_ok=True)
        self.key("w")
        until(self.saved.exists, "the state is saved")
        return json.loads(self.saved.read_text())["Cameras"][index]

    def picture(self, camera, size=(WIDTH, HEIGHT), scene=SCENE):
        """What another client gets, as a window shows it."""
        window = client.window(1, size=size)
        window.set({key: scene[key] for key in ("Datasets", "Renderer", "Visualization")})
        return over_black(window.render(Camera=camera, rays=self.PASSES).rgba)

    def wait_for_picture(self, camera=SCENE["Camera"], size=(WIDTH, HEIGHT), scene=SCENE):
        """Waits until the window shows, to the bit, what another client gets of the camera."""
        expected = self.picture(camera, size, scene)[:-STATUS_ROWS]
        self.assertGreater(len(np.unique(expected)), self.LEVELS, "there is something to see")
        until(lambda: self.viewer.poll() is not None or
              np.array_equal(display.screen(*size)[:-STATUS_ROWS], expected), "the window shows the camera's picture")
        self.assertIsNone(self.viewer.poll(), "the viewer has ended")

    @staticmethod
    def line_is_short(picture):
        """A message covers the right end of its rows of the picture, what is said at rest does not."""
        end = np.s_[-STATUS_ROWS:, -40:]
        return np.array_equal(display.screen(WIDTH, HEIGHT)[end], picture[end])

    @staticmethod
    def distance(camera):
        return math.dist((0, 0, 0), camera["viewdirection"])

    def turned(self, before, after):
        """Degrees between the views."""
        a, b = np.array(before["viewdirection"]), np.array(after["viewdirection"])
        return math.degrees(math.atan2(np.linalg.norm(np.cross(a, b)), a @ b))


class Mouse(ViewerCase):
    def test_left_drag_turns_about_the_center_by_vtks_angle(self):
        before = self.camera()
        display.drag(1, CENTER, (30, 0))
        after = self.camera()
        self.assertAlmostEqual(self.turned(before, after), 200 * 30 / WIDTH, places=6)
        self.assertAlmostEqual(self.distance(after), self.distance(before), places=9)
        np.testing.assert_allclose(np.add(after["viewpoint"], after["viewdirection"]), [0, 0, 0], atol=1e-9)
        right = np.cross(before["viewdirection"], before["viewup"])
        self.assertLess(np.dot(np.subtract(after["viewpoint"], before["viewpoint"]), right), 0,
                        "what is shown follows the mouse, so the camera goes left")
        self.wait_for_picture(after)

    def test_a_drag_counts_once_however_late_it_is_read(self):
        before = self.camera()
        self.viewer.send_signal(signal.SIGSTOP)
        display.drag(1, CENTER, (30, 0))
        self.viewer.send_signal(signal.SIGCONT)
        self.assertAlmostEqual(self.turned(before, self.camera()), 200 * 30 / WIDTH, places=6)

    def test_pictures_come_and_keys_work_while_a_button_is_held(self):
        for button in (1, 2, 3):
            with self.subTest(button=button):
                self.key("b")
                self.wait_for_picture(SCENE["Camera"])
                pictures = [display.screen(WIDTH, HEIGHT)[:-STATUS_ROWS]]
                display.do("mousemove", *CENTER, "mousedown", button)
                try:
                    while len(pictures) < 6:
                        display.do("mousemove_relative", 4, 4)
                        until(lambda: not np.array_equal(display.screen(WIDTH, HEIGHT)[:-STATUS_ROWS], pictures[-1]),
                              f"{len(pictures)} new pictures during the drag")
                        pictures.append(display.screen(WIDTH, HEIGHT)[:-STATUS_ROWS])
                    held = self.camera()
                finally:
                    display.do("mouseup", button)
                self.assertEqual(len({picture.tobytes() for picture in pictures}), len(pictures), "each is another")
                self.assertEqual(held, self.camera(), "what was saved during the drag is where it ended")
                self.wait_for_picture(held)

    def test_middle_drag_moves_what_is_shown_with_the_mouse(self):
        before = self.camera()
        display.drag(2, CENTER, (40, 0))
        after = self.camera()
        np.testing.assert_allclose(after["viewdirection"], before["viewdirection"], atol=1e-9)
        aov = math.radians(before["aov"])
        pixel = 2 * self.distance(before) * math.tan(aov / 2) / min(WIDTH, HEIGHT)
        moved = np.subtract(after["viewpoint"], before["viewpoint"])
        self.assertAlmostEqual(np.linalg.norm(moved) / (40 * pixel), 1, places=3)
        self.wait_for_picture(after)

    def test_shift_and_left_drag_pan_too(self):
        before = self.camera()
        display.drag(1, CENTER, (0, 30), keys=["shift"])
        after = self.camera()
        np.testing.assert_allclose(after["viewdirection"], before["viewdirection"], atol=1e-9)
        self.assertGreater(np.dot(np.subtract(after["viewpoint"], before["viewpoint"]), before["viewup"]), 0)

    def test_the_wheel_and_the_right_button_zoom(self):
        before = self.camera()
        display.do("click", 4)
        near = self.camera()
        self.assertAlmostEqual(self.distance(before) / self.distance(near), 1.1 ** 2, places=6)
        display.do("click", 5)
        self.assertAlmostEqual(self.distance(self.camera()), self.distance(before), places=6)
        display.drag(3, CENTER, (0, -20))
        after = self.camera()
        self.assertAlmostEqual(self.distance(before) / self.distance(after), 1.1 ** (10 * 20 / (HEIGHT / 2)), places=6)
        self.wait_for_picture(after)

    def test_ctrl_and_left_drag_roll(self):
        before = self.camera()
        display.drag(1, (WIDTH - 20, CENTER[1]), (0, 60), keys=["ctrl"])
        after = self.camera()
        np.testing.assert_allclose(after["viewdirection"], before["viewdirection"], atol=1e-9)
        self.assertGreater(math.dist(after["viewup"], before["viewup"]), 0.1)


class Keys(ViewerCase):
    def test_reset_shows_all_data_and_b_goes_back(self):
        first = self.camera()
        display.drag(2, CENTER, (60, 30))
        self.key("r")
        reset = self.camera()
        np.testing.assert_allclose(np.add(reset["viewpoint"], reset["viewdirection"]), [0, 0, 0], atol=1e-6)
        self.assertAlmostEqual(self.turned(first, reset), 0, places=4)
        self.key("b")
        np.testing.assert_allclose(self.camera()["viewpoint"], first["viewpoint"], atol=1e-9)

    def test_axes(self):
        for key, axis in (("x", [1, 0, 0]), ("y", [0, 1, 0]), ("z", [0, 0, 1]), ("Z", [0, 0, -1])):
            self.key(key)
            camera = self.camera()
            np.testing.assert_allclose(np.divide(camera["viewdirection"], self.distance(camera)), axis, atol=1e-9)

    def test_spinning_goes_on_until_it_is_stopped(self):
        start = self.camera()
        self.key("s")
        until(lambda: self.turned(start, self.camera()) > 5, "it spins")
        self.key("s")
        stopped = self.camera()
        self.wait_for_picture(stopped)
        self.assertEqual(self.camera(), stopped)
        self.assertAlmostEqual(self.distance(stopped), self.distance(start), places=6)

    def test_what_is_saved_renders_to_the_picture_that_is_saved(self):
        display.drag(1, CENTER, (17, 23))
        self.wait_for_picture(self.camera())
        self.key("p")
        picture = server.folder / "view_00000.png"
        until(picture.exists, "the picture is saved")
        subprocess.run([PROGRAMS / "gxyrender", "view.json", "-o", "viewed"], cwd=server.folder, check=True,
                       stdout=subprocess.DEVNULL)
        subprocess.run([PROGRAMS / "gxydiff", "--alpha", picture, "viewed_00000.png"], cwd=server.folder, check=True)
        self.key("p")
        until((server.folder / "view_00001.png").exists, "a second picture gets a name of its own")

    def test_the_data_range_is_narrowed_moved_and_reset(self):
        def ranged(low, high):
            scene = copy.deepcopy(SCENE)
            scene["Visualization"]["operators"][0]["data range"] = [low, high]
            return scene

        self.key("minus")  # of 0 to 1.7
        self.camera()
        low, high = json.loads(self.saved.read_text())["Visualizations"][0]["operators"][0]["data range"]
        self.assertAlmostEqual(low, 0.17)
        self.assertAlmostEqual(high, 1.53)
        self.wait_for_picture(scene=ranged(low, high))
        self.key("bracketright")
        self.camera()
        low, high = json.loads(self.saved.read_text())["Visualizations"][0]["operators"][0]["data range"]
        self.assertAlmostEqual(low, 0.17 + 0.136)
        self.assertAlmostEqual(high, 1.53 + 0.136)
        self.wait_for_picture(scene=ranged(low, high))
        self.key("0")
        self.wait_for_picture()

    def test_i_tells_what_is_under_the_mouse(self):
        picture = self.picture(SCENE["Camera"])
        until(lambda: self.line_is_short(picture), "it rests")
        self.key("i")
        until(lambda: not self.line_is_short(picture), "the line says what there is")

    def test_help_is_shown_and_taken_away(self):
        plain = display.screen(WIDTH, HEIGHT)[:-STATUS_ROWS]
        self.key("h")
        until(lambda: not np.array_equal(display.screen(WIDTH, HEIGHT)[:-STATUS_ROWS], plain), "help is shown")
        self.key("h")
        until(lambda: np.array_equal(display.screen(WIDTH, HEIGHT)[:-STATUS_ROWS], plain), "help is gone")

    def test_q_ends_it_well(self):
        self.key("q")
        self.assertEqual(self.viewer.wait(30), 0)
        self.assertEqual(self.viewer.stderr.read(), "")


# The isosurface alone, in another colour; the same, from the other side.
OTHER = copy.deepcopy(SCENE)
OTHER["Visualization"]["operators"][0].update({"volume rendering": False, "colormap": "Inferno"})
OTHER["Camera"]["viewpoint"] = [-3, 2, -4]


class Several(ViewerCase):
    SCENE = {"Datasets": SCENE["Datasets"], "Renderer": SCENE["Renderer"],
             "Visualizations": [SCENE["Visualization"], OTHER["Visualization"]], "Cameras": [SCENE["Camera"], OTHER["Camera"]]}

    def test_keys_show_the_other_visualizations_and_cameras_of_the_file(self):
        self.key("v")
        self.wait_for_picture(scene=OTHER)
        self.key("c")
        self.wait_for_picture(OTHER["Camera"], scene=OTHER)
        self.key("V")
        self.wait_for_picture(OTHER["Camera"])
        self.key("C")
        self.wait_for_picture()

    def test_what_is_saved_has_all_of_them_and_the_camera_of_now(self):
        self.key("v")
        self.key("c")
        display.do("click", 4)
        self.wait_for_picture(self.camera(1), scene=OTHER)
        saved = json.loads(self.saved.read_text())
        self.assertEqual([v["operators"][0].get("volume rendering", False) for v in saved["Visualizations"]], [True, False])
        self.assertEqual([c["viewpoint"][2] > 0 for c in saved["Cameras"]], [True, False])
        np.testing.assert_allclose(saved["Cameras"][0]["viewpoint"], SCENE["Camera"]["viewpoint"])
        self.assertAlmostEqual(self.distance(saved["Cameras"][1]), math.dist((0, 0, 0), (3, 2, 4)) / 1.1 ** 2, places=6)


class Annotated(ViewerCase):
    PLAIN = False

    def wait_for_picture(self, camera=SCENE["Camera"], size=(WIDTH, HEIGHT), scene=SCENE):
        """A white legend stands over the picture, which is dark there."""
        until(lambda: self.viewer.poll() is not None or self.legend().any(), "the window shows a legend")

    @staticmethod
    def legend():
        return (display.screen(WIDTH, HEIGHT)[:, -WIDTH // 4:].min(axis=2) > 200).sum(axis=1) > 0

    def test_a_takes_what_is_drawn_over_the_picture_away_and_brings_it_back(self):
        self.key("a")
        ViewerCase.wait_for_picture(self)
        self.assertFalse(self.legend().any())
        self.key("a")
        self.wait_for_picture()

    def test_a_saved_picture_has_it(self):
        self.key("p")
        picture = server.folder / "view_00000.png"
        until(picture.exists, "the picture is saved")
        scene = {**SCENE, "Annotations": {"legend": True, "axes": True, "outline": True}}
        (server.folder / "annotated.json").write_text(json.dumps(scene))
        subprocess.run([PROGRAMS / "gxyrender", "annotated.json", "-o", "annotated"], cwd=server.folder, check=True,
                       stdout=subprocess.DEVNULL)
        subprocess.run([PROGRAMS / "gxydiff", picture, "annotated_00000.png", "--max", "0.012"], cwd=server.folder, check=True)


class Edited(ViewerCase):
    def write(self, text):
        temporary = server.folder / "scene.json.new"  # as editors do
        temporary.write_text(text)
        temporary.rename(server.folder / "scene.json")

    def test_the_file_is_shown_anew_when_it_changes_and_a_broken_one_is_told_of(self):
        display.drag(1, CENTER, (30, 10))
        here = self.camera()
        self.wait_for_picture(here)
        self.write(json.dumps({**OTHER, "Camera": SCENE["Camera"]}))
        self.wait_for_picture(here, scene=OTHER)
        picture = self.picture(here, scene=OTHER)
        until(lambda: self.line_is_short(picture), "the line is short")
        self.write("{")
        until(lambda: not self.line_is_short(picture), "the line says what is wrong")
        self.wait_for_picture(here, scene=OTHER)
        self.write(json.dumps(SCENE | {"Camera": OTHER["Camera"]}))
        self.wait_for_picture(OTHER["Camera"])
        picture = self.picture(OTHER["Camera"])
        until(lambda: self.line_is_short(picture), "nothing is wrong any more")


def load(array):
    client.request('import {"Datasets": [{"name": "balls", "type": "Volume", "filename": "balls.vti", '
                   f'"array": "{array}"}}]}}')


class Around(ViewerCase):
    def test_new_data_are_shown_by_themselves(self):
        before = display.screen(WIDTH, HEIGHT)[:-STATUS_ROWS]
        load("eightBalls")
        self.addCleanup(load, "oneBall")
        self.wait_for_picture(SCENE["Camera"])
        self.assertFalse(np.array_equal(display.screen(WIDTH, HEIGHT)[:-STATUS_ROWS], before))

    def test_a_window_of_another_size_is_filled(self):
        display.do("search", "--name", "gxyviewer", "windowsize", 420, 330)
        self.wait_for_picture(SCENE["Camera"], (420, 330))


def write_ball(name, middle, most=1.0):
    """A volume of 16^3 points on [-1, 1]^3, from 0 far from its middle, along x, to `most` there; as NAME.vol."""
    axis = np.linspace(-1, 1, 16)
    z, y, x = np.meshgrid(axis, axis, axis, indexing="ij")
    far = np.sqrt((x - middle) ** 2 + y ** 2 + z ** 2)
    values = np.clip(1 - far / 0.9, 0, None)
    (values * most / values.max()).astype("<f4").tofile(server.folder / f"{name}.raw")
    (server.folder / f"{name}.vol").write_text(f"float\n-1 -1 -1\n16 16 16\n{2 / 15} {2 / 15} {2 / 15}\n{name}.raw\n")


def drop_all_but_balls():
    for dataset in client.request("list")["datasets"]:
        if dataset["name"] != "balls":
            client.request("drop " + json.dumps(dataset["name"]))


class SeriesCase(ViewerCase):
    """Steps of which one cannot be read, and the last has greater values than the others."""
    FILES = "s_*.vol"

    def setUp(self):
        self.addCleanup(drop_all_but_balls)  # of a viewer that is killed
        write_ball("s_0", -0.4)
        write_ball("s_1", 0.4)
        (server.folder / "s_2.vol").write_text("half of a fi")
        write_ball("s_3", 0.2, most=2.0)
        (server.folder / "run.pvd").write_text(
            '<VTKFile type="Collection"><Collection><DataSet timestep="0" file="s_0.vol"/>'
            '<DataSet timestep="0.25" file="s_1.vol"/><DataSet timestep="0.75" file="s_3.vol"/></Collection></VTKFile>')
        self.saved = server.folder / "view.json"
        self.viewer = subprocess.Popen(
            [PROGRAMS / "gxyviewer", "-P", str(server.port), "--token-file", server.token, "--output", "view", "--passes", "1",
             "--size", f"{WIDTH}x{HEIGHT}", "--plain", self.FILES],
            cwd=server.folder, env=display.environment, stderr=subprocess.PIPE, text=True)
        self.addCleanup(self.end)
        display.do("mousemove", *CENTER)
        opened = lambda: self.viewer.poll() is not None or self.saved.exists() or self.key("w")  # noqa: E731
        until(opened, "the window is open")
        self.assertIsNone(self.viewer.poll(), "the viewer has ended")
        self.wait_for_step(0)

    def state(self):
        self.camera()
        return json.loads(self.saved.read_text())

    def alone(self, step, values=(0, 1)):
        """What another client is shown of the step's file alone, its colours over these values."""
        state = self.state()
        visualization = state["Visualizations"][0]
        visualization["operators"][0].update({"dataset": "alone", "data range": list(values)})
        dataset = state["Datasets"][0] | {"name": "alone", "filename": str(server.folder / f"s_{step}.vol")}
        client.request("import " + json.dumps({"Datasets": dataset}))
        return self.picture(state["Cameras"][0], scene={
            "Datasets": [], "Renderer": state["Renderer"], "Visualization": visualization})

    def shows(self, picture):
        return np.array_equal(display.screen(WIDTH, HEIGHT)[:-STATUS_ROWS], picture[:-STATUS_ROWS])

    def wait_for_step(self, step, values=(0, 1)):
        expected = self.alone(step, values)
        self.assertGreater(len(np.unique(expected)), self.LEVELS, "there is something to see")
        until(lambda: self.shows(expected), f"step {step} is shown")

    def file(self):
        return pathlib.Path(self.state()["Datasets"][0]["filename"]).name


class InTime(SeriesCase):
    def test_keys_go_through_the_steps_and_the_camera_stays(self):
        display.drag(1, CENTER, (30, 10))
        camera = self.camera()
        self.wait_for_step(0)
        first = display.screen(WIDTH, HEIGHT)[:-STATUS_ROWS]
        self.assertEqual(self.file(), "s_0.vol")
        self.key("period")
        self.wait_for_step(1)
        self.assertFalse(np.array_equal(display.screen(WIDTH, HEIGHT)[:-STATUS_ROWS], first))
        self.assertEqual(self.camera(), camera)
        self.assertEqual(self.file(), "s_1.vol", "a saved state has the step that is shown")
        self.key("comma")
        self.wait_for_step(0)

    def test_a_step_that_cannot_be_read_is_told_of_and_passed_by(self):
        self.key("period")
        self.wait_for_step(1)
        second = self.alone(1)
        until(lambda: self.line_is_short(second), "the line is short")
        self.key("period")
        until(lambda: not self.line_is_short(second), "the line says what is wrong")
        self.assertTrue(self.shows(second))
        self.assertEqual(self.file(), "s_1.vol")
        self.key("period")
        self.wait_for_step(3, values=(0, 2))

    def test_the_range_of_colours_is_widened_by_later_steps_and_never_narrowed(self):
        self.key("End")
        self.wait_for_step(3, values=(0, 2))
        self.key("Home")
        self.wait_for_step(0, values=(0, 2))
        self.key("greater")
        self.wait_for_step(3, values=(0, 2))
        self.key("less")
        self.wait_for_step(0, values=(0, 2))

    def test_of_keys_that_come_while_a_step_is_on_its_way_the_last_counts(self):
        self.viewer.send_signal(signal.SIGSTOP)
        for key in ("period", "End", "less", "period"):
            self.key(key)
        self.viewer.send_signal(signal.SIGCONT)
        self.wait_for_step(1)
        self.assertEqual(self.file(), "s_1.vol")

    def test_the_steps_are_this_windows_own_and_go_with_it(self):
        names = lambda: {dataset["name"] for dataset in client.request("list")["datasets"]}  # noqa: E731
        self.assertIn("s_*", names())
        before = client.request("info s_*")["datasets"][0]["file"]
        other = subprocess.Popen(
            [PROGRAMS / "gxyviewer", "-P", str(server.port), "--token-file", server.token, "--output", "view-other",
             "--size", f"{WIDTH}x{HEIGHT}", self.FILES], cwd=server.folder, env=display.environment)
        self.addCleanup(other.kill)
        until(lambda: "s_*-2" in names(), "another viewer has them, too")
        self.assertEqual(client.request("info s_*")["datasets"][0]["file"], before)
        self.key("q")
        until(lambda: self.viewer.poll() is not None or other.poll() is not None, "one of them ends")
        self.assertEqual(len({"s_*", "s_*-2"} & names()), 1, "its data are gone")


class InTimeOfACollection(SeriesCase):
    FILES = "run.pvd"

    def test_play_goes_to_the_last_step_and_pictures_have_the_time(self):
        self.key("space")
        self.wait_for_step(3, values=(0, 2))
        self.key("a")
        state = self.state()
        state["Visualizations"][0]["operators"][0]["data range"] = [0, 2]
        state["Renderer"]["rays per pixel"] = 1
        state["Cameras"][0]["dimensions"] = [WIDTH, HEIGHT]
        state["Annotations"] = {"legend": True, "axes": True, "outline": True, "text": "time 0.75"}
        (server.folder / "view-annotated.json").write_text(json.dumps(state))
        subprocess.run([PROGRAMS / "gxyrender", "view-annotated.json", "-o", "view-annotated"], cwd=server.folder, check=True,
                       stdout=subprocess.DEVNULL)
        saved = [server.folder / f"view_{number:05}.png" for number in range(1000)]

        def as_gxyrender_has_it():  # once the legend knows the range
            picture = saved.pop(0)
            self.key("p")
            until(picture.exists, "the picture is saved")
            return subprocess.run([PROGRAMS / "gxydiff", picture, "view-annotated_00000.png", "--max", "0.012"],
                                  cwd=server.folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL).returncode == 0

        until(as_gxyrender_has_it, "a saved picture is gxyrender's, with the time of its step")


class Refined(ViewerCase):
    PASSES = 5  # each wait is for the picture of five rays per pixel rendered at once

    def test_a_picture_at_rest_becomes_that_of_all_its_rays_to_the_bit(self):
        display.drag(1, CENTER, (30, 10))
        self.wait_for_picture(self.camera())


    def test_p_saves_all_passes_of_its_moment_while_the_camera_goes_on(self):
        self.viewer.send_signal(signal.SIGSTOP)  # so that no picture is made between these
        display.drag(1, CENTER, (30, 10))
        self.key("w")
        self.key("p")
        display.drag(1, CENTER, (-50, 20))
        self.viewer.send_signal(signal.SIGCONT)
        picture = server.folder / "view_00000.png"
        until(picture.exists, "the picture is saved")
        state = json.loads(self.saved.read_text())
        state["Renderer"]["rays per pixel"] = self.PASSES
        (server.folder / "view-at-p.json").write_text(json.dumps(state))
        subprocess.run([PROGRAMS / "gxyrender", "view-at-p.json", "-o", "viewed"], cwd=server.folder, check=True,
                       stdout=subprocess.DEVNULL)
        subprocess.run([PROGRAMS / "gxydiff", "--alpha", picture, "viewed_00000.png"], cwd=server.folder, check=True)
        now = self.camera()
        self.assertGreater(self.turned(state["Cameras"][0], now), 10)
        self.wait_for_picture(now)

    def test_q_ends_it_when_the_picture_is_saved(self):
        self.viewer.send_signal(signal.SIGSTOP)
        display.drag(1, CENTER, (30, 10))
        self.key("p")
        self.key("q")
        self.viewer.send_signal(signal.SIGCONT)
        self.assertEqual(self.viewer.wait(60), 0)
        self.assertTrue((server.folder / "view_00000.png").exists())


class AtRest(ViewerCase):
    PASSES, OPTIONS, LEVELS = 16, [], 13  # as many passes as there are by default
    # A flat white disc on black: a pixel is as bright as the part of its rays that meet it.
    SCENE = copy.deepcopy(SCENE)
    SCENE["Renderer"]["background"] = [0, 0, 0, 1]
    SCENE["Visualization"]["Lighting"] = {"Ka": 1, "Kd": 0, "shadows": False, "ao count": 0}
    SCENE["Visualization"]["operators"] = [{"type": "Volume", "dataset": "balls", "isovalues": [0.5], "data range": [0, 1],
                                            "colormap": [[0, 1, 1, 1], [1, 1, 1, 1]]}]

    def test_edges_are_antialiased_by_sixteen_rays_unless_it_is_told_otherwise(self):
        picture = display.screen(WIDTH, HEIGHT)[:-STATUS_ROWS]
        sixteenths = {round(255 * n / 16) for n in range(17)}
        levels, counts = np.unique(picture, return_counts=True)
        self.assertLessEqual(set(levels.tolist()), sixteenths)
        self.assertGreaterEqual(len(levels), 14, "of 17, nearly all occur along an edge")
        # The disc's area: a sphere of radius r at distance d is seen under the angle asin(r / d).
        pixel = 2 * math.tan(math.radians(15)) / min(WIDTH, HEIGHT)
        radius = math.tan(math.asin(0.5 / math.dist((0, 0, 0), (3, 2, 4)))) / pixel
        self.assertAlmostEqual(picture[..., 0].sum() / 255 / (math.pi * radius ** 2), 1, delta=0.01)


class Refining(ViewerCase):
    # Minutes of them, of occlusion, too: what is compared comes before.
    PASSES, SCENE = 4096, STATE

    def wait_for_picture(self, camera=STATE["Camera"], size=(WIDTH, HEIGHT), scene=STATE):
        window = client.window(1, size=size)
        window.set({key: value for key, value in scene.items() if key != "Camera"})
        expected = over_black(window.render(Camera=camera, rays=16).rgba)[:-STATUS_ROWS].astype(float)
        # However often it is refined, by less than a level; the other array's is tens of levels away.
        until(lambda: np.abs(display.screen(*size)[:-STATUS_ROWS] - expected).mean() < 3, "the data are shown")

    def test_new_data_are_shown_while_the_picture_is_refined(self):
        self.addCleanup(load, "oneBall")
        for array in ("eightBalls", "oneBall", "eightBalls"):
            load(array)
            self.wait_for_picture(STATE["Camera"])


class Lost(unittest.TestCase):
    def test_a_server_that_goes_is_told_of_and_the_status_is_1(self):
        other = Server(PROGRAMS, MPIEXEC, ranks=1)
        self.addCleanup(other.stop)
        (other.folder / "scene.json").write_text(json.dumps(SCENE))
        display.do("mousemove", *CENTER)
        viewer = subprocess.Popen([PROGRAMS / "gxyviewer", "-P", str(other.port), "--token-file", other.token, "scene.json"],
                                  cwd=other.folder, env=display.environment, stderr=subprocess.PIPE, text=True)
        self.addCleanup(viewer.kill)
        before = display.screen(WIDTH, HEIGHT)
        until(lambda: not np.array_equal(display.screen(WIDTH, HEIGHT), before), "the window is open")
        with gxy.client.Client(port=other.port, token_file=other.token) as administrator:
            administrator.request("quit")

        def quits():
            display.do("key", "q")
            return viewer.poll() is not None

        until(quits, "it ends")
        self.assertEqual(viewer.returncode, 1)
        self.assertIn("the connection has ended", viewer.communicate()[1])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)

# SPDX-License-Identifier: Apache-2.0
"""graph_test.py PROGRAMS MPIEXEC...: graphs, their nodes and views, from Python."""
import inspect
import json
import threading
import unittest

import numpy as np

from galaxy_case import OnRanks, gxy, main
from gxy.catalogue import Catalogue, argument, snake

CAMERA = {"viewpoint": [2.2, 2.6, 3.6], "viewcenter": [0, -0.1, 0], "viewup": [0, 1, 0], "aov": 38, "dimensions": [160, 120]}


class Graphs(OnRanks):
    def figure_1(self, name="fig1"):
        """Seeds on an isosurface, lines of the gradient through them, and slices of another field."""
        density, pressure = self.balls(), self.balls("oneBall")
        graph = self.session.graph(name)
        gradient = graph.derive(rho=density, expression="grad(rho)", name="gradient")
        seeds = graph.isosurface_sampler(density, isovalue=0.3, count=150, seed=1, name="seeds")
        lines = graph.stream_tracer(vectors=gradient, seeds=seeds, direction="both", length=0.6, minimum_speed=0.05, name="lines")
        view = graph.view(graph.particles(seeds, radius=0.02), graph.path_lines(lines, radius=0.008, colormap="Viridis"),
                          graph.volume(pressure, slices=[(0, 0, 1, -0.95), (0, 1, 0, -0.95)]), name="figure", camera=CAMERA)
        return graph, seeds, view

    def render_saved(self, view, datasets=("eightBalls", "oneBall")):
        """The name of the PNG file that gxyrender writes of the saved view, with files for what is live."""
        for name in datasets:
            view.graph[name]["array"] = name
        view.save(self.server.folder / "saved.json")
        self.run_here("gxyrender", "saved.json", "-o", "saved", *(word for name in datasets for word in ("--dataset", f"{name}=balls.vti")))
        return "saved_00000.png"

    def test_figure_1_is_the_picture_that_gxyrender_makes_of_the_saved_graph(self):
        graph, seeds, view = self.figure_1()
        graph.edit([{"set": ["Renderer"], "to": {"background": [0.02, 0.02, 0.04, 1], "rays per pixel": 1}}])
        first = view.render(passes=2)
        self.assertEqual((first.array.shape, first.array.dtype), ((120, 160, 4), np.uint8))
        self.assertEqual((first.end["passes"], first.end["revision"]), (2, graph.revision))
        self.assertEqual({node.state for node in graph.nodes if node.section != "Operators"}, {"done"})
        self.assertEqual(seeds.data.info["primitives"], 150)
        graph.edit([{"set": ["Renderer", "rays per pixel"], "to": 2}])
        file = self.render_saved(view)
        self.assert_same_picture(first, file)
        # An edit is seen in the next picture, and its inverse takes it back.
        reply = graph.edit([{"set": ["Datasets", "seeds", "isovalue"], "to": 0.5}])
        self.assertGreater(np.abs(view.render().array.astype(int) - first.array).max(), 50)
        graph.edit(reply["inverse"])
        np.testing.assert_array_equal(view.render().array, first.array)  # colours were of the wider range meanwhile
        # Another size and camera for one picture only.
        turned = view.render(size=(64, 48), camera={**CAMERA, "viewpoint": [-3, 1, 3]})
        self.assertEqual(turned.array.shape, (48, 64, 4))
        np.testing.assert_array_equal(view.render(camera={**CAMERA, "viewcenter": np.array(CAMERA["viewcenter"])}).array, first.array)
        np.testing.assert_array_equal(view.render().array, first.array)
        with self.assertRaisesRegex(gxy.GalaxyError, "cannot be rendered: .*passes"):
            view.render(passes=0)
        # What notebooks show.
        self.assertEqual(view._repr_png_(), first._repr_png_())
        self.assertEqual(first.png()[:8], b"\x89PNG\r\n\x1a\n")
        with self.assertRaisesRegex(gxy.GalaxyError, "a.jpg: expected a name that ends with .png"):
            first.save("a.jpg")

    def test_a_view_without_a_camera_shows_what_gxyrender_shows(self):
        graph = self.session.graph("g")
        view = graph.view(graph.volume(self.balls(), isovalues=[0.4], colormap="Viridis"), size=(90, 70))
        picture = view.render()
        self.assertEqual(picture.size, (90, 70))
        self.assert_same_picture(picture, self.render_saved(view, ["eightBalls"]))

    def test_looks_without_keys_go_with_the_range_of_the_data(self):
        self.session.put("far.f", 300 + np.linspace(0, 50, 24 ** 3).reshape(24, 24, 24), origin=(-1, -1, -1), spacing=2 / 23)
        graph = self.session.graph("g")
        far = self.session["far.f"]
        points = graph.seeds(far, count=20, shape="box")
        looks = [graph.volume(far, colormap="Viridis"), graph.particles(points), graph.volume(far, isovalues=[330]),
                 graph.volume(far, opacitymap=[[300, 0], [350, 1]], volume_rendering=True)]
        self.assertEqual([look.entry.get("data range") for look in looks], ["data", "data", "data", None])
        self.assertEqual([look.entry.get("radius") for look in looks], [None, "auto", None, None])
        pictures = [graph.view(look, size=(40, 30)).render().array for look in looks]
        # What is rendered is neither invisible nor opaque, and has several colours.
        seen = pictures[0][..., :3].reshape(-1, 3)
        self.assertGreater(len(np.unique(seen, axis=0)), 50)
        for picture in pictures:
            self.assertGreater(np.ptp(picture[..., :3]), 30)

    def test_keys_of_looks_that_are_none_are_not_said(self):
        graph = self.session.graph("g")
        data = self.balls()
        points = graph.seeds(data, count=20, shape="box")
        looks = [graph.volume(data, volume_rendering=None, data_range=None), graph.particles(points, radius=None, data_range=None),
                 graph.volume(data, isovalues=[0.4], data_range=None, colormap="Viridis")]
        said = [{key: value for key, value in look.entry.items() if key not in ("name", "type", "dataset")} for look in looks]
        self.assertEqual(said, [{}, {}, {"isovalues": [0.4], "colormap": "Viridis"}])

    def test_files_are_read_for_the_graph_alone(self):
        graph = self.session.graph("g")
        ball = graph.file("balls.vti", "Volume", array="oneBall")
        self.assertEqual((ball.name, ball.section), ("balls", "Datasets"))
        self.assertEqual(ball.entry, {"name": "balls", "type": "Volume", "filename": "balls.vti", "array": "oneBall"})
        look = graph.volume(ball, isovalues=[0.5], colormap="Viridis", data_range=[0, 1.7])
        picture = graph.view(look, camera=CAMERA, size=(90, 70)).render()
        self.assertEqual(self.session.data, [])
        data = self.session.open("balls.vti", array="oneBall")
        other = graph.volume(data, isovalues=[0.5], colormap="Viridis", data_range=[0, 1.7])
        np.testing.assert_array_equal(graph.view(other, camera=CAMERA, size=(90, 70)).render().array, picture.array)
        with self.assertRaisesRegex(gxy.GalaxyError, "a dataset of a file has no 'arrays', expected one of: array, "):
            graph.file("balls.vti", "Volume", arrays="oneBall")

    def test_a_camera_that_is_set_is_everybodys(self):
        graph, _, view = self.figure_1()
        before = view.render().array
        with self.connect() as other:
            other.graph("fig1")["figure"].camera = {**CAMERA, "viewpoint": [-3, 1, 3]}
            after = view.render().array
            self.assertGreater(np.abs(after.astype(int) - before).max(), 50)
            np.testing.assert_array_equal(other.graph("fig1")["figure"].render().array, after)
        self.assertEqual(view.camera["viewpoint"], [-3, 1, 3])
        view.camera = None
        self.assertNotIn("camera", view.entry)

    def test_properties_are_read_and_set_as_attributes(self):
        graph, seeds, view = self.figure_1()
        lines = graph["lines"]
        self.assertEqual((seeds.isovalue, seeds.count, seeds.gradient, seeds.component), (0.3, 150, False, None))
        self.assertEqual((lines.minimum_speed, lines["minimum speed"], lines.vectors), (0.05, 0.05, "gradient"))
        lines.minimum_speed = 0.25
        lines["length"] = np.float32(0.5)
        seeds.count = None  # its default
        self.assertEqual((lines.entry["minimum speed"], lines.length, seeds.count), (0.25, 0.5, 10000))
        self.assertNotIn("count", seeds.entry)
        other = graph.seeds(self.session["eightBalls"], shape="line", from_=[-1, 0, 0], to=(1, 0, 0), count=4)
        self.assertEqual((other.name, other.from_, other.domain), ("seeds_2", [-1, 0, 0], "eightBalls"))
        lines.seeds = other
        self.assertEqual(lines.entry["inputs"], {"vectors": "gradient", "seeds": "seeds_2"})
        self.assertEqual(graph["particles"].radius, 0.02)
        graph["particles"].radius = 0.03
        self.assertEqual(graph["particles"].entry["radius"], 0.03)
        view.size = (32, 24)
        self.assertEqual(view.render().size, (32, 24))

    def test_an_input_and_a_property_of_one_name_are_told_apart(self):
        graph, seeds, _ = self.figure_1()
        lines = graph.stream_tracer(graph["gradient"], seeds, fields=[self.session["oneBall"]], inputs={"field": "oneBall"}, name="more")
        self.assertEqual(lines.entry["inputs"], {"vectors": "gradient", "seeds": "seeds", "fields": ["oneBall"], "field": "oneBall"})
        lines.fields = ["speed"]
        self.assertEqual((lines.entry["fields"], lines.entry["inputs"]["fields"]), (["speed"], ["oneBall"]))
        self.assertIn("oneBall", lines.wait(60).data.fetch()["fields"])

    def test_a_node_of_a_name_that_is_there_is_replaced(self):
        graph, seeds, _ = self.figure_1()
        count = len(graph.nodes)
        graph.isosurface_sampler(self.session["eightBalls"], isovalue=0.4, count=20, name="seeds")
        self.assertEqual((len(graph.nodes), seeds.isovalue, seeds.wait(60).data.info["primitives"]), (count, 0.4, 20))

    def test_edits_are_one_revision_or_none(self):
        graph, seeds, view = self.figure_1()
        before, document = graph.revision, graph.document
        with graph.edits() as reply:
            seeds.isovalue = 0.4
            fewer = graph.seeds(self.session["eightBalls"], count=5, shape="line")
            fewer.count = 6
            graph.particles(fewer)
            graph.view("particles_2", name="second")
            self.assertEqual(graph.revision, before)
        self.assertEqual((graph.revision, reply["revision"], fewer.count), (before + 1, before + 1, 6))
        self.assertEqual(graph["second"].operators, ["particles_2"])
        graph.edit(reply["inverse"])
        self.assertEqual(graph.document, document)
        with self.assertRaises(ZeroDivisionError), graph.edits():
            seeds.isovalue = 0.5
            1 / 0
        with self.assertRaisesRegex(gxy.GalaxyError, "`count`: expected an integer 1 to"), graph.edits():
            seeds.isovalue = 0.5
            seeds.count = -1
        self.assertEqual(graph.document, document)

    def test_waiting_for_a_node_has_it_made(self):
        graph = self.session.graph("g")
        sampler = graph.isosurface_sampler(self.balls("oneBall"), isovalue=0.5, count=500)
        self.assertEqual((sampler.state, sampler.error), ("waiting", None))
        self.assertIs(sampler.wait(60), sampler)
        self.assertEqual(sampler.state, "done")
        points = sampler.data.fetch()["structure"]["points"]
        radii = np.linalg.norm(points, axis=1)
        self.assertEqual(points.shape, (500, 3))
        self.assertLess(np.ptp(radii), 0.05)  # the field is the distance from the middle, up to the grid's steps
        self.assertAlmostEqual(sampler.told["area"], 4 * np.pi * np.mean(radii) ** 2, delta=5 * sampler.told["area error"])
        sampler.isovalue = 0.6
        self.assertNotEqual(sampler.state, "done")
        self.assertEqual(sampler.wait(60).state, "done")
        self.assertEqual(sampler.status["generation"], 2)
        self.assertGreater(np.linalg.norm(sampler.data.fetch()["structure"]["points"], axis=1).min(), np.max(radii))

    def test_what_fails_is_told_at_the_node_that_fails(self):
        graph, seeds, view = self.figure_1()
        self.session.put("coarse.f", np.zeros((4, 5, 6)))
        graph["gradient"].expression = "rho + f"
        graph["gradient"]["inputs"] = {"rho": "eightBalls", "f": "coarse.f"}
        graph.live("coarse.f")
        with self.assertRaisesRegex(gxy.GalaxyError, 'dataset "gradient" is failed: .*Resample') as raised:
            view.render(timeout=60)
        self.assertEqual((raised.exception.node, raised.exception.path), ("gradient", ["Datasets", "gradient"]))
        self.assertEqual(graph["gradient"].state, "failed")
        self.assertIn("Resample", graph["gradient"].error)
        self.assertEqual(seeds.error, None)
        with self.assertRaises(gxy.GalaxyError) as raised:
            graph["lines"].wait(60)
        self.assertEqual(raised.exception.node, "gradient")
        graph["gradient"]["inputs"] = {"rho": "eightBalls"}
        graph["gradient"].expression = "grad(rho)"
        view.render(timeout=60)

    def test_what_is_missing_is_told(self):
        graph, seeds, view = self.figure_1()
        graph["gradient"].remove()
        self.assertEqual(graph["lines"].state, "incomplete")
        self.assertIn("gradient", graph["lines"].error)
        with self.assertRaises(gxy.GalaxyError) as raised:
            view.render()
        self.assertEqual(raised.exception.node, "lines")

    def test_wrong_values_are_errors_with_node_and_path_and_change_nothing(self):
        graph, seeds, view = self.figure_1()
        document = graph.document
        with self.assertRaisesRegex(gxy.GalaxyError, "expected an integer 1 to 1073741824, found -3") as raised:
            seeds.count = -3
        self.assertEqual((raised.exception.node, raised.exception.path), ("seeds", ["Datasets", "seeds", "count"]))
        with self.assertRaisesRegex(gxy.GalaxyError, "expected a number"):
            seeds.isovalue = "high"
        with self.assertRaisesRegex(gxy.GalaxyError, "expected Volume .*found \"seeds\", which is Particles") as raised:
            graph.isosurface_sampler(seeds, isovalue=1)
        self.assertEqual(raised.exception.node, "isosurface_sampler")
        with self.assertRaisesRegex(gxy.GalaxyError, r"expected \[a, b, c, d\]") as raised:
            graph.volume(self.session["oneBall"], slices=[(1, 0, 0)])
        self.assertEqual(raised.exception.path, ["Operators", "volume_2", "slices", 0])
        with self.assertRaisesRegex(gxy.GalaxyError, "no cycle"):
            graph["gradient"].rho = graph["gradient"]
        for wrong in (float("nan"), object(), {1, 2}):
            with self.assertRaisesRegex(gxy.GalaxyError, "expected what JSON has"):
                seeds.isovalue = wrong
        self.assertEqual(graph.document, document)

    def test_calls_that_the_catalogue_does_not_know_are_errors_before_anything_is_sent(self):
        graph, seeds, view = self.figure_1()
        revision, density = graph.revision, self.session["eightBalls"]
        with self.assertRaisesRegex(AttributeError, "no filter 'no_such_filter', expected one of: .*stream_tracer"):
            graph.no_such_filter(density)
        with self.assertRaisesRegex(gxy.GalaxyError, "filter IsosurfaceSampler has no 'isovalu', expected one of: .*isovalue"):
            graph.isosurface_sampler(density, isovalu=1)
        with self.assertRaisesRegex(gxy.GalaxyError, r"isosurface_sampler\(\): `field`, `isovalue` missing"):
            graph.isosurface_sampler()
        with self.assertRaisesRegex(gxy.GalaxyError, "3 inputs without a name, expected at most 2"):
            graph.isosurface_sampler(density, density, density, isovalue=1)
        with self.assertRaisesRegex(gxy.GalaxyError, "input `field` is given twice"):
            graph.isosurface_sampler(density, field=density, isovalue=1)
        with self.assertRaisesRegex(gxy.GalaxyError, "filter IsosurfaceSampler has no 'isovalu'"):
            seeds.isovalu = 3
        with self.assertRaisesRegex(AttributeError, "filter IsosurfaceSampler has no 'isovalu'"):
            seeds.isovalu
        with self.assertRaisesRegex(gxy.GalaxyError, "expected a node, a dataset of the session, or a name"):
            graph.particles(7)
        with self.assertRaisesRegex(gxy.GalaxyError, "found <Node .*seeds.*, expected a look of graph"):
            graph.view(seeds)
        with self.assertRaisesRegex(gxy.GalaxyError, "of graph \"other\", expected one of \"fig1\""):
            graph.particles(self.session.graph("other").seeds(density))
        with self.assertRaisesRegex(gxy.GalaxyError, 'no node "nothing", expected one of .*seeds'):
            graph["nothing"]
        self.assertEqual(graph.revision, revision)

    def test_every_filter_is_a_method_that_describes_itself(self):
        graph = self.session.graph("g")
        filters = self.session.catalogue.filters
        self.assertLessEqual({"isosurface_sampler", "stream_tracer", "derive", "seeds", "statistics"}, set(filters))
        for name, filter in filters.items():
            self.assertNotIn(name, vars(gxy.Graph), "a method of graphs hides it")
            for argument in [*filter.keys.key_of, *(port["name"] for port in filter.inputs)]:
                self.assertFalse(hasattr(gxy.Node, argument), f"{name}: {argument} is something else of nodes")
            method = getattr(graph, name)
            self.assertEqual(method.__name__, name)
            for text in (filter.help, *(key["help"] for key in filter.keys.properties), *(port["help"] for port in filter.inputs)):
                self.assertIn(text, method.__doc__)
            self.assertLessEqual(set(filter.keys.key_of) | {"name"}, set(inspect.signature(method).parameters))
            self.assertIn(name, dir(graph))
        count = inspect.signature(graph.isosurface_sampler).parameters["count"]
        self.assertEqual((count.default, count.kind), (10000, inspect.Parameter.KEYWORD_ONLY))

    def test_two_clients_edit_one_graph(self):
        graph, seeds, _ = self.figure_1()
        first = graph.revision
        edits, events = 60, []
        seen = threading.Event()

        def hear(event):
            events.append(event)
            if event["revision"] == first + 2 * edits:
                seen.set()

        self.session.on(hear, "graph")
        with self.connect(name="second") as other:
            def work(session, key):
                mine = session.graph("fig1")
                for number in range(edits):
                    if number % 3 == 0:
                        mine.seeds("eightBalls", count=number + 1)
                    else:
                        setattr(mine["seeds"], key, number + 1)

            threads = [threading.Thread(target=work, args=arguments) for arguments in ((self.session, "count"), (other, "seed"))]
            for thread in threads:
                thread.start()
            for thread in threads:
                thread.join()
            self.assertEqual(graph.document, other.graph("fig1").document)
            self.assertEqual(graph.revision, first + 2 * edits)
        self.assertTrue(seen.wait(20))
        self.assertEqual([event["revision"] for event in events], list(range(first + 1, first + 2 * edits + 1)))
        self.assertEqual({event["by"]["client"] for event in events}, {"gxy", "second"})
        self.assertEqual((seeds.count, seeds.seed), (60, 60))
        self.assertEqual(sum(node.name.startswith("seeds") for node in graph), 1 + 2 * edits // 3)

    def test_graphs_are_saved_and_loaded(self):
        graph, seeds, view = self.figure_1()
        picture, file = view.render().array, self.server.folder / "again.json"
        graph.save(file)
        other = self.session.load(file)
        self.assertEqual((other.name, other.document), ("again", graph.document))
        np.testing.assert_array_equal(other["figure"].render().array, picture)
        other["seeds"].count = 10
        self.session.load(file)  # the graph that is there gets the document
        self.assertEqual(other.document, graph.document)
        np.testing.assert_array_equal(other["figure"].render().array, picture)
        self.assertEqual(set(self.session.graphs), {"fig1", "again"})
        file.write_text("{")
        with self.assertRaisesRegex(gxy.GalaxyError, "again.json: "):
            self.session.load(file)
        file.write_text(json.dumps({"Datasets": [{"name": "a", "filter": "Seeds", "count": 0}]}))
        with self.assertRaises(gxy.GalaxyError) as raised:
            self.session.load(file, "wrong")
        self.assertEqual((raised.exception.node, raised.exception.path), ("a", ["Datasets", "a", "count"]))
        self.assertNotIn("wrong", self.session.graphs)

    def test_a_view_of_a_graph_that_was_made_anew_is_the_new_one(self):
        graph, _, view = self.figure_1()
        picture = view.render().array
        graph.drop()
        graph = self.session.graph("fig1")
        self.assertEqual(graph.nodes, [])
        anew = graph.view(graph.volume(self.session["oneBall"], isovalues=[0.8]), name="figure", camera=CAMERA)
        self.assertGreater(np.abs(anew.render().array.astype(int) - picture).max(), 50)
        anew.rename("other")
        self.assertEqual((anew.name, anew.render().size), ("other", (160, 120)))

    def test_windows_are_closed_with_their_views(self):
        graph, _, view = self.figure_1()
        for _ in range(20):  # more than a session may have at once
            view.render(size=(16, 12), camera=CAMERA)
            view.close()
        view.close()
        self.assertEqual(self.session.ask("viewer.windows")["windows"], [])
        self.assertEqual(graph["lines"].state, "done")
        graph["lines"].length = 0.5
        self.assertEqual(graph["lines"].status["text"], "nothing needs it")

    def test_paused_graphs_render_nothing_that_is_older(self):
        graph, seeds, view = self.figure_1()
        view.render()
        graph.pause()
        seeds.isovalue = 0.4
        with self.assertRaisesRegex(gxy.GalaxyError, "is (waiting|stale): paused"):
            view.render()
        graph.run()
        self.assertEqual(view.render().end["revision"], graph.revision)
        graph.resume()
        seeds.isovalue = 0.3
        self.assertEqual(view.render().end["revision"], graph.revision)

    def test_futures_give_what_the_methods_give(self):
        before = threading.enumerate()
        with self.connect() as session:
            graph, _, view = self.figure_1()
            view = session.graph("fig1")["figure"]
            pictures = [view.render_async(size=(40, 30)), view.render_async(size=(20, 15))]
            self.assertEqual([picture.result(60).size for picture in pictures], [(40, 30), (20, 15)])
            self.assertEqual(session.graph("fig1")["seeds"].wait_async(60).result(60).state, "done")
            with self.assertRaisesRegex(gxy.GalaxyError, "expected an integer"):
                session.graph("fig1")["figure"].render_async(passes=0).result(60)
            never = session.wait_async("nothing")
        with self.assertRaisesRegex(gxy.GalaxyError, "connection has ended"):
            never.result(20)
        self.assert_no_thread_left(before)

    def test_outputs_are_made(self):
        graph, seeds, _ = self.figure_1()
        output = graph.output("Publish", seeds, "points")
        self.session.wait("points", timeout=60)
        self.assertEqual(self.session["points"].type, "Particles")
        self.assertEqual(output.wait(60).state, "done")


class Catalogues(unittest.TestCase):
    """What is made of a description; one that tells the keys of looks, too."""

    TOLD = {"filters": [], "sections": [
        {"section": "operator", "keys": [
            {"key": "type", "required": True, "type": "text", "default": "", "help": ""},
            {"key": "two sided", "required": False, "type": "true or false", "default": "`true`", "help": ""},
            {"key": "isovalues", "required": False, "type": "list of numbers", "default": "none", "help": "", "types": ["Volume"]},
            {"key": "colormap", "aliases": ["transfer function"], "required": False, "type": "text", "default": "", "help": ""}]},
        {"section": "visualization", "keys": [{"key": "Lighting", "required": False, "type": "lighting", "default": "-", "help": ""}]}]}

    def test_keys_of_looks_and_views_are_checked_where_the_server_tells_them(self):
        catalogue = Catalogue(self.TOLD)
        volume, lines = catalogue.look("Volume"), catalogue.look("PathLines")
        self.assertEqual([volume.key(name) for name in ("isovalues", "two_sided", "transfer_function")], ["isovalues", "two sided", "colormap"])
        self.assertEqual((volume.default("two sided"), volume.default("isovalues")), (True, None))
        with self.assertRaisesRegex(gxy.GalaxyError, "a look of type PathLines has no 'isovalues', expected one of: colormap, transfer_"):
            lines.key("isovalues")
        self.assertEqual([catalogue.view().key(name) for name in ("Lighting", "follow")], ["Lighting", "follow"])
        with self.assertRaisesRegex(gxy.GalaxyError, "a view has no 'colour', expected one of: Lighting, camera"):
            catalogue.view().key("colour")

    def test_without_a_description_any_key_is_taken(self):
        catalogue = Catalogue({"filters": []})
        self.assertEqual([catalogue.look("Volume").key(name) for name in ("data_range", "isovalues")], ["data range", "isovalues"])

    def test_names_are_those_of_python(self):
        self.assertEqual([snake(name) for name in ("IsosurfaceSampler", "PathLines", "Derive")], ["isosurface_sampler", "path_lines", "derive"])
        self.assertEqual([argument(key) for key in ("minimum speed", "from", "count")], ["minimum_speed", "from_", "count"])


class OnOneRank(Graphs, unittest.TestCase):
    ranks = 1


class OnThreeRanks(Graphs, unittest.TestCase):
    ranks = 3


if __name__ == "__main__":
    main()

# SPDX-License-Identifier: Apache-2.0
"""python_test.py VERSION: gxy.insitu against the library and without a server, which the loader finds in LD_LIBRARY_PATH."""
import gc
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest
import weakref

import numpy as np

PACKAGE = pathlib.Path(__file__).resolve().parents[3] / "python" / "src"
VERSION = sys.argv.pop(1)
sys.path.insert(0, str(PACKAGE))
import gxy  # noqa: E402
from gxy.insitu import Result, Simulation  # noqa: E402

SIZE = (6, 5, 4)  # x, y, z
NOWHERE = {"to": "127.0.0.1:1", "token_file": "-"}


class Communicator:
    """What mpi4py's communicators have."""

    def __init__(self, rank, size):
        self._rank, self._size = rank, size

    def Get_rank(self):
        return self._rank

    def Get_size(self):
        return self._size


def described(array, order="zyx", count=SIZE):
    """The gxy_array that an array becomes."""
    return Simulation._described(array, order, count, "points")[0]


class Opening(unittest.TestCase):
    def test_it_is_off_unless_it_is_said_where_to(self):
        with Simulation("heat") as sim:
            sim.grid(SIZE)
            sim.field("t", np.zeros(SIZE[::-1]))
            self.assertEqual([sim.publish(step, step / 2) for step in (1, 2)], [Result.OFF, Result.OFF])
            self.assertEqual(sim.publish_last(3, 1.5), Result.OFF)
            self.assertEqual(sim.message(), "")

    def test_ranks_come_from_numbers_or_from_any_communicator(self):
        Simulation("heat", 1, 3).close()
        Simulation("heat", np.int32(1), ranks=np.int64(3)).close()
        Simulation("heat", Communicator(2, 3)).close()
        for arguments, words in (((3, 3), "rank 3 of 3"), ((-1, 3), "rank -1 of 3"), ((1,), "expected a communicator"),
                                 ((None, 3), "expected a communicator"), (("a", 3), "rank: found 'a'"),
                                 ((Communicator(0, 2), 2), "beside a communicator"), ((0, 1.5), "ranks: found 1.5")):
            with self.assertRaisesRegex(ValueError, words):
                Simulation("heat", *arguments)

    def test_wrong_names_and_options_are_told(self):
        for name in ("", "\0", None, 5, "a" * 1000):
            with self.assertRaises(ValueError):
                Simulation(name)
        for options, words in (({"two": 1}, "there is no option \"two\""), ({"to": "nowhere"}, "expected \"off\", \"here\" or HOST:PORT"), ({"to": "here"}, "no server runs in this program"),
                               ({"every": 0}, "option \"every\""), ({"token_file": 5}, "option \"token-file\""),
                               ({"to": b"off"}, "expected what JSON has")):
            with self.assertRaisesRegex(ValueError, words):
                Simulation("heat", **options)

    def test_without_a_server_the_simulation_runs_on(self):
        with Simulation("heat", **NOWHERE) as sim:
            sim.grid(SIZE)
            sim.field("t", np.zeros(SIZE[::-1]))
            for step in range(1, 101):
                self.assertEqual(sim.publish(step, 0), Result.LOST)
            with self.assertRaisesRegex(ValueError, "expected steps that ascend"):
                sim.publish(100, 0)
            statistics = sim.statistics()
            self.assertEqual((statistics.offered, statistics.taken, statistics.bytes), (100, 0, 0))
            self.assertGreaterEqual(statistics.publish_seconds, statistics.longest_seconds)


    def test_steps_are_asked_for_skipped_and_steered(self):
        with Simulation("heat", steerable=[{"name": "dt", "least": 0, "largest": 1}], **NOWHERE) as sim:
            sim.grid(SIZE)
            sim.field("t", np.zeros(SIZE[::-1]))
            self.assertEqual(sim.skip(1, 0.5), Result.LOST)
            self.assertIs(sim.wanted(2, 1), False)
            sim.settle(2, True)
            with self.assertRaisesRegex(ValueError, "expected the same step and time"):
                sim.publish(3, 1)
            self.assertEqual(sim.publish(2, 1), Result.LOST)
            self.assertIsNone(sim.steered("dt"))
            with self.assertRaisesRegex(ValueError, "expected one of the option \"steerable\""):
                sim.steered("dx")

    def test_nothing_follows_the_last_step(self):
        with Simulation("heat", **NOWHERE) as sim:
            sim.grid(SIZE)
            sim.field("t", np.zeros(SIZE[::-1]))
            for step, time, words in ((1.5, 0, "step: found 1.5"), (1, "now", "time: found 'now'")):
                for publish in (sim.publish, sim.publish_last):
                    with self.assertRaisesRegex(ValueError, words):
                        publish(step, time)
            if sim.publish_last(1, 0) == Result.TAKEN:  # there is no connection yet, and not yet a reason why
                with self.assertRaisesRegex(ValueError, "expected nothing but gxy_close"):
                    sim.publish(2, 0)
            sim.close(0)


class Grids(unittest.TestCase):
    def setUp(self):
        self.sim = Simulation("heat", **NOWHERE)
        self.addCleanup(self.sim.close)

    def wrong(self, words, *arguments, **more):
        with self.assertRaisesRegex(ValueError, words):
            self.sim.grid(*arguments, **more)

    def test_wrong_grids_are_told(self):
        self.wrong("size: found 5, expected three integers", 5)
        self.wrong("size: found .*, expected three integers", (6, 5))
        self.wrong("first: found .*, expected three integers", SIZE, (0, 0, 0.5))
        self.wrong("count: found .*, expected three integers", SIZE, (0, 0, 0), (2**63, 1, 1))
        self.wrong("spacing: found .*, expected three numbers", SIZE, spacing=("a", 1, 1))
        self.wrong("expected a block inside the grid", SIZE, (0, 0, 0), (6, 5, -1))
        self.wrong("of: found 'faces'", SIZE, of="faces")
        self.wrong("block: found -1", SIZE, block=-1)
        self.wrong("mesh: found 5", SIZE, mesh=5)
        self.sim.grid(SIZE)
        self.wrong("expected the same in all blocks", SIZE, origin=(0, 0, 1))
        self.sim.grid((3, 3, 3), mesh="other")

    def test_a_rank_may_own_nothing_or_several_blocks(self):
        self.sim.grid(np.array(SIZE), (0, 0, 0), (0, 0, 0))
        self.sim.field("t", np.empty((0, 0, 0), np.float32))
        self.sim.grid(SIZE, (0, 0, 1), (6, 5, 2), block=1)
        self.sim.field("t", np.zeros((2, 5, 6), np.float32), block=1)
        self.assertEqual(self.sim.publish(1, 0), Result.LOST)

    def test_after_close_everything_is_wrong(self):
        self.sim.close()
        self.sim.close()
        for call in (lambda: self.sim.grid(SIZE), lambda: self.sim.publish(1, 0), self.sim.statistics, self.sim.message):
            with self.assertRaisesRegex(ValueError, "the stream is closed"):
                call()


class Fields(unittest.TestCase):
    def setUp(self):
        self.sim = Simulation("heat")
        self.addCleanup(self.sim.close)
        self.sim.grid(SIZE)

    def wrong(self, words, array, **more):
        with self.assertRaisesRegex(ValueError, words):
            self.sim.field("t", array, **more)

    def test_wrong_types_are_told(self):
        for dtype in (bool, np.float16, np.longdouble, complex, "S1", object, ">f8" if sys.byteorder == "little" else "<f8",
                      [("a", "f4")], "datetime64[s]"):
            self.wrong("field 't': dtype .*, expected integers of 8 to 64 bits", np.zeros(SIZE[::-1], dtype))
        for array in ([[[1.0]]], 5, None, memoryview(b"a")):
            self.wrong("expected a NumPy array", array)

    def test_wrong_shapes_are_told(self):
        for shape in (SIZE, (4, 5), (4, 5, 7), (1, 4, 5, 6), ()):
            self.wrong(r"shape \(.*\), expected \(4, 5, 6\) for order 'zyx'", np.zeros(shape))
        self.wrong(r"expected \(6, 5, 4\) for order 'xyz'", np.zeros((4, 5, 6)), order="xyz")
        self.wrong("order: found 'yxz'", np.zeros((4, 5, 6)), order="yxz")
        self.wrong("17 components, expected 1 to 16", np.zeros((4, 5, 6, 17)))
        self.wrong("0 components", np.zeros((4, 5, 6, 0)))
        self.wrong("there is no block 1 of mesh 'grid'", np.zeros((4, 5, 6)), block=1)
        self.wrong("there is no block 0 of mesh 'other'", np.zeros((4, 5, 6)), mesh="other")
        self.wrong("stride.0. is 0", np.broadcast_to(np.zeros((4, 5, 1)), (4, 5, 6)))
        self.wrong("components without memory of their own", np.broadcast_to(np.zeros((4, 5, 6, 1)), (4, 5, 6, 3)))

    def test_a_name_that_is_none_is_told(self):
        for name in ("", 5, "a\0b"):
            with self.assertRaises(ValueError):
                self.sim.field(name, np.zeros((4, 5, 6)))

    def test_all_types_have_their_numbers(self):
        names = "int8 uint8 int16 uint16 int32 uint32 int64 uint64 float32 float64".split()
        self.assertEqual([described(np.zeros((4, 5, 6), name)).type for name in names], list(range(10)))
        self.assertEqual(described(np.zeros((4, 5, 6), np.longlong)).type, 6)

    def test_strides_are_those_of_the_view_by_axis_x_y_z(self):
        whole = np.zeros((6, 7, 8))
        inner = described(whole[1:-1, 1:-1, 1:-1])
        self.assertEqual(list(inner.stride), [8, 64, 448])
        self.assertEqual(inner.data, whole.ctypes.data + 8 * (1 + 8 * (1 + 7)))
        backwards = whole[4:0:-1, 1:-1, 6:0:-1]
        self.assertEqual(list(described(backwards).stride), [-8, 64, -448])
        self.assertEqual(described(backwards).data, whole[4, 1, 6:].ctypes.data)
        xyz = np.zeros(SIZE, np.float32)
        self.assertEqual(list(described(xyz, "xyz").stride), [80, 16, 4])
        self.assertEqual(list(described(np.asfortranarray(xyz), "xyz").stride), [4, 24, 120])

    def test_components_are_the_last_axis(self):
        together = described(np.zeros((4, 5, 6, 3), np.float32))
        self.assertEqual((together.components, together.component_stride, list(together.stride)), (3, 4, [12, 72, 360]))
        apart = described(np.moveaxis(np.zeros((3, 4, 5, 6), np.float32), 0, -1))
        self.assertEqual((apart.components, apart.component_stride, list(apart.stride)), (3, 480, [4, 24, 120]))
        self.assertEqual(described(np.zeros((4, 5, 6, 1))).components, 1)

    def test_arrays_live_as_long_as_they_are_read(self):
        array = np.zeros((4, 5, 6))
        alive = weakref.ref(array)
        self.sim.field("t", array)
        del array
        gc.collect()
        self.assertIsNotNone(alive())
        self.sim.field("t", np.ones((4, 5, 6)))
        gc.collect()
        self.assertIsNone(alive())

    def test_arrays_of_a_block_that_has_changed_are_let_go(self):
        array = np.zeros((4, 5, 6))
        alive = weakref.ref(array)
        self.sim.field("t", array)
        del array
        self.sim.publish(1, 0.5)
        self.sim.grid((6, 5, 4), count=(3, 5, 4))
        gc.collect()
        self.assertIsNone(alive())
        self.sim.field("t", np.ones((4, 5, 3)))
        self.sim.publish(2, 1)


class Particles(unittest.TestCase):
    def setUp(self):
        self.sim = Simulation("cloud", **NOWHERE)
        self.addCleanup(self.sim.close)
        self.positions, self.ids = np.zeros((5, 3)), np.arange(5)

    def wrong(self, words, *arguments, **more):
        with self.assertRaisesRegex(ValueError, words):
            self.sim.points("atoms", *arguments, **more)

    def test_wrong_particles_are_told(self):
        self.wrong("positions: found list", [[0, 0, 0]])
        self.wrong("positions: 2 components, expected 3", np.zeros((5, 2)))
        self.wrong("positions: 1 components, expected 3", np.zeros(5))
        self.wrong(r"positions: shape \(5, 3, 1\), expected \(5,\) or", np.zeros((5, 3, 1)))
        self.wrong("expected float32 or float64", np.zeros((5, 3), int))
        self.wrong(r"ids: shape \(4,\), expected \(5,\)", self.positions, self.ids[1:])
        self.wrong("ids: type 9 .* expected one integer", self.positions, np.zeros(5))
        self.wrong("box: found 5, expected two corners", self.positions, box=5)
        self.wrong("box: found .*, expected three numbers", self.positions, box=((0, 0), (1, 1)))
        self.wrong("the box is empty", self.positions, box=((0, 0, 1), (1, 1, 0)))
        self.wrong("speed: dtype", self.positions, speed=np.zeros(5, complex))
        self.wrong("speed: shape", self.positions, speed=np.zeros(6))
        self.wrong("there are no data|stride.0. is 0", np.broadcast_to(np.zeros((1, 3)), (5, 3)))

    def test_they_may_differ_from_step_to_step_but_not_their_fields(self):
        structures = np.zeros(7, [("id", "i4"), ("x", "f8", 3), ("speed", "f4")])
        structures["id"] = range(7)
        self.sim.points("atoms", structures["x"], structures["id"], speed=structures["speed"])
        self.assertEqual(self.sim.publish(1, 0), Result.LOST)
        none = structures[:0]
        self.sim.points("atoms", none["x"], none["id"], speed=none["speed"])
        self.assertEqual(self.sim.publish(2, 0), Result.LOST)
        self.wrong("fields .'mass'., expected .'speed'. as before", structures["x"], structures["id"], mass=structures["speed"])
        self.wrong("expected .'speed'. as before", structures["x"], structures["id"])
        self.wrong("other ids or another box", structures["x"], speed=structures["speed"])

    def test_their_arrays_live_as_long_as_they_are_read(self):
        positions, speed = np.zeros((5, 3)), np.zeros(5)
        alive = weakref.ref(positions), weakref.ref(speed)
        self.sim.points("atoms", positions, self.ids, speed=speed)
        del positions, speed
        gc.collect()
        self.assertTrue(alive[0]() is not None and alive[1]() is not None)
        self.sim.points("atoms", self.positions, self.ids, speed=np.ones(5))
        gc.collect()
        self.assertEqual((alive[0](), alive[1]()), (None, None))


class Cells(unittest.TestCase):
    def setUp(self):
        self.sim = Simulation("sea", **NOWHERE)
        self.addCleanup(self.sim.close)
        self.positions = np.zeros((5, 3))
        self.triangles = np.array([[0, 1, 2], [2, 3, 4]])

    def wrong(self, words, *arguments, **more):
        with self.assertRaisesRegex(ValueError, words):
            self.sim.cells("surface", *arguments, **more)

    def test_wrong_cells_are_told(self):
        flat, ends = self.triangles.reshape(-1), np.array([0, 3, 6])
        self.wrong("positions: 2 components, expected 3", np.zeros((5, 2)), self.triangles)
        self.wrong("cells 'surface', positions: found list", [[0, 0, 0]], self.triangles)
        self.wrong("connectivity: expected a NumPy array with one or two axes", self.positions, [[0, 1, 2]])
        self.wrong(r"connectivity: shape \(2, 5\), expected the points of each cell", self.positions, np.zeros((2, 5), int))
        self.wrong(r"connectivity: shape \(2, 5\), expected the points", self.positions, np.zeros((2, 5), int), 10)
        self.wrong("connectivity: there are gaps", self.positions, np.zeros((2, 6), int)[:, ::2])
        self.wrong("connectivity: type 9 .* expected one integer", self.positions, np.zeros((2, 3)))
        self.wrong("there are no types", self.positions, flat)
        self.wrong("there are no offsets", self.positions, flat, 7)
        self.wrong("there are no offsets", self.positions, flat, np.array([5, 5]))
        self.wrong("there are no offsets", self.positions, flat[1:], 5)
        self.wrong("and no offsets", self.positions, self.triangles, 5, ends)
        self.wrong("offsets: expected a NumPy array of cells . 1", self.positions, flat, 5, [0, 3, 6])
        self.wrong("offsets: type 9", self.positions, flat, 5, ends.astype(float))
        self.wrong("offsets: the last is 7, expected at most 6", self.positions, flat, 5, np.array([0, 3, 7]))
        self.wrong(r"types: shape \(3,\), expected \(2,\)", self.positions, flat, np.array([5, 5, 5]), ends)
        self.wrong("type 24 .quadratic tetrahedra. are not supported", self.positions, flat, 24, ends)
        self.wrong("height: shape", self.positions, self.triangles, height=np.zeros(4))
        self.wrong("region: shape", self.positions, self.triangles, cell_fields={"region": np.zeros(3)})
        self.sim.cells("surface", self.positions, flat, np.array([5, 3]), ends)
        with self.assertRaisesRegex(ValueError, "cell 1: type 3, of lines, in a mesh of triangles"):
            self.sim.publish(1, 0)

    def test_they_may_differ_from_step_to_step_but_not_their_fields(self):
        def tell(n, **more):
            self.sim.cells("surface", self.positions, self.triangles[:n], height=np.zeros(5), cell_fields={"region": np.arange(n)},
                           **more)
        for step, n in enumerate((2, 0, 1), 1):
            tell(n)
            self.assertEqual(self.sim.publish(step, 0), Result.LOST)
        tell(2, types=np.int8(5))
        self.wrong("fields ., expected .'height', 'region'. as before|fields \\[\\], expected", self.positions, self.triangles)
        self.wrong("cells of another kind .* after the first step", self.positions, self.triangles[:, :2].copy(), height=np.zeros(5),
                   cell_fields={"region": np.arange(2)})

    def test_lines_and_polygons_have_offsets(self):
        self.sim.cells("lines", self.positions, np.arange(5, dtype="u4"), 4, np.array([0, 2, 5], "i4"))
        self.sim.cells("pairs", self.positions, np.array([[0, 1]], "i4"))
        self.sim.cells("mixed", self.positions, np.array([0, 1, 2, 3, 0, 1, 2]), np.array([9, 7], "u1"), np.array([0, 4, 7]))
        self.assertEqual(self.sim.publish(1, 0), Result.LOST)

    def test_cells_with_a_volume_have_fields(self):
        corners, types, ends = np.array([0, 1, 2, 3, 0, 1, 2, 3, 4]), np.array([10, 14], "u1"), np.array([0, 4, 9])
        self.sim.cells("surface", self.positions, corners, types, ends)
        with self.assertRaisesRegex(ValueError, 'cells "surface": cells with a volume without a field, expected one or more'):
            self.sim.publish(1, 0)

    def test_cells_with_a_volume_may_have_fields_of_cells_alone(self):
        corners, types, ends = np.array([0, 1, 2, 3, 0, 1, 2, 3, 4]), np.array([10, 14], "u1"), np.array([0, 4, 9])
        fields = {"load": np.ones((2, 3), "f4"), "vtkGhostType": np.array([0, 1], "u1")}
        self.sim.cells("surface", self.positions, corners, types, ends, cell_fields=fields)
        self.assertEqual(self.sim.publish(1, 0), Result.LOST)

    def test_cells_with_a_volume_may_be_of_one_type_or_of_several(self):
        corners, types, ends = np.array([0, 1, 2, 3, 0, 1, 2, 3, 4]), np.array([10, 14], "u1"), np.array([0, 4, 9])
        self.sim.cells("surface", self.positions, np.array([[0, 1, 2, 3, 4]], "i4"), 14, height=np.zeros(5))
        self.assertEqual(self.sim.publish(1, 0), Result.LOST)
        self.sim.cells("surface", self.positions, corners, types, ends, height=np.zeros(5))
        self.assertEqual(self.sim.publish(2, 0), Result.LOST)

    def test_their_arrays_live_as_long_as_they_are_read(self):
        triangles, region = np.zeros((2, 3), int), np.zeros(2)
        alive = weakref.ref(triangles), weakref.ref(region)
        self.sim.cells("surface", self.positions, triangles, cell_fields={"region": region})
        del triangles, region
        gc.collect()
        self.assertTrue(alive[0]() is not None and alive[1]() is not None)
        self.sim.cells("surface", self.positions, self.triangles, cell_fields={"region": np.ones(2)})
        gc.collect()
        self.assertEqual((alive[0](), alive[1]()), (None, None))


class Package(unittest.TestCase):
    def python(self, code, **environment):
        return subprocess.run([sys.executable, "-B", "-c", code], capture_output=True, text=True, timeout=60,
                              env={**os.environ, "PYTHONPATH": str(PACKAGE), **environment})

    def test_its_version_is_galaxys(self):
        self.assertEqual(gxy.__version__, VERSION)

    def test_a_stream_that_nobody_closes_ends_with_python(self):
        run = self.python(f"from gxy.insitu import Simulation; a = Simulation('a', **{NOWHERE}); a.grid({SIZE})")
        self.assertEqual((run.returncode, run.stderr), (0, ""))

    def test_the_environment_says_where_to(self):
        with tempfile.NamedTemporaryFile("w", suffix=".json") as options:
            json.dump({"every": 2}, options)
            options.flush()
            run = self.python("import numpy; from gxy.insitu import Simulation; s = Simulation('a'); s.grid((2, 2, 2)); "
                              "s.field('t', numpy.zeros((2, 2, 2))); print(s.publish(1, 0).name)",
                              GALAXY_INSITU="127.0.0.1:1", GALAXY_INSITU_OPTIONS=options.name)
        self.assertEqual((run.stdout, run.stderr), ("LOST\n", ""))

    def test_a_missing_library_is_told_with_the_places_that_were_looked_at(self):
        run = self.python("from gxy.insitu import Simulation; Simulation('a')", LD_LIBRARY_PATH="")
        if run.returncode == 0:
            self.skipTest("an installed Galaxy has it where the loader looks")
        self.assertIn("library for simulations was not found", run.stderr)
        self.assertIn("libgalaxy_insitu.so.1", run.stderr)
        self.assertIn(os.path.join(sys.prefix, "lib", "libgalaxy_insitu.so.1"), run.stderr)


if __name__ == "__main__":
    unittest.main()

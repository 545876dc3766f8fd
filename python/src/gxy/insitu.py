# SPDX-License-Identifier: Apache-2.0
"""A simulation in Python publishes its steps to a Galaxy server while it runs.

    from mpi4py import MPI
    from gxy.insitu import Simulation

    with Simulation("heat", MPI.COMM_WORLD) as sim:
        sim.grid(size=(nx, ny, nz), first=(0, 0, z), count=(nx, ny, layers))
        sim.field("temperature", temperature)  # a NumPy array, temperature[k][j][i]
        for step in range(1, steps + 1):
            advance(temperature)
            sim.publish(step, step * dt)

Nothing is published unless the environment variable GALAXY_INSITU, or the option `to`, says where to. docs/insitu.md is the
guide. This module uses libgalaxy_insitu through ctypes, and needs NumPy. It needs mpi4py only if the simulation has it.
"""
import ctypes
import enum
import json
import os
import sys
import sysconfig
import typing
import weakref

import numpy as np

__all__ = ["Result", "Simulation", "Statistics"]

_SONAME = "libgalaxy_insitu.so.1"
_WRONG = -1
_OF = {"points": 0, "cells": 1}
_OF_POINTS = {2: 3, 3: 5, 4: 9}  # the type of cells in VTK, where none is told: lines, triangles and quads, by their number of points
_POINTS_OF = {3: 2, 5: 3, 8: 4, 9: 4, 10: 4, 11: 8, 12: 8, 13: 6, 14: 5}  # the points of cells of a type
_MOST_COMPONENTS = 16
_Indices, _Coordinates = ctypes.c_int64 * 3, ctypes.c_double * 3


class Result(enum.IntEnum):
    """What became of a step."""

    TAKEN = 0  # its values were copied
    NOT_TAKEN = 1  # nobody needs it, or the time to wait for it was out
    OFF = 2  # publishing is off
    LOST = 3  # there is no connection to the server; the library tries again if it may


class Statistics(typing.NamedTuple):
    """Counts of one stream on this rank."""

    offered: int  # calls of publish() and publish_last()
    taken: int  # steps that were copied
    published: int  # taken steps that the server has published
    bytes: int  # copied
    publish_seconds: float  # in publish(), all calls together
    longest_seconds: float  # the longest call


class _Array(ctypes.Structure):
    _fields_ = [("data", ctypes.c_void_p), ("type", ctypes.c_int), ("components", ctypes.c_int),
                ("stride", ctypes.c_int64 * 3), ("component_stride", ctypes.c_int64), ("memory", ctypes.c_int)]


class _Stat(ctypes.Structure):
    _fields_ = [("offered", ctypes.c_int64), ("taken", ctypes.c_int64), ("published", ctypes.c_int64),
                ("bytes", ctypes.c_int64), ("publish_seconds", ctypes.c_double), ("longest_seconds", ctypes.c_double)]


def _candidates():
    """Where the library is looked for: where the loader looks, then below the prefix that this package, or Python, is in."""
    yield _SONAME
    here = os.path.realpath(__file__)
    for _ in range(5):  # PREFIX/lib/python3/dist-packages/gxy/insitu.py
        here = os.path.dirname(here)
    for prefix in dict.fromkeys((here, sys.prefix)):
        for folder in ("lib", "lib64", os.path.join("lib", sysconfig.get_config_var("MULTIARCH") or "")):
            yield os.path.normpath(os.path.join(prefix, folder, _SONAME))


def _load():
    failures = []
    for candidate in dict.fromkeys(_candidates()):
        try:
            library = ctypes.CDLL(candidate)
            break
        except OSError as e:
            failures.append(f"\n  {candidate}: {e}")
    else:
        raise OSError("Galaxy's library for simulations was not found. Expected it where the loader looks "
                      "(LD_LIBRARY_PATH), or in an installed Galaxy beside this package:" + "".join(failures))
    text, sim = ctypes.c_char_p, ctypes.c_void_p
    for name, result, arguments in (
            ("gxy_open", sim, [text, ctypes.c_int, ctypes.c_int, text]),
            ("gxy_prepare_here", ctypes.c_int, [text, text]),
            ("gxy_open_here", sim, [text, ctypes.c_int, ctypes.c_int, text, sim]),
            ("gxy_grid", ctypes.c_int, [sim, text, ctypes.c_int, ctypes.c_int, _Indices, _Indices, _Indices, _Coordinates,
                                        _Coordinates]),
            ("gxy_points", ctypes.c_int, [sim, text, ctypes.c_int64, _Array, _Array, ctypes.POINTER(ctypes.c_double)]),
            ("gxy_cells", ctypes.c_int, [sim, text, ctypes.c_int64, _Array, ctypes.c_int64, _Array, _Array, _Array]),
            ("gxy_field", ctypes.c_int, [sim, text, ctypes.c_int, text, ctypes.c_int, _Array]),
            ("gxy_skip", ctypes.c_int, [sim, ctypes.c_int64, ctypes.c_double]),
            ("gxy_wanted", ctypes.c_int, [sim, ctypes.c_int64, ctypes.c_double]),
            ("gxy_steered", ctypes.c_int, [sim, text, ctypes.POINTER(ctypes.c_double)]),
            ("gxy_wanted_settle", ctypes.c_int, [sim, ctypes.c_int64, ctypes.c_int]),
            ("gxy_publish", ctypes.c_int, [sim, ctypes.c_int64, ctypes.c_double]),
            ("gxy_publish_last", ctypes.c_int, [sim, ctypes.c_int64, ctypes.c_double]),
            ("gxy_statistics", ctypes.c_int, [sim, ctypes.POINTER(_Stat)]),
            ("gxy_message", text, [sim]),
            ("gxy_close", None, [sim, ctypes.c_double])):
        function = getattr(library, name)
        function.restype, function.argtypes = result, arguments
    return library


_library = None


def _loaded():
    global _library
    if _library is None:
        _library = _load()
    return _library


def _three(values, what, array):
    """Three numbers, by axis x, y and z, as C has them."""
    convert, kind = (_index, "integers") if array is _Indices else (float, "numbers")
    try:
        numbers = [convert(value) for value in values]
    except (TypeError, ValueError):
        numbers = []
    if len(numbers) != 3:
        raise ValueError(f"{what}: found {values!r}, expected three {kind}, for x, y and z")
    return array(*numbers)


def _index(value, what="index"):
    """An integer of any kind, NumPy's included, that C can hold."""
    number = value.__index__() if hasattr(value, "__index__") else None
    if number is None or not -2**63 <= number < 2**63:
        raise ValueError(f"{what}: found {value!r}, expected an integer of 64 bits")
    return number


def _seconds(value, what):
    try:
        return float(value)
    except (TypeError, ValueError):
        raise ValueError(f"{what}: found {value!r}, expected a number") from None


def _text(value, what):
    if not isinstance(value, str) or "\0" in value:
        raise ValueError(f"{what}: found {value!r}, expected a text")
    return value.encode()


def _block(value):
    number = _index(value, "block")
    if not 0 <= number < 2**31:
        raise ValueError(f"block: found {value!r}, expected 0, 1, ...")
    return number


def _type_of(dtype):
    """The gxy_type of a NumPy dtype."""
    if dtype.isnative and dtype.fields is None and dtype.subdtype is None:
        if dtype.kind in "iu" and dtype.itemsize in (1, 2, 4, 8):
            return 2 * dtype.itemsize.bit_length() - 2 + (dtype.kind == "u")
        if dtype.kind == "f" and dtype.itemsize in (4, 8):
            return 8 if dtype.itemsize == 4 else 9
    raise ValueError(f"dtype {dtype.str}, expected integers of 8 to 64 bits, float32 or float64, in this machine's byte order")


class Simulation:
    """One stream of steps, on one rank of a simulation. Two threads must not use it at the same time.

    name: of the stream. Field F of stream NAME becomes the dataset NAME.F.
    comm_or_rank, ranks: a communicator, which is any object with Get_rank() and Get_size() as mpi4py's have them; or the number
        of this rank and how many there are. Without either, the simulation has one rank. With a communicator of mpi4py this is
        collective, and to="here" runs a server in the simulation's own processes, until close(), which is collective then.
    options: those of docs/insitu.md, with "_" for "-", as to="localhost:5001" or token_file="token".

    Wrong use raises ValueError, and changes nothing. That there is no server, or that it goes, is never an error. The object
    can be used in `with`, which closes it.
    """

    def __init__(self, name, comm_or_rank=None, ranks=None, **options):
        if hasattr(comm_or_rank, "Get_rank") and hasattr(comm_or_rank, "Get_size"):
            if ranks is not None:
                raise ValueError("ranks: expected none beside a communicator, which says how many there are")
            rank, ranks = comm_or_rank.Get_rank(), comm_or_rank.Get_size()
        elif comm_or_rank is None and ranks is None:
            rank, ranks = 0, 1
        elif comm_or_rank is None or ranks is None:
            raise ValueError("expected a communicator with Get_rank() and Get_size(), or both this rank's number and ranks")
        else:
            rank = comm_or_rank
        rank, ranks = _index(rank, "rank"), _index(ranks, "ranks")
        if not 0 <= rank < ranks < 2**31:
            raise ValueError(f"rank {rank} of {ranks}, expected a rank from 0 up to one less than ranks")
        try:
            text = json.dumps({key.replace("_", "-"): value for key, value in options.items()})
        except TypeError as e:
            raise ValueError(f"options: {e}, expected what JSON has") from None
        self._library = _loaded()
        self._blocks = {}  # what a block owns, and of what, by mesh and block
        self._wholes = {}  # size, origin and spacing of grids
        self._arrays = {}  # those that publish() reads, by mesh, block and field
        self._fields = {}  # the names of the fields of particles and cells, by mesh
        self._sim = self._begin(comm_or_rank, _text(name, "name"), rank, ranks, text.encode() if options else None)
        # An object that nobody has closed ends its stream when it goes, at the latest with Python.
        self._end = weakref.finalize(self, self._library.gxy_close, self._sim, 0.0)
        if self._library.gxy_statistics(self._sim, ctypes.byref(_Stat())) == _WRONG:
            why = self.message()
            self._end()
            self._sim = None
            raise ValueError(why)

    def _begin(self, comm, name, rank, ranks, options):
        """Opens the stream. Where mpi4py gives the communicator, a server may run in these processes (galaxy_insitu_mpi.h)."""
        if type(comm).__module__.partition(".")[0] != "mpi4py":
            return self._library.gxy_open(name, rank, ranks, options)
        from mpi4py import MPI
        able = self._library.gxy_prepare_here(options, MPI.Get_library_version().encode())
        least, most = comm.allreduce(able, MPI.MIN), comm.allreduce(able, MPI.MAX)
        if least == most == 0:
            return self._library.gxy_open(name, rank, ranks, options)
        sim = self._library.gxy_open_here(name, rank, ranks, options, MPI._addressof(comm) if least == 1 else None)
        # Where one rank has used it wrongly, all of them close it, which is collective.
        right = self._library.gxy_statistics(sim, ctypes.byref(_Stat())) != _WRONG
        if right and not comm.allreduce(right, MPI.LAND):
            self._library.gxy_close(sim, 0.0)
            raise ValueError("another rank has used Simulation() wrongly")
        if not right:
            comm.allreduce(right, MPI.LAND)
        return sim

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def grid(self, size, first=(0, 0, 0), count=None, origin=(0, 0, 0), spacing=(1, 1, 1), *, of="points", block=0,
             mesh="grid"):
        """Says what this rank owns of a uniform grid. All triples are for x, y and z, whatever the order of arrays is.

        size: of the whole grid, in points or in cells, as `of` says; the same on all ranks.
        first, count: the first point or cell that this rank owns, and how many. Without a count, all behind the first.
        origin, spacing: point (i, j, k) lies at origin + spacing * (i, j, k).
        block: a rank with several boxes calls this for each, with 0, 1, ...; one that owns nothing gives a count of (0, 0, 0).

        Called again, it changes what the block is from the next publish on; its fields have to be told again. Another size, origin or spacing
        removes all blocks of the mesh, and all ranks tell it before the same publish. With the policy "wait", all ranks
        call this whenever one of them does.
        """
        if of not in _OF:
            raise ValueError(f"of: found {of!r}, expected \"points\" or \"cells\"")
        block, name = _block(block), _text(mesh, "mesh")
        size, first = _three(size, "size", _Indices), _three(first, "first", _Indices)
        if count is None:
            count = [s - f for s, f in zip(size, first)]
        count = _three(count, "count", _Indices)
        origin, spacing = _three(origin, "origin", _Coordinates), _three(spacing, "spacing", _Coordinates)
        self._checked(self._library.gxy_grid(self._open(), name, block, _OF[of], size, first, count, origin, spacing))
        now, whole = (tuple(count), of, tuple(first)), (tuple(size), tuple(origin), tuple(spacing))
        # The library has forgotten the fields of blocks that are others, too.
        isOther = self._wholes.get(mesh, whole) != whole
        others = [b for b in self._blocks if b[0] == mesh and (isOther or b[1] == block) and self._blocks[b] != now]
        for key in [key for key in self._arrays if key[:2] in others]:
            del self._arrays[key]
        for other in others:
            del self._blocks[other]
        self._blocks[mesh, block], self._wholes[mesh] = now, whole

    def field(self, name, array, *, order="zyx", block=0, mesh="grid"):
        """Says where the values of a field lie: in a NumPy array, which is read in publish() only and never copied here.

        The array has what the block owns, and nothing else: a view leaves ghosts out, as array[1:-1, 1:-1, 1:-1]. Its strides
        may be any, and negative, but not 0. The natural order is array[k][j][i], so that its shape is (nz, ny, nx); with
        order="xyz" it is array[i][j][k], of shape (nx, ny, nz). A fourth axis, the last, counts 1 to 16 components. The array is
        kept alive until it is replaced by another call, or the stream is closed. Values that the simulation writes into it are
        seen by the next publish().
        """
        if order not in ("zyx", "xyz"):
            raise ValueError(f"order: found {order!r}, expected \"zyx\" for array[k][j][i] or \"xyz\" for array[i][j][k]")
        block, in_mesh, in_name = _block(block), _text(mesh, "mesh"), _text(name, "field")
        if (mesh, block) not in self._blocks:
            raise ValueError(f"field {name!r}: there is no block {block!r} of mesh {mesh!r}, expected grid() first")
        try:
            values, of = self._described(array, order, *self._blocks[mesh, block][:2])
        except ValueError as e:
            raise ValueError(f"field {name!r}: {e}") from None
        self._checked(self._library.gxy_field(self._open(), in_mesh, block, in_name, of, values))
        self._arrays[mesh, block, name] = array

    def points(self, mesh, positions, ids=None, box=None, **fields):
        """Says which particles this rank has now. Called before each publish() that has other ones, or has them elsewhere in memory.

        mesh: the name of the particles. Each field F becomes the dataset NAME.F; particles without fields become NAME.MESH.
        positions: an array of shape (n, 3), of float32 or float64; n may be 0, and differs from rank to rank and from step to step.
        ids: n integers of 32 or 64 bits, from 0 up, each once on all ranks. Without, particles are numbered by rank.
        box: the least and the largest corner, of the domain that the server cuts for its ranks: two triples for x, y, z. Without, it
            is that of the particles of the first step, a tenth larger. Particles may be outside.
        fields: arrays of shape (n,), or (n, components), as speed=speed. The same names in all steps and on all ranks.

        The arrays are read in publish() only and never copied here; they are kept alive until they are replaced.
        """
        name = _text(mesh, "mesh")
        self._check_fields("points", mesh, set(fields))
        count = len(positions) if isinstance(positions, np.ndarray) and positions.ndim else 0
        given = {"positions": positions, **({} if ids is None else {"ids": ids}), **fields}
        arrays = {what: self._row(f"points {mesh!r}, {what}", array, count) for what, array in given.items()}
        corners = None
        if box is not None:
            try:
                low, high = box
            except (TypeError, ValueError):
                raise ValueError(f"box: found {box!r}, expected two corners") from None
            corners = (ctypes.c_double * 6)(*_three(low, "box", _Coordinates), *_three(high, "box", _Coordinates))
        self._checked(self._library.gxy_points(self._open(), name, len(positions), arrays["positions"],
                                               arrays.get("ids", _Array()), corners))
        self._arrays[mesh, 0, None] = positions, ids
        for field in fields:
            self._tell_field(mesh, field, "points", arrays[field], fields[field])
        self._fields[mesh] = set(fields)

    def cells(self, mesh, positions, connectivity, types=None, offsets=None, cell_fields=None, **fields):
        """Says which lines, triangles or cells with a volume this rank has now. Called before each publish() that has other ones, or has them elsewhere in memory.

        mesh: the name of the cells. Each field F becomes the dataset NAME.F; cells without fields become NAME.MESH.
        positions: an array of shape (n, 3), of float32 or float64; n may be 0, and differs from rank to rank and from step to step.
        connectivity: integers of 32 or 64 bits, the points of each cell by their number on this rank. Of shape (cells, 2) for lines, (cells, 3)
            for triangles, (cells, 4) for quads, and for other cells with as many columns as they have points; without gaps, since it is never
            copied. Or of shape (m,), with the cells one after the other.
        types: VTK's number for all cells, or an array with one for each: lines (3, 4); triangles, strips, polygons, pixels and quads (5 to 9); or
            tetrahedra, voxels, hexahedra, wedges and pyramids (10 to 14), which become an unstructured volume.
            It may be left out for lines, triangles and quads in a connectivity of two axes.
        offsets: for a connectivity of one axis: cells + 1 integers of 32 or 64 bits, as in VTK: cell c has entries offsets[c] up to and
            without offsets[c + 1]. It may be left out if all cells are of one type with a fixed number of points.
        fields: of points, arrays of shape (n,), or (n, components), as height=height. `Normals`, of shape (n, 3), are the normals of the mesh.
        cell_fields: of cells, a dict of arrays with a row for each. The same names in all steps and on all ranks.

        The arrays are read in publish() only and never copied here; they are kept alive until they are replaced.
        """
        name, of_cells = _text(mesh, "mesh"), dict(cell_fields or {})
        what = f"cells {mesh!r}"
        self._check_fields("cells", mesh, set(fields) | {("cells", field) for field in of_cells})
        count = len(positions) if isinstance(positions, np.ndarray) and positions.ndim else 0
        at = self._row(f"{what}, positions", positions, count)
        points = {field: self._row(f"{what}, {field}", array, count) for field, array in fields.items()}
        cells, types, flat = self._cells(what, connectivity, types, offsets)
        corners = self._row(f"{what}, connectivity", flat, len(flat))
        begins = _Array() if offsets is None else self._row(f"{what}, offsets", offsets, cells + 1)
        values = {field: self._row(f"{what}, {field}", array, cells) for field, array in of_cells.items()}
        if np.ndim(types) == 0:
            kept = np.array([types], np.int64)
            kinds = _Array(kept.ctypes.data, _type_of(kept.dtype), 1, _Indices(0, 0, 0), 0, 0)
        else:
            kept, kinds = types, self._row(f"{what}, types", types, cells)
        if offsets is not None and cells > 0:
            self._check_end(what, offsets, len(flat))
        self._checked(self._library.gxy_cells(self._open(), name, count, at, cells, kinds, begins, corners))
        self._arrays[mesh, 0, None] = positions, flat, kept, offsets
        for field in fields:
            self._tell_field(mesh, field, "points", points[field], fields[field])
        for field in of_cells:
            self._tell_field(mesh, field, "cells", values[field], of_cells[field])
        self._fields[mesh] = set(fields) | {("cells", field) for field in of_cells}

    def skip(self, step, time):
        """Counts a step that this rank cannot publish, so that all ranks go on counting alike. It is left out on all of them."""
        return self._checked(self._library.gxy_skip(self._open(), _index(step, "step"), _seconds(time, "time")))

    def wanted(self, step, time):
        """Whether the next publish(), which is of this step and time, will be taken. If not, this rank does not take it.

        Ranks may get different answers. Where they compute together what is published, settle() tells what they agree on.
        """
        wanted = self._library.gxy_wanted(self._open(), _index(step, "step"), _seconds(time, "time"))
        if wanted == _WRONG:
            raise ValueError(self.message())
        return wanted == 1

    def settle(self, step, any_rank):
        """Says whether any rank wants the step; the same on all ranks, after wanted()."""
        self._checked(self._library.gxy_wanted_settle(self._open(), _index(step, "step"), int(bool(any_rank))))

    def steered(self, parameter):
        """The value that somebody has given a parameter of the option `steerable` since the last call; None if nobody has.

        Unless the policy is "wait" without a time-out, ranks may get it after different steps: one asks, and tells the others.
        """
        value = ctypes.c_double()
        changed = self._library.gxy_steered(self._open(), _text(parameter, "parameter"), ctypes.byref(value))
        if changed == _WRONG:
            raise ValueError(self.message())
        return value.value if changed else None

    def publish(self, step, time):
        """Offers a step, and says what became of it, a Result. Steps ascend; all ranks offer the same.

        It never waits, unless the option `policy` says so.
        """
        return self._checked(self._library.gxy_publish(self._open(), _index(step, "step"), _seconds(time, "time")))

    def publish_last(self, step, time):
        """Offers the last step: it is copied, and close() waits until the server has published it. Only close() may follow."""
        return self._checked(self._library.gxy_publish_last(self._open(), _index(step, "step"), _seconds(time, "time")))

    def statistics(self):
        """The Statistics of this stream on this rank."""
        stat = _Stat()
        self._checked(self._library.gxy_statistics(self._open(), ctypes.byref(stat)))
        return Statistics(*(getattr(stat, name) for name in Statistics._fields))

    def message(self):
        """The text about the last result, or about why there is no connection; empty if there is nothing to say."""
        return self._library.gxy_message(self._open()).decode(errors="replace")

    def close(self, seconds=5.0):
        """Ends the stream. Waits at most so many seconds until the server has published the last step, or one that was taken.

        It may be called again.
        """
        if self._sim is None:
            return
        seconds = _seconds(seconds, "seconds")
        sim, self._sim = self._sim, None
        self._end.detach()
        self._library.gxy_close(sim, seconds)
        self._arrays.clear()

    @staticmethod
    def _described(array, order, count, of):
        """The gxy_array of an array that has `count` values, and the gxy_of."""
        if not isinstance(array, np.ndarray):
            raise ValueError(f"found {type(array).__name__}, expected a NumPy array in the simulation's own memory")
        shape = count[::-1] if order == "zyx" else count
        if array.ndim not in (3, 4) or (array.shape[:3] != shape and 0 not in count):
            raise ValueError(f"shape {array.shape}, expected {shape} for order {order!r}, and perhaps an axis of components")
        components = array.shape[3] if array.ndim == 4 else 1
        if not 1 <= components <= _MOST_COMPONENTS:
            raise ValueError(f"{components} components, expected 1 to {_MOST_COMPONENTS}")
        between = array.strides[3] if components > 1 else 0
        if components > 1 and between == 0:
            raise ValueError("components without memory of their own, expected a stride other than 0")
        strides = array.strides[2::-1] if order == "zyx" else array.strides[:3]
        return _Array(array.ctypes.data, _type_of(array.dtype), components, _Indices(*strides), between, 0), _OF[of]

    def _check_fields(self, what, mesh, fields):
        """What has been told once has the same fields from then on."""
        before = self._fields.get(mesh, fields)
        if before != fields:
            names = [sorted(f if isinstance(f, str) else f[1] for f in some) for some in (fields, before)]
            raise ValueError(f"{what} {mesh!r}: fields {names[0]}, expected {names[1]} as before")

    def _tell_field(self, mesh, field, of, values, array):
        """Tells where a field of particles, or of points or cells of a mesh of cells, lies, and keeps its array alive."""
        self._checked(self._library.gxy_field(self._open(), _text(mesh, "mesh"), 0, _text(field, "field"), _OF[of], values))
        self._arrays[mesh, 0, field] = array

    @classmethod
    def _row(cls, what, array, count):
        try:
            return cls._of_particles(array, count)
        except ValueError as e:
            raise ValueError(f"{what}: {e}") from None

    @staticmethod
    def _cells(what, connectivity, types, offsets):
        """The number of cells, their types (a number or an array), and the connectivity with one axis."""
        if not isinstance(connectivity, np.ndarray) or connectivity.ndim not in (1, 2):
            raise ValueError(f"{what}, connectivity: expected a NumPy array with one or two axes")
        if connectivity.ndim == 2:
            each = connectivity.shape[1]
            of = _OF_POINTS.get(each) if types is None else _index(types, "types") if np.ndim(types) == 0 else None
            if offsets is not None or of is None or _POINTS_OF.get(of, each) != each:
                raise ValueError(f"{what}, connectivity: shape {connectivity.shape}, expected the points of each cell (2 of lines, 3 of triangles, "
                                 "4 of quads, or as many as the one type that all cells are of), and no offsets")
            if not connectivity.flags.c_contiguous:
                raise ValueError(f"{what}, connectivity: there are gaps, expected an array that is contiguous")
            return len(connectivity), of, connectivity.reshape(-1)
        if types is None:
            raise ValueError(f"{what}: there are no types, expected them, or a connectivity with a row for each cell")
        if np.ndim(types) == 0:
            types = _index(types, "types")
        if offsets is not None:
            if not isinstance(offsets, np.ndarray) or offsets.ndim != 1 or len(offsets) == 0:
                raise ValueError(f"{what}, offsets: expected a NumPy array of cells + 1 integers")
            return len(offsets) - 1, types, connectivity
        each = _POINTS_OF.get(types) if isinstance(types, int) else None
        if each is None or len(connectivity) % each:
            raise ValueError(f"{what}: there are no offsets, expected them, or cells of one type with a fixed number of points")
        return len(connectivity) // each, types, connectivity

    @staticmethod
    def _check_end(what, offsets, entries):
        """The library reads as far as the offsets say, so they must not reach beyond the array."""
        if not 0 <= int(offsets[-1]) <= entries:
            raise ValueError(f"{what}, offsets: the last is {offsets[-1]}, expected at most {entries}, the length of the connectivity")

    @staticmethod
    def _of_particles(array, count):
        """The gxy_array of an array with one row for each particle, point or cell."""
        if not isinstance(array, np.ndarray):
            raise ValueError(f"found {type(array).__name__}, expected a NumPy array in the simulation's own memory")
        if array.ndim not in (1, 2) or len(array) != count:
            raise ValueError(f"shape {array.shape}, expected ({count},) or ({count}, components)")
        components = array.shape[1] if array.ndim == 2 else 1
        if not 1 <= components <= _MOST_COMPONENTS:
            raise ValueError(f"{components} components, expected 1 to {_MOST_COMPONENTS}")
        between = array.strides[1] if components > 1 else 0
        if components > 1 and between == 0:
            raise ValueError("components without memory of their own, expected a stride other than 0")
        return _Array(array.ctypes.data, _type_of(array.dtype), components, _Indices(array.strides[0], 0, 0), between, 0)

    def _open(self):
        if self._sim is None:
            raise ValueError("the stream is closed")
        return self._sim

    def _checked(self, result):
        if result == _WRONG:
            raise ValueError(self.message())
        return Result(result)

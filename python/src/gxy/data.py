# SPDX-License-Identifier: Apache-2.0
"""Datasets of a server."""
from __future__ import annotations

import typing
from typing import Any, Iterator, Optional

import numpy as np

from .client import GalaxyError
from .waiting import FOREVER, Deadline, twin

if typing.TYPE_CHECKING:
    from .session import Session


class Data:
    """A dataset of a server by its name, whatever the name means now or later. It holds no values; each property asks the
    server. From any thread. Where there is no such dataset, GalaxyError is raised."""

    def __init__(self, session: Session, name: str) -> None:
        self.session = session
        self.name = name

    @property
    def info(self) -> dict[str, Any]:
        """All that the server tells of it (docs/protocol.md, verb `info`)."""
        return self.session.ask("data.info", self.name)["datasets"][0]

    @property
    def type(self) -> str:
        """Volume, Particles, PathLines or Triangles."""
        return self.info["type"]

    @property
    def generation(self) -> int:
        """Counts what has been imported or published under this name."""
        return self.info["generation"]

    @property
    def range(self) -> Optional[tuple[float, float]]:
        """The least and the largest value, of vectors their magnitude; None without values."""
        values = self.info["range"]
        return None if values is None else (values[0], values[1])

    @property
    def box(self) -> np.ndarray:
        """float64 (2, 3): the least and the largest corner, in world coordinates."""
        box = self.info["box"]
        if box is None:
            raise GalaxyError(f'dataset "{self.name}" has no data, and so no box')
        return np.array(box, np.float64)

    def fetch(self, timeout: Optional[float] = None) -> dict[str, Any]:
        """All that it holds: what Client.fetch() returns. Structures and fields are arrays in this process's memory."""
        return self.session.client.fetch(self.name, timeout)

    def values(self, field: Optional[str] = None, timeout: Optional[float] = None) -> np.ndarray:
        """The values of one field: of a volume (nz, ny, nx), of points or cells (n,), with one axis more if there are several
        components. Without a name: of the only field, or of the first of geometry."""
        fields = self.fetch(timeout)["fields"]
        if field is None and fields:
            return next(iter(fields.values()))
        if field not in fields:
            raise GalaxyError(f'dataset "{self.name}": no field {field!r}, expected one of {sorted(fields)}')
        return fields[field]

    def histogram(self, bins: int = 256, component: Optional[int] = None, timeout: Optional[float] = None) -> tuple[np.ndarray, np.ndarray]:
        """How many values are in each bin, int64 (bins,), and the edges of the bins, float64 (bins + 1,), as numpy.histogram() returns
        them. The server counts; no values are sent. Without values there are no bins and no edges.

        bins: 1 to 4096, of equal width between the least and the largest value.
        component: of vectors, from 0; without, their magnitudes are counted.
        """
        words = [bins] if component is None else [bins, component]
        reply = self.session.ask("data.histogram", self.name, *words, timeout=timeout, limited=False)
        if reply["range"] is None:
            return np.zeros(0, np.int64), np.zeros(0)
        return np.array(reply["counts"], np.int64), np.linspace(*reply["range"], len(reply["counts"]) + 1)

    def wait(self, generation: Optional[int] = None, timeout: Optional[float] = None) -> Data:
        """Waits until it is there and has at least this generation (default: any). Raises Timeout."""
        self.session.ask("data.wait", self.name, 1 if generation is None else generation, FOREVER,
                         timeout=timeout, limited=False)
        return self

    def steps(self, timeout: Optional[float] = None) -> Iterator[int]:
        """The steps of a simulation, or the generations of other data: the newest at once, if there is one, then each newer
        one as it comes. Of those that come while the caller computes, the newest only. Ends when the simulation closes its
        stream. Raises Timeout if nothing comes for so many seconds, and GalaxyError when the dataset is dropped."""
        session = self.session
        session.ask("insitu.listen")
        session.ask("data.observe", self.name)
        seen: Optional[tuple[tuple[int, int], ...]] = None
        deadline = Deadline(timeout)
        while True:
            count = session._news.count
            streams = {stream["name"] for stream in session.ask("insitu.streams")["streams"]}
            if seen is not None or self.name in session:
                info = self.info
                if info["generation"] and seen != identity(info):
                    seen = identity(info)
                    yield _step(info)
                    deadline = Deadline(timeout)
                    continue
                if "stream" in info and info["stream"] not in streams:
                    return
            session._news.wait(count, deadline, f'dataset "{self.name}": no newer step')

    def export(self, file: str, timeout: Optional[float] = None) -> str:
        """Writes it to a file in a --data folder of the server; the file's name there. The ending says the format: .vti, .vtu,
        .vtp, .csv, .ply or .stl."""
        return self.session.ask("data.export", self.name, file, timeout=timeout, limited=False)["file"]

    def copy(self, name: str, shared: bool = False, timeout: Optional[float] = None) -> Data:
        """Keeps what it is now under another name, which stays the same when newer data come. The server shares the data.

        shared: all tenants see the copy.
        """
        words = ["shared", self.name, name] if shared else [self.name, name]
        self.session.ask("data.copy", *words, timeout=timeout, limited=False)
        return Data(self.session, name)

    def drop(self) -> None:
        """The server forgets it."""
        self.session.ask("data.drop", self.name)

    fetch_async = twin(fetch)
    values_async = twin(values)
    histogram_async = twin(histogram)
    wait_async = twin(wait)
    export_async = twin(export)
    copy_async = twin(copy)

    def __repr__(self) -> str:
        return f'<Data "{self.name}">'


def identity(info: dict[str, Any]) -> tuple[tuple[int, int], ...]:
    """Tells a generation from all others of this name, also of another stream, or of a node that was edited."""
    return ((info["generation"], 0), *((origin["source"], origin["step"]) for origin in info.get("origins", [])))


def _step(info: dict[str, Any]) -> int:
    origins = info.get("origins", [])
    return max(origin["step"] for origin in origins) if "stream" in info and origins else info["generation"]

# SPDX-License-Identifier: Apache-2.0
"""Views of a graph, and pictures of them."""
from __future__ import annotations

import contextlib
import json
import os
import threading
from typing import Any, Iterator, Optional, Union

import numpy as np

from .client import GalaxyError, Timeout, Window
from .evaluation import await_node
from .nodes import Node
from .picture import Picture
from .statements import plain
from .waiting import Deadline, twin


def _camera(document: dict[str, Any], entry: dict[str, Any]) -> Any:
    """The view's camera, or the document's first; None: one that shows all data."""
    return entry.get("camera") or next(iter(document.get("Cameras", [])), None)


def _size(document: dict[str, Any], entry: dict[str, Any]) -> tuple[int, int]:
    camera = _camera(document, entry)
    width, height = entry.get("size") or (camera.get("dimensions") if isinstance(camera, dict) else None) or (512, 512)
    return width, height


def _asks_data(document: dict[str, Any], entry: dict[str, Any]) -> bool:
    """Whether something of the view is what the data say, which a window widens and never narrows."""
    named = {look.get("name"): look for look in document.get("Operators", [])}
    looks = [look if isinstance(look, dict) else named.get(look, {}) for look in entry.get("operators", [])]
    camera = _camera(document, entry)
    return (camera is None or (isinstance(camera, dict) and bool(camera.get("fit"))) or
            any(look.get("data range") == "data" or look.get("radius") == "auto" for look in looks))


def write_document(file: Union[str, os.PathLike[str]], document: dict[str, Any]) -> None:
    """Writes a state file of this machine."""
    with open(file, "w", encoding="utf-8") as out:
        json.dump(document, out, indent=2)
        out.write("\n")


class _Shown:
    """The server's window on one view. While it is there, the server keeps ready what the view shows."""

    def __init__(self) -> None:
        self._lock = threading.Lock()  # one picture at a time
        self.window: Optional[Window] = None
        self.size: Optional[tuple[int, int]] = None
        self.revision = 0  # of the document that it was opened for
        self.turned = False  # whether its camera is another than the view's
        self.is_gone = False  # whether it shows something else by now: the graph was dropped, or the view renamed


    @contextlib.contextmanager
    def taken(self, deadline: Deadline) -> Iterator[None]:
        """For one thread alone."""
        left = deadline.left()
        if not self._lock.acquire(timeout=-1 if left is None else left):
            raise Timeout(f"another picture of the view is still made after {deadline.timeout:g} s")
        try:
            yield
        finally:
            self._lock.release()


class View(Node):
    """A view: looks that make one picture, and their camera. The first render() opens a window of the server on it; close(), or the
    end of the session, closes that. A session may have 16 windows unless the server says otherwise."""

    @property
    def camera(self) -> dict[str, Any]:
        """The camera, as `Cameras` of a state file has it. Where the document says none: the one with which the server shows all
        data, for which it waits. Setting it is an edit: everybody who shows the view sees it turn. None takes it away."""
        entry = self.entry
        if "camera" in entry:
            return entry["camera"]
        deadline = Deadline(60)
        shown = self._shown()
        with shown.taken(deadline):
            return self._camera_of(self._window(shown, None, False, deadline), deadline)

    @camera.setter
    def camera(self, camera: Optional[dict[str, Any]]) -> None:
        self._set(["camera"], camera)

    def _camera_of(self, window: Window, deadline: Deadline) -> dict[str, Any]:
        await_node(self.graph, "view", self.name, deadline, run=False)
        return self.session.ask("viewer.camera", window.number, timeout=deadline.left())["Camera"]

    def render(self, size: Optional[tuple[int, int]] = None, passes: int = 1, camera: Optional[dict[str, Any]] = None,
               timeout: Optional[float] = 60) -> Picture:
        """A picture of the newest document and data; waits until the filters that it needs are done. It is the one that gxyrender makes
        of the file that save() writes, to the bit.

        size: (width, height) in pixels; by default the view's `size`, else the camera's `dimensions`, else 512 x 512.
        passes: each adds the rays per pixel of the document's `Renderer`.
        camera: one for this picture alone, in place of the view's.

        Raises GalaxyError, with `node`, if something that it shows has failed, and Timeout. Calls for one view wait for each other.
        """
        deadline = Deadline(timeout)
        options: dict[str, Any] = {"levels": [1], "passes": passes}
        if camera is not None:
            options["Camera"] = plain(camera)
        shown = self._shown()
        with shown.taken(deadline):
            window = self._window(shown, size, camera is not None, deadline)
            await_node(self.graph, "view", self.name, deadline, run=False)
            try:
                picture = window.render(deadline.left(), **options)
            except Timeout:
                self.session.ask("viewer.cancel_frame", window.number)
                raise Timeout(f'view "{self.name}": no picture after {timeout:g} s') from None
            except GalaxyError as e:
                raise self._error(f"cannot be rendered: {e}") from e
        if picture.rgba is None:
            raise self._error("has come without pixels")
        return Picture(np.ascontiguousarray(picture.rgba[::-1]), picture.end)

    def save(self, file: Union[str, os.PathLike[str]], timeout: Optional[float] = 60) -> None:
        """Writes a state file of this view alone, of which gxyrender makes the picture of render(): its camera and size are those of
        `Cameras`. Where the document says no camera it is the one with which the server shows all data, for which it waits."""
        deadline, shown = Deadline(timeout), self._shown()
        with shown.taken(deadline):
            window = self._window(shown, None, False, deadline)
            camera = self._camera_of(window, deadline)
        document, entry = self.graph.document, self.entry
        entry.pop("camera", None)
        width, height = shown.size or (512, 512)
        document["Visualizations"], document["Cameras"] = [entry], [{**camera, "dimensions": [width, height]}]
        document.pop("Outputs", None)  # gxyrender would make them
        write_document(file, document)

    def wait(self, timeout: Optional[float] = None) -> View:
        """Waits until a window on it shows the newest document and data. Raises as render()."""
        deadline, shown = Deadline(timeout), self._shown()
        with shown.taken(deadline):
            self._window(shown, shown.size, shown.turned, deadline)
            await_node(self.graph, "view", self.name, deadline, run=False)
        return self

    def close(self) -> None:
        """Closes the server's window on it. What only this window needed is made no more. It may be called again."""
        session = self.session
        with session._lock:
            shown = session._shown.get((self.graph.name, self.name))
        if shown:
            with shown.taken(Deadline(None)):
                self._close(shown)

    def _shown(self) -> _Shown:
        session = self.session
        with session._lock:
            shown: _Shown = session._shown.setdefault((self.graph.name, self.name), _Shown())
            return shown

    def _window(self, shown: _Shown, size: Optional[tuple[int, int]], turned: bool, deadline: Deadline) -> Window:
        """The window, in this size. A window keeps the camera that it was turned to, and ranges that earlier data had, so one for another
        document may be a new one."""
        told = self.session.ask("graph.get", self.graph.name, timeout=deadline.left())
        document, revision = told["document"], told["revision"]
        entry = self._entry_of(document)
        width, height = size or _size(document, entry)
        size = int(width), int(height)
        is_older = shown.revision != revision and _asks_data(document, entry)
        if shown.is_gone or is_older or (shown.turned and not turned):
            self._close(shown)
        if shown.window is None:
            shown.window = self.session.client.window(self._free_number(), deadline.left(), size=size)
            try:
                self.session.ask("viewer.show", shown.window.number, value={"graph": self.graph.name, "view": self.name},
                                 timeout=deadline.left())
            except GalaxyError:
                self._close(shown)
                raise
        elif size != shown.size:
            self.session.ask("viewer.window", shown.window.number, value={"size": size}, timeout=deadline.left())
        shown.size, shown.turned, shown.revision = size, turned, revision
        return shown.window

    def _free_number(self) -> int:
        session = self.session
        with session._lock:
            session._windows += 1
            return session._windows

    def _close(self, shown: _Shown) -> None:
        if shown.window is not None:
            window, shown.window, shown.turned, shown.is_gone = shown.window, None, False, False
            window.close()

    render_async = twin(render)
    wait_async = twin(wait)

    def _repr_png_(self) -> bytes:
        return self.render().png()

# SPDX-License-Identifier: Apache-2.0
"""A session with a Galaxy server: its data, graphs and events."""
from __future__ import annotations

import json
import logging
import os
import queue
import threading
import typing
from pathlib import PurePath
from typing import Any, Callable, Iterator, Optional, Union

from .catalogue import Catalogue
from .client import Client, GalaxyError, split_address
from .data import Data
from .graph import Graph
from .statements import statement, warn
from .waiting import Deadline, News, Threads, twin

if typing.TYPE_CHECKING:
    import numpy as np

_Path = Union[str, "os.PathLike[str]"]
_MODULES = ("analysis", "data", "graph", "insitu", "viewer")


def connect(address: Optional[str] = None, token_file: Optional[str] = None, *, tenant: str = "user", name: str = "gxy",
            timeout: float = 10) -> Session:
    """Connects to a gxyserver.

    address: "HOST:PORT", by default "localhost:5001". An ssh tunnel is localhost, too.
    token_file: the file of a copy of the server's token, "-" for none. Without, it is found where a server on this machine leaves it;
        other machines are sent no token unasked, since nothing is encrypted.
    tenant: who the data belong to, for servers that run with --no-token.
    name: of this client, for people.
    timeout: seconds that connecting, and each answer to a short question, may take. What computes has a timeout of its own.

    Raises GalaxyError if there is no server, no token or a wrong one, and Timeout. The session ends with close(), or `with`.
    """
    return Session(address, token_file, tenant=tenant, name=name, timeout=timeout)


class Session:
    """A connection to a server. Its methods, and those of its data, graphs, nodes and views, may be called from any thread.
    Those that end with _async return a Future at once. Errors are GalaxyError; when the connection ends, all that wait get one.

    client   the Client below it, for verbs that nothing here has: session.client.request("stat")
    """

    def __init__(self, address: Optional[str] = None, token_file: Optional[str] = None, *, tenant: str = "user", name: str = "gxy",
                 timeout: float = 10) -> None:
        self._host, self._port = split_address(address or "localhost:5001")
        self._token_file, self._tenant, self._timeout = token_file, tenant, timeout
        self._news = News()
        self._threads = Threads()
        self._shown: dict[tuple[str, str], Any] = {}  # windows by graph and view; view.py
        self._windows = 0  # how many were ever opened
        self._lock = threading.Lock()  # of the two above and the two below
        self._loaded: set[str] = set()
        self._callbacks: list[tuple[Callable[[dict[str, Any]], None], Optional[str]]] = []
        self._events: queue.SimpleQueue[Optional[dict[str, Any]]] = queue.SimpleQueue()
        self._caller: Optional[threading.Thread] = None
        self._catalogue: Optional[Catalogue] = None
        self.client = Client(self._host, self._port, token_file=token_file, tenant=tenant, name=name, timeout=timeout,
                             on_event=self._hear, on_end=self._news.tell)

    def __enter__(self) -> Session:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Ends the connection and the threads of the session; it waits for them up to 10 s, as put() may still be sending. The server keeps
        data and graphs. It may be called again."""
        self.client.close()
        with self._lock:
            caller, self._caller = self._caller, None
        if caller:
            self._events.put(None)
            if caller is not threading.current_thread():
                caller.join()
        self._threads.join(Deadline(10))

    # Requests

    def ask(self, verb: str, *words: Union[str, int], value: Any = None, timeout: Optional[float] = None,
            limited: bool = True) -> dict[str, Any]:
        """Asks the server something (docs/protocol.md): the verb, perhaps with keywords as "data.list all", then words such as names,
        then a JSON value. The reply's object. Loads the verb's module. Without a timeout that of connect() holds; with
        limited=False none."""
        limit = self._timeout if timeout is None and limited else timeout
        self._load_module_of(verb)
        return self.client.request(statement(verb, *words, value=value), limit)

    def _load_module_of(self, verb: str) -> None:
        module = verb.partition(".")[0]
        if module in _MODULES and module not in self._loaded:
            self.client.request(f"load {module}", self._timeout)
            self._loaded.add(module)

    # Data

    @property
    def data(self) -> list[Data]:
        """All datasets that this tenant sees, by name."""
        return [Data(self, entry["name"]) for entry in self.ask("data.list")["datasets"]]

    def __getitem__(self, name: str) -> Data:
        """The dataset of this name. Raises GalaxyError if there is none; wait() waits for one that is to come."""
        try:
            self.ask("data.info", name)
        except GalaxyError as e:
            names = ", ".join(data.name for data in self.data)
            raise GalaxyError(f"{e}; there are: {names or 'none'}") from None
        return Data(self, name)

    def __contains__(self, name: object) -> bool:
        return any(entry["name"] == name for entry in self.ask("data.list all")["datasets"])

    def __iter__(self) -> Iterator[Data]:
        return iter(self.data)

    def open(self, file: _Path, array: Optional[str] = None, name: Optional[str] = None, *, type: Optional[str] = None,
             like: Union[None, str, Data] = None, timeout: Optional[float] = None) -> Data:
        """Has the server read a file, and waits for it.

        file: as the server has it, absolute or relative to one of its --data folders.
        array: which of the file's arrays; by default the active one, else the first.
        name: of the dataset; by default the file's name. A name that is there gets a new generation.
        type: Volume, Particles, PathLines or Triangles. Without, the server looks into the file first.
        like: a dataset to be shown together with; without, the newest one that has room for the data.
        """
        deadline, path = Deadline(timeout), os.fspath(file)
        entry: dict[str, Any] = {"filename": path, "type": type or self._type_of(path, array, deadline)}
        entry.update({key: value for key, value in (("array", array), ("name", name)) if value is not None})
        verb, words = ("data.import", []) if like is None else ("data.import like", [like if isinstance(like, str) else like.name])
        reply = self.ask(verb, *words, value={"Datasets": [entry]}, timeout=deadline.left(), limited=False)
        warn(reply)
        return Data(self, reply["datasets"][0])

    def _type_of(self, file: str, array: Optional[str], deadline: Deadline) -> str:
        reply = self.ask("viewer.scene", file, value={"array": array} if array else None, timeout=deadline.left(), limited=False)
        types = {entry["type"] for entry in reply["state"]["Datasets"]}
        if len(types) != 1:
            raise GalaxyError(f"{file}: there are {', '.join(sorted(types))} in it, expected the argument `type`")
        return types.pop()

    def put(self, name: str, array: np.ndarray, *, origin: tuple[float, float, float] = (0, 0, 0),
            spacing: Union[float, tuple[float, float, float]] = 1, step: int = 1, time: Optional[float] = None,
            of: str = "points", like: Union[None, str, Data] = None, timeout: float = 60) -> Data:
        """Gives the server an array of values on a uniform grid, and waits until it is a dataset there, or its next generation.

        name: "STREAM.FIELD": the server names what programs publish so, and one program at a time publishes under STREAM.
        array: (nz, ny, nx), or (nz, ny, nx, components); integers or floats, any strides. It is not kept.
        origin, spacing: where point (0, 0, 0) lies, and how far apart points are, for x, y, z, in the world's unit.
        step, time: of the simulation; the time is the step unless it is told.
        of: "points", or "cells": then values are those of cells.
        like: a dataset to be shown together with.

        It needs libgalaxy_insitu (docs/insitu.md); without it GalaxyError says where it was looked for.
        """
        from .put import put
        to = f"{self._host if ':' not in self._host else f'[{self._host}]'}:{self._port}"
        options: dict[str, Any] = {"to": to, "reconnect": 0.2, "tenant": self._tenant}
        if self._token_file is not None:
            options["token_file"] = self._token_file
        if like is not None:
            options["partition"] = {"like": like if isinstance(like, str) else like.name}
        put(self, name, array, origin, spacing, step, time, of, options, Deadline(timeout))
        return Data(self, name)

    def wait(self, name: str, generation: Optional[int] = None, timeout: Optional[float] = None) -> Data:
        """Waits for a dataset that may come later, as that of a simulation. Raises Timeout."""
        return Data(self, name).wait(generation, timeout)

    # Graphs

    @property
    def graphs(self) -> list[str]:
        """The names of the graphs that this tenant sees."""
        return [entry["graph"] for entry in self.ask("graph.list")["graphs"]]

    def graph(self, name: str) -> Graph:
        """The graph of this name; an empty one is made if there is none."""
        if name not in self.graphs:
            try:
                self.ask("graph.new", name)
            except GalaxyError:  # perhaps somebody else was faster
                if name not in self.graphs:
                    raise
        return Graph(self, name)

    def load(self, file: _Path, name: Optional[str] = None) -> Graph:
        """A graph of a state file of this machine. Its name is the file's unless told; if there is such a graph, it gets this
        document. Names of data files in it are meant as the server has them."""
        path = os.fspath(file)
        with open(path, encoding="utf-8") as text:
            try:
                document = json.load(text)
            except ValueError as e:
                raise GalaxyError(f"{path}: {e}") from None
        name = PurePath(path).stem if name is None else name
        if name in self.graphs:
            graph = Graph(self, name)
            graph.edit([{"set": [], "to": document}])
            return graph
        warn(self.ask("graph.new", name, value=document))
        return Graph(self, name)

    @property
    def catalogue(self) -> Catalogue:
        """The filters that the server has."""
        if self._catalogue is None:
            self._catalogue = Catalogue(self.ask("graph.types"))
        return self._catalogue

    # Events

    def on(self, callback: Callable[[dict[str, Any]], None], event: Optional[str] = None) -> Callable[[], None]:
        """Has a function called with each event of the server, or those whose `event` is this (docs/protocol.md, section 5). The
        server tells those of graphs that were watched, and of data that were observed. Callbacks are called one after the
        other on a thread of their own, so they may use the session; what they raise is logged. Returns a function that ends it."""
        entry = (callback, event)
        with self._lock:
            self._callbacks.append(entry)
            if self._caller is None:
                self._caller = threading.Thread(target=self._call, name="gxy callbacks", daemon=True)
                self._caller.start()

        def off() -> None:
            with self._lock:
                if entry in self._callbacks:
                    self._callbacks.remove(entry)

        return off

    def _hear(self, event: dict[str, Any]) -> None:
        with self._lock:
            wanted = bool(self._callbacks)
            for graph, view in _gone(event):
                for key, shown in self._shown.items():
                    shown.is_gone = shown.is_gone or (key[0] == graph and view in (None, key[1]))
        if wanted:
            self._events.put(event)
        self._news.tell()

    def _call(self) -> None:
        while (event := self._events.get()) is not None:
            with self._lock:
                callbacks = [callback for callback, kind in self._callbacks if kind in (None, event.get("event"))]
            for callback in callbacks:
                try:
                    callback(event)
                except Exception:  # the session is not to blame
                    logging.getLogger("galaxy").exception("a callback failed")

    open_async = twin(open)
    put_async = twin(put)
    wait_async = twin(wait)
    load_async = twin(load)

    def __repr__(self) -> str:
        return f"<Session {self._host}:{self._port}>"


def _gone(event: dict[str, Any]) -> list[tuple[str, Optional[str]]]:
    """The (graph, view) whose windows show something else after an event; all views of the graph where there is no view."""
    if event.get("event") != "graph":
        return []
    if event.get("dropped"):
        return [(event["graph"], None)]
    renamed = (edit["rename"] for edit in event.get("edits", []) if "rename" in edit)
    return [(event["graph"], path[1]) for path in renamed if path[0] == "Visualizations"]

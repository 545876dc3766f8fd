# SPDX-License-Identifier: Apache-2.0
"""Nodes of a graph: entries of its document, whose keys are attributes."""
from __future__ import annotations

import typing
from typing import Any, Optional

from .catalogue import Filter, Keys
from .client import GalaxyError
from .data import Data
from .evaluation import await_node, kind_of, status
from .waiting import Deadline, twin

if typing.TYPE_CHECKING:
    from .graph import Graph
    from .session import Session

class Node:
    """A dataset, look, view or output of a graph, by its name.

    Its properties are attributes: node.isovalue tells one, and node.isovalue = 0.4 is an edit, after which the server makes anew
    what is shown. None removes a property, which then has its default. Blanks in keys are underscores; node["minimum speed"]
    names a key as the document does. Inputs are attributes, too. From any thread; each use asks the server.
    """

    _graph: Graph
    _section: str
    _name: str

    def __init__(self, graph: Graph, section: str, name: str) -> None:
        for key, value in (("_graph", graph), ("_section", section), ("_name", name)):
            object.__setattr__(self, key, value)

    @property
    def graph(self) -> Graph:
        """What it is a node of."""
        return self._graph

    @property
    def session(self) -> Session:
        return self._graph.session

    @property
    def name(self) -> str:
        return self._name

    @property
    def section(self) -> str:
        """Datasets, Operators, Visualizations or Outputs."""
        return self._section

    @property
    def entry(self) -> dict[str, Any]:
        """What the document says of it now; a copy."""
        return self._entry_of(self._graph.document)

    def _entry_of(self, document: dict[str, Any]) -> dict[str, Any]:
        """What a document says of it."""
        for entry in document.get(self._section, []):
            if entry.get("name", entry.get("to")) == self._name:
                return entry
        raise self._error(f"is not in {self._section} of graph \"{self._graph.name}\"")

    @property
    def status(self) -> dict[str, Any]:
        """What the server tells of its evaluation (docs/graph.md, states). Looks have none."""
        return status(self._graph, kind_of(self._section), self._name)

    @property
    def state(self) -> str:
        """incomplete, blocked, waiting, queued, running, done, stale or failed."""
        return self.status["state"]

    @property
    def error(self) -> Optional[str]:
        """Why it cannot be made: what has failed, what is missing or not there; else None."""
        told = self.status
        return told.get("text", "") if told["state"] in ("failed", "incomplete", "blocked") else None

    @property
    def told(self) -> dict[str, Any]:
        """The numbers that its filter has told, such as the `area` of an isosurface_sampler."""
        return self.status.get("told", {})

    @property
    def data(self) -> Data:
        """What a filter has made last, as a dataset of the session; of a live dataset, that dataset."""
        entry = self.entry
        if self._section != "Datasets":
            raise self._error("is no dataset")
        made = "filter" in entry or "filename" in entry
        return Data(self.session, f"{self._graph.name}/{self._name}" if made else self._name)

    def wait(self, timeout: Optional[float] = None) -> Node:
        """Has it made of the newest data, and waits for that. Raises GalaxyError, with `node`, if that fails, and Timeout."""
        await_node(self._graph, kind_of(self._section), self._name, Deadline(timeout), run=True)
        return self

    def rename(self, name: str) -> None:
        """Gives it another name, also where others refer to it."""
        self._graph.edit([{"rename": [self._section, self._name], "to": name}])
        object.__setattr__(self, "_name", name)

    def remove(self) -> None:
        """Takes it out of the document. Nodes that need it become incomplete."""
        self._graph.edit([{"remove": [self._section, self._name]}])

    # Keys

    def __getitem__(self, key: str) -> Any:
        """The value of a key of the document, or its default if the server knows one, or None."""
        return self._value(self.entry, key)

    def __setitem__(self, key: str, value: Any) -> None:
        self._set([key], value)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        entry = self.entry
        filter = self._filter(entry)
        if filter and name not in filter.keys.key_of and (filter.is_input(name) or name in entry.get("inputs", {})):
            return entry.get("inputs", {}).get(name)
        try:
            return self._value(entry, self._key(entry, name))
        except GalaxyError as e:
            raise AttributeError(str(e)) from None

    def __setattr__(self, name: str, value: Any) -> None:
        own = getattr(type(self), name, None)
        if own is not None:
            if not isinstance(own, property) or own.fset is None:
                raise AttributeError(f"{name!r} of a node cannot be set")
            object.__setattr__(self, name, value)
            return
        entry = self._graph._entry_for(self)
        filter = self._filter(entry)
        if filter and (filter.is_input(name) or name in entry.get("inputs", {})) and (
                name not in filter.keys.key_of or self._graph._is_data(value)):
            self._set(["inputs", name], None if value is None else self._graph._name_of(value))
        else:
            self._set([self._key(entry, name)], value)

    __iter__ = None  # it is no list, though it has [key]

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *self._keys(self.entry).key_of})

    def _filter(self, entry: dict[str, Any]) -> Optional[Filter]:
        return self.session.catalogue.of_type(entry["filter"]) if isinstance(entry.get("filter"), str) else None

    def _keys(self, entry: dict[str, Any]) -> Keys:
        filter = self._filter(entry)
        if filter:
            return filter.keys
        if self._section == "Operators":
            return self.session.catalogue.look(str(entry.get("type", "")).replace("Vis", ""))
        return self.session.catalogue.view() if self._section == "Visualizations" else Keys("it", ())

    def _key(self, entry: dict[str, Any], name: str) -> str:
        for key in (name, name.replace("_", " ")):
            if key in entry:
                return key
        return self._keys(entry).key(name)

    def _value(self, entry: dict[str, Any], key: str) -> Any:
        return entry[key] if key in entry else self._keys(entry).default(key)

    def _set(self, path: list[str], value: Any) -> None:
        whole = [self._section, self._name, *path]
        if value is not None:
            self._graph.edit([{"set": whole, "to": value}])
        elif path[0] in (entry := self.entry) and (len(path) == 1 or path[1] in entry[path[0]]):
            self._graph.edit([{"remove": whole}])

    def _error(self, text: str) -> GalaxyError:
        return GalaxyError(f'node "{self._name}" {text}', node=self._name, path=[self._section, self._name])

    wait_async = twin(wait)

    def __repr__(self) -> str:
        return f'<{type(self).__name__} "{self._name}" of graph "{self._graph.name}">'

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Node) and (self._section, self._name, self._graph) == (other._section, other._name, other._graph)

    def __hash__(self) -> int:
        return hash((self._section, self._name, self._graph.name))

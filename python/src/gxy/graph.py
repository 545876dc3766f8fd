# SPDX-License-Identifier: Apache-2.0
"""Graphs: documents of filters, looks and views that the server keeps evaluated (docs/graph.md)."""
from __future__ import annotations

import contextlib
import os
import threading
import typing
from pathlib import PurePath
from typing import Any, Callable, Iterator, Optional, Union

from .catalogue import Filter, snake
from .client import GalaxyError
from .data import Data
from .nodes import Node
from .statements import warn
from .view import View, write_document
from .waiting import FOREVER, twin

if typing.TYPE_CHECKING:
    from .session import Session

_SECTIONS = ("Datasets", "Visualizations", "Operators", "Outputs")
_MAPS = ("colormap", "transfer function", "opacitymap", "extinctionmap")
_RADII = ("radius", "radius0", "radius1", "value0", "value1")
_Source = Union[str, Data, Node]


class Graph:
    """A graph of the server by its name. Others may look at it and edit it at the same time: each use asks the server, which orders
    the edits of all.

    Each filter of the server is a method, such as g.isosurface_sampler(s["density"], isovalue=0.3); help(g.seeds) tells its inputs and
    properties, and dir(g) has all of them. It returns a Node. From any thread.
    """

    def __init__(self, session: Session, name: str) -> None:
        self.session = session
        self.name = name
        self._batch = threading.local()
        session.ask("graph.watch", name)  # its events wake those who wait

    # The document

    @property
    def document(self) -> dict[str, Any]:
        """The document as the server has it now; a copy."""
        return self.session.ask("graph.get", self.name)["document"]

    @property
    def revision(self) -> int:
        """Counts the edits of all clients."""
        return self.session.ask("graph.get", self.name)["revision"]

    def edit(self, edits: list[dict[str, Any]], live: bool = False) -> dict[str, Any]:
        """Carries out edits (docs/graph.md), all or none. The reply has `revision` and `inverse`, the edits that undo these. Within
        edits() they are kept for its end, and the reply is empty."""
        batch: Optional[list[dict[str, Any]]] = getattr(self._batch, "edits", None)
        if batch is not None:
            batch.extend(edits)
            return {}
        reply = self.session.ask("graph.edit", self.name, value={"edits": edits, **({"live": True} if live else {})})
        warn(reply)
        return reply

    @contextlib.contextmanager
    def edits(self, live: bool = False) -> Iterator[dict[str, Any]]:
        """Within it the edits of this thread are kept; at its end they are one revision, all or none. If it ends with an exception,
        none is carried out. It gives a dict that has the reply of edit() afterwards. What is read within is what was there before."""
        if getattr(self._batch, "edits", None) is not None:
            raise GalaxyError("edits() within edits() of the same graph")
        reply: dict[str, Any] = {}
        batch: list[dict[str, Any]] = []
        self._batch.edits = batch
        try:
            yield reply
        finally:
            self._batch.edits = None
        if batch:
            reply.update(self.edit(batch, live))

    def __getitem__(self, name: str) -> Node:
        """The dataset, view, look or output of this name."""
        document = self.document
        for section in _SECTIONS:
            if name in _names(document, section):
                return (View if section == "Visualizations" else Node)(self, section, name)
        raise GalaxyError(f'graph "{self.name}": no node "{name}", expected one of '
                          f'{[name for section in _SECTIONS for name in _names(document, section)]}')

    @property
    def nodes(self) -> list[Node]:
        """All datasets, views, looks and outputs with a name."""
        document = self.document
        return [(View if section == "Visualizations" else Node)(self, section, name)
                for section in _SECTIONS for name in _names(document, section)]

    def __contains__(self, name: object) -> bool:
        document = self.document
        return any(name in _names(document, section) for section in _SECTIONS)

    def __iter__(self) -> Iterator[Node]:
        return iter(self.nodes)

    def save(self, file: Union[str, os.PathLike[str]]) -> None:
        """Writes the document to a state file of this machine, which Session.load() reads, and other programs of Galaxy, too."""
        write_document(file, self.document)

    # Nodes that are made

    def __getattr__(self, name: str) -> Callable[..., Node]:
        filters = {} if name.startswith("_") else self.session.catalogue.filters
        if name not in filters:
            raise AttributeError(f"the server has no filter {name!r}, expected one of: {', '.join(filters)}")
        return self._method(filters[name])

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *self.session.catalogue.filters})

    def _method(self, filter: Filter) -> Callable[..., Node]:
        def make(*positional: Any, name: Optional[str] = None, inputs: Optional[dict[str, Any]] = None, **keywords: Any) -> Node:
            found, properties = filter.entry(positional, inputs, keywords, self._is_data)
            sources = [data for value in found.values() for data in (value if isinstance(value, (list, tuple)) else [value])]
            entry = {"filter": filter.type, "inputs": {key: self._name_of(value) for key, value in found.items()}, **properties}
            return self._add("Datasets", name, filter.name, entry, sources)

        make.__name__ = make.__qualname__ = filter.name
        make.__doc__ = filter.doc
        make.__signature__ = filter.signature  # type: ignore[attr-defined]
        return make

    def live(self, name: str, type: str = "Volume") -> Node:
        """A dataset that the server's data space has under this name, now or later, as that of a simulation."""
        entry = next((entry for entry in self.document.get("Datasets", []) if entry.get("name") == name), {"filter": ""})
        if "filter" not in entry and "filename" not in entry:
            return Node(self, "Datasets", name)  # it is there already
        return self._add("Datasets", name, name, {"type": type}, ())

    def file(self, file: Union[str, os.PathLike[str]], type: str, *, name: Optional[str] = None, **keys: Any) -> Node:
        """A dataset that the server reads from a file, for this graph alone, when something needs it.

        file: as the server has it, absolute or relative to one of its --data folders.
        type: Volume, Particles, PathLines or Triangles.
        name: of the node; by default the file's name. A node of this name is replaced.
        keys: more keys of a dataset (docs/state-file.md), such as array="density".
        """
        known, path = self.session.catalogue.dataset(), os.fspath(file)
        entry = {"type": type, "filename": path, **{known.key(key): value for key, value in keys.items()}}
        return self._add("Datasets", name, PurePath(path).stem, entry, ())

    def volume(self, data: _Source, *, name: Optional[str] = None, **keys: Any) -> Node:
        """A look at a volume. The keys are those of an operator of docs/state-file.md with "_" for " ", such as isovalues=[0.5],
        slices=[(0, 0, 1, 0.2)], colormap="Viridis". Without isovalues and slices the volume itself is rendered. Without maps of
        values of one's own, colours, and the opacity of what is rendered, go with the range of the data. A key that is None is not
        said at all, as data_range=None: then what docs/state-file.md tells of it holds."""
        return self._look("Volume", data, name, keys)

    def particles(self, data: _Source, *, name: Optional[str] = None, **keys: Any) -> Node:
        """A look at particles: spheres, with keys such as radius=0.01. Without one, the radius suits their distances."""
        return self._look("Particles", data, name, keys)

    def path_lines(self, data: _Source, *, name: Optional[str] = None, **keys: Any) -> Node:
        """A look at lines: tubes, with keys as of particles()."""
        return self._look("PathLines", data, name, keys)

    def triangles(self, data: _Source, *, name: Optional[str] = None, **keys: Any) -> Node:
        """A look at triangles."""
        return self._look("Triangles", data, name, keys)

    def _look(self, type: str, data: _Source, name: Optional[str], keys: dict[str, Any]) -> Node:
        known = self.session.catalogue.look(type)
        entry: dict[str, Any] = {"type": type, "dataset": self._name_of(data)}
        entry.update({known.key(key): value for key, value in keys.items()})
        if type == "Volume" and not any(key in entry for key in ("volume rendering", "isovalues", "slices", "plane")):
            entry["volume rendering"] = True
        if type in ("Particles", "PathLines") and not any(key in entry for key in _RADII):
            entry["radius"] = "auto"
        if not any(key == "data range" or (key in _MAPS and not isinstance(entry[key], str)) for key in entry):
            entry["data range"] = "data"
            if entry.get("volume rendering"):
                entry["opacitymap"] = [[0, 0], [1, 0.1]]  # of that range
        entry = {key: value for key, value in entry.items() if value is not None}
        return self._add("Operators", name, snake(type), entry, [data])

    def view(self, *looks: Union[str, Node], name: Optional[str] = None, camera: Optional[dict[str, Any]] = None,
             size: Optional[tuple[int, int]] = None, **keys: Any) -> View:
        """A view of looks, which a window can show.

        camera: as in `Cameras` of docs/state-file.md; without one all data are seen.
        size: (width, height) in pixels.
        keys: more keys of a view (docs/graph.md): Lighting, follow, show, annotation.
        """
        known = self.session.catalogue.view()
        for look in looks:
            if not isinstance(look, str) and not (isinstance(look, Node) and look.section == "Operators" and look.graph == self):
                raise GalaxyError(f'found {look!r}, expected a look of graph "{self.name}", as particles() returns it')
        entry: dict[str, Any] = {"operators": [look if isinstance(look, str) else look.name for look in looks]}
        entry.update({key: value for key, value in (("camera", camera), ("size", size)) if value is not None})
        entry.update({known.key(key): value for key, value in keys.items()})
        node = self._add("Visualizations", name, "view", entry, ())
        assert isinstance(node, View)
        return node

    def output(self, type: str, of: _Source, to: str, name: Optional[str] = None) -> Node:
        """Something that the server makes of each step: a "Data file", "Pictures" of a view, or "Publish", another name of a dataset."""
        return self._add("Outputs", name, "output", {"type": type, "of": self._name_of(of), "to": to}, [of])

    def _add(self, section: str, name: Optional[str], base: str, entry: dict[str, Any], sources: typing.Iterable[Any]) -> Node:
        """Adds an entry, with live datasets for those of the session that it uses; an entry of this name is replaced."""
        while True:
            document = self.document
            chosen = name or _free(base, self._taken(document, section))
            edits = self._live(document, sources)
            live = [edit["to"]["name"] for edit in edits]
            whole = {"name": chosen, **entry}
            there = chosen in self._taken(document, section)
            edits.append({"set": [section, chosen], "to": whole} if there else {"add": [section], "to": whole})
            try:
                self.edit(edits)
            except GalaxyError:
                now = self.document
                if (name is None and chosen in _names(now, section)) or any(one in _names(now, "Datasets") for one in live):
                    continue  # somebody else has taken a name meanwhile
                raise
            return (View if section == "Visualizations" else Node)(self, section, chosen)

    def _live(self, document: dict[str, Any], sources: typing.Iterable[Any]) -> list[dict[str, Any]]:
        edits = []
        there = {entry.get("name"): entry for entry in document.get("Datasets", [])}
        there.update((name, {}) for name in self._pending("Datasets"))
        for source in sources:
            if not isinstance(source, Data):
                continue
            if source.name not in there:
                there[source.name] = {}
                edits.append({"add": ["Datasets"], "to": {"name": source.name, "type": source.type}})
            elif "filter" in there[source.name] or "filename" in there[source.name]:
                raise GalaxyError(f'"{source.name}" is a node of graph "{self.name}", expected the node or another dataset')
        return edits

    def _pending(self, section: str) -> list[str]:
        batch = getattr(self._batch, "edits", None) or []
        return [edit["to"]["name"] for edit in batch if edit.get("add") == [section]]

    def _taken(self, document: dict[str, Any], section: str) -> list[str]:
        return [*_names(document, section), *self._pending(section)]

    def _entry_for(self, node: Node) -> dict[str, Any]:
        """The node's entry, also of one that edits() is about to add."""
        for edit in getattr(self._batch, "edits", None) or []:
            if edit.get("add") == [node.section] and edit["to"]["name"] == node.name:
                return edit["to"]
        return node.entry

    @staticmethod
    def _is_data(value: Any) -> bool:
        """Whether a value of a call is a dataset, or a list of these."""
        several = value if isinstance(value, (list, tuple)) else [value]
        return len(several) > 0 and all(isinstance(one, (Data, Node)) for one in several)

    def _name_of(self, source: Any) -> Any:
        """The name that the document has for a dataset, or their list."""
        if isinstance(source, (list, tuple)):
            return [self._name_of(one) for one in source]
        if isinstance(source, Node) and source.graph != self:
            raise GalaxyError(f'node "{source.name}" is of graph "{source.graph.name}", expected one of "{self.name}", or its `data`')
        if not isinstance(source, (str, Data, Node)):
            raise GalaxyError(f"found {source!r}, expected a node, a dataset of the session, or a name")
        return source if isinstance(source, str) else source.name

    # Evaluation

    def run(self, node: Union[None, str, Node] = None) -> None:
        """Evaluates all nodes once, or one with what it needs, with the newest data; also what has failed. It does not wait."""
        self.session.ask("graph.run", self.name, *([] if node is None else [node if isinstance(node, str) else node.name]))

    def pause(self) -> None:
        """Nothing is evaluated any more but by run()."""
        self.session.ask("graph.pause", self.name)

    def resume(self) -> None:
        """Evaluates by itself again."""
        self.session.ask("graph.resume", self.name)

    def cancel(self) -> None:
        """Ends what is being evaluated, on all ranks."""
        self.session.ask("graph.cancel", self.name)

    def wait(self, timeout: Optional[float] = None) -> Graph:
        """Waits until nothing of it is being evaluated. Raises Timeout."""
        self.session.ask("graph.wait", self.name, FOREVER, timeout=timeout, limited=False)
        return self

    def drop(self) -> None:
        """The server forgets it, and what it has made."""
        self.session.ask("graph.drop", self.name)

    wait_async = twin(wait)

    def __repr__(self) -> str:
        return f'<Graph "{self.name}">'

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Graph) and (self.name, self.session) == (other.name, other.session)

    def __hash__(self) -> int:
        return hash(self.name)


def _names(document: dict[str, Any], section: str) -> list[str]:
    """The names of a section's entries; an output without one is called by what it makes."""
    return [entry.get("name", entry.get("to")) for entry in document.get(section, []) if "name" in entry or "to" in entry]


def _free(base: str, taken: list[str]) -> str:
    names = [base, *(f"{base}_{number}" for number in range(2, len(taken) + 3))]
    return next(name for name in names if name not in taken)

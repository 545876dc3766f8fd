# SPDX-License-Identifier: Apache-2.0
"""Waiting for what a graph evaluates."""
from __future__ import annotations

import contextlib
import typing
from typing import Any

from .client import GalaxyError
from .statements import statement
from .waiting import FOREVER, Deadline

if typing.TYPE_CHECKING:
    from .graph import Graph

_SECTIONS = {"dataset": "Datasets", "view": "Visualizations", "output": "Outputs"}


def kind_of(section: str) -> str:
    """What the server calls nodes of a section of the document; looks have no state, and no word."""
    return next((kind for kind, of in _SECTIONS.items() if of == section), "")


def status(graph: Graph, kind: str, name: str) -> dict[str, Any]:
    """The state of a node (docs/graph.md, states), with `paused` of its graph."""
    told = graph.session.ask("graph.get", graph.name)
    for node in told["nodes"]:
        if (node["kind"], node["node"]) == (kind, name):
            return {**node, "paused": told["paused"]}
    raise GalaxyError(f'graph "{graph.name}": no {kind or "state of"} "{name}"', node=name)


class _Idle:
    """Asks the server to tell when nothing of the graph is being evaluated any more."""

    def __init__(self, graph: Graph) -> None:
        self._client = graph.session.client
        self._number, self._reply = self._client.send(statement("graph.wait", graph.name, FOREVER))
        self._reply.add_done_callback(graph.session._news.tell)

    @property
    def is_told(self) -> bool:
        return self._reply.done()

    def cancel(self) -> None:
        if not self.is_told:
            with contextlib.suppress(GalaxyError):  # whose error is known already
                self._client.send(f"cancel {self._number}")


def await_node(graph: Graph, kind: str, name: str, deadline: Deadline, run: bool) -> None:
    """Waits until a node is done. With run, it is evaluated also if nothing needs it. Raises GalaxyError if it is not going to be
    done: it has failed, lacks something, or stays older than the document, as in a paused graph. Raises Timeout."""
    news, idle, times_idle = graph.session._news, None, 0
    try:
        while True:
            count = news.count
            is_idle = idle is not None and idle.is_told
            node = status(graph, kind, name)
            state = node["state"]
            is_stuck = state == "stale" or (state == "waiting" and node["paused"])
            if state == "done":
                return
            if run and state in ("waiting", "stale"):
                run = False
                graph.run(name)
                continue
            # Between two waves nothing is evaluated either, so that is looked at twice.
            if state in ("failed", "incomplete", "blocked") or (is_stuck and times_idle > 1):
                raise _problem(graph, node)
            if idle is None or (is_idle and is_stuck):
                idle = _Idle(graph)
                times_idle += is_idle
            news.wait(count, deadline, f'graph "{graph.name}": {kind} "{name}" is {state}, {node.get("text") or "not done"},')
    finally:
        if idle is not None:
            idle.cancel()


def _problem(graph: Graph, node: dict[str, Any]) -> GalaxyError:
    """The error of a node, which is that of the node that has caused it."""
    seen: set[str] = set()
    while node["state"] == "blocked" and "by" in node and node["by"] not in seen:
        seen.add(node["by"])
        try:
            node = status(graph, "dataset", node["by"])
        except GalaxyError:  # it is gone
            break
    text = node.get("text") or f'it needs "{node.get("by", "")}"'
    return GalaxyError(f'graph "{graph.name}": {node["kind"]} "{node["node"]}" is {node["state"]}: {text}', node=node["node"],
                       path=[_SECTIONS[node["kind"]], node["node"]], rank=node.get("rank"))

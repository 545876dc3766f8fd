# SPDX-License-Identifier: Apache-2.0
"""Galaxy for programs in Python.

    import gxy
    s = gxy.connect()                 # a Session with a running gxyserver: data, graphs, views, pictures (docs/python.md)

gxy.client is the plain client of the protocol, and gxy.insitu publishes the steps of a simulation (docs/insitu.md). Modules are
imported when they are used first, so `import gxy` itself needs neither NumPy nor a library of Galaxy.
"""
from __future__ import annotations

import importlib
from typing import Any

__version__ = "0.1.0"

_MODULE_OF = {"connect": "session", "Session": "session", "Data": "data", "Graph": "graph", "Node": "nodes", "View": "view",
              "Picture": "picture", "Client": "client", "GalaxyError": "client", "Timeout": "client"}
_MODULES = ("client", "insitu")
__all__ = list(_MODULE_OF)


def __getattr__(name: str) -> Any:
    if name in _MODULE_OF:
        return getattr(importlib.import_module("." + _MODULE_OF[name], __name__), name)
    if name in _MODULES:
        return importlib.import_module("." + name, __name__)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted([*globals(), *_MODULE_OF, *_MODULES])

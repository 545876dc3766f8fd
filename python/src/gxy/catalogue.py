# SPDX-License-Identifier: Apache-2.0
"""The filters of a server as functions: names, signatures and descriptions, made from what `graph.types` tells."""
from __future__ import annotations

import inspect
import json
import keyword
import re
from typing import Any, Callable, Iterable, Optional

from .client import GalaxyError

_LOOKS = {"volume": "Volume", "particles": "Particles", "path_lines": "PathLines", "triangles": "Triangles"}


def snake(name: str) -> str:
    """"IsosurfaceSampler" as "isosurface_sampler"."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name).lower()


def argument(key: str) -> str:
    """A key of a document as Python can say it: "minimum speed" as "minimum_speed", "from" as "from_"."""
    name = key.replace(" ", "_")
    return name + "_" if keyword.iskeyword(name) else name


class Keys:
    """Keys of one kind of entry of a document, by what Python calls them."""

    def __init__(self, what: str, keys: Iterable[dict[str, Any]]) -> None:
        self.what = what
        self.properties = list(keys)
        self.key_of = {argument(name): key["key"] for key in self.properties for name in [key["key"], *key.get("aliases", [])]}
        self._by_key = {key["key"]: key for key in self.properties}

    def __bool__(self) -> bool:
        return bool(self.properties)

    def key(self, name: str, also: Iterable[str] = ()) -> str:
        """The key that is meant. Without a list of keys, as of an older server, any is."""
        if name in self.key_of:
            return self.key_of[name]
        if not self.properties:
            return name.rstrip("_").replace("_", " ")
        raise GalaxyError(f"{self.what} has no {name!r}, expected one of: {', '.join(sorted({*self.key_of, *also}))}")

    def default(self, key: str) -> Any:
        """Its value where nothing is said, if that is a value and not only described; else None."""
        text = self._by_key.get(key, {}).get("default", "")
        try:
            return json.loads(text[1:-1]) if text.startswith("`") else None
        except ValueError:
            return None

    def parameters(self) -> list[inspect.Parameter]:
        result = []
        for key in sorted(self.properties, key=lambda key: not key["required"]):
            default = inspect.Parameter.empty if key["required"] else self.default(key["key"])
            result.append(inspect.Parameter(argument(key["key"]), inspect.Parameter.KEYWORD_ONLY, default=default))
        return result

    def lines(self) -> list[str]:
        """A line of text for each key."""
        result = []
        for key in self.properties:
            default = "required" if key["required"] else f"default: {key['default']}".replace("`", "")
            result.append(f"    {argument(key['key'])}: {key['type']} ({default}). {key['help']}")
        return result


class Filter:
    """What `graph.types` tells of one filter."""

    def __init__(self, told: dict[str, Any]) -> None:
        self.type: str = told["name"]
        self.name = snake(self.type)
        self.help: str = told["help"]
        self.makes: Optional[str] = told["makes"]
        self.inputs: list[dict[str, Any]] = [port for port in told["inputs"] if not port["any name"]]
        self.any_name: Optional[dict[str, Any]] = next((port for port in told["inputs"] if port["any name"]), None)
        self.keys = Keys(f"filter {self.type}", told["properties"])

    def is_input(self, name: str) -> bool:
        return any(port["name"] == name for port in self.inputs)

    def entry(self, positional: tuple[Any, ...], inputs: Optional[dict[str, Any]], keywords: dict[str, Any],
              is_data: Callable[[Any], bool]) -> tuple[dict[str, Any], dict[str, Any]]:
        """(inputs by name, properties by key) of a call. An argument whose name is both an input's and a property's is an input
        if it is data. Raises GalaxyError for what is unknown or missing; values are the server's to judge."""
        if len(positional) > len(self.inputs):
            raise GalaxyError(f"{self.name}(): {len(positional)} inputs without a name, expected at most {len(self.inputs)}")
        found: dict[str, Any] = {port["name"]: value for port, value in zip(self.inputs, positional)}
        properties: dict[str, Any] = {}
        for name, value in [*keywords.items(), *((name, value) for name, value in (inputs or {}).items())]:
            explicit = inputs is not None and name in inputs and value is inputs[name]
            if explicit or (is_data(value) and (self.is_input(name) or self.any_name)) or (
                    self.is_input(name) and name not in self.keys.key_of):
                if name in found:
                    raise GalaxyError(f"{self.name}(): input `{name}` is given twice")
                found[name] = value
            else:
                properties[self.keys.key(name, (port["name"] for port in self.inputs))] = value
        missing = [port["name"] for port in self.inputs if not port["optional"] and port["name"] not in found]
        missing += [key["key"] for key in self.keys.properties if key["required"] and key["key"] not in properties]
        if missing:
            raise GalaxyError(f"{self.name}(): {', '.join(f'`{name}`' for name in missing)} missing")
        return found, properties

    @property
    def signature(self) -> inspect.Signature:
        kind = inspect.Parameter
        taken = set(self.keys.key_of)
        parameters = [kind(argument(port["name"]), kind.POSITIONAL_OR_KEYWORD, default=None if port["optional"] else kind.empty)
                      for port in sorted(self.inputs, key=lambda port: port["optional"]) if argument(port["name"]) not in taken]
        parameters += [kind("name", kind.KEYWORD_ONLY, default=None), *self.keys.parameters()]
        if self.any_name or len(parameters) - 1 - len(self.keys.properties) < len(self.inputs):
            parameters.append(kind("inputs", kind.VAR_KEYWORD))
        return inspect.Signature(parameters)

    @property
    def doc(self) -> str:
        makes = f"It makes {self.makes}." if self.makes else "It makes no dataset: it tells numbers."
        ports = [f"    {port['name']}: {port['takes']}{', optional' if port['optional'] else ''}"
                 f"{', or a list of these' if port['many'] else ''}. {port['help']}" for port in self.inputs]
        if self.any_name:
            ports.append(f"    any other name: {self.any_name['takes']}. {self.any_name['help']}")
        return "\n".join([f"{self.help} {makes}", "", "inputs:", *ports, "", "properties:", *self.keys.lines(),
                          "", "name: of the node; by default one that is free. A node of this name is replaced."])


class Catalogue:
    """All filters by their names in Python, and the keys of looks and views where the server tells them."""

    def __init__(self, told: dict[str, Any]) -> None:
        self.filters = {f.name: f for f in map(Filter, told["filters"])}
        self._sections = {section["section"]: section["keys"] for section in told.get("sections", [])}

    def of_type(self, type: str) -> Optional[Filter]:
        return self.filters.get(snake(type))

    def dataset(self) -> Keys:
        """The keys that a dataset of a file has, beside its name, type and file."""
        keys = (key for key in self._sections.get("dataset", []) if key["key"] not in ("name", "type", "filename"))
        return Keys("a dataset of a file", keys)

    def look(self, type: str) -> Keys:
        """The keys that an operator of this type has."""
        keys = (key for key in self._sections.get("operator", []) if type in key.get("types", [type]))
        return Keys(f"a look of type {type}", (key for key in keys if key["key"] not in ("type", "dataset", "key")))

    def view(self) -> Keys:
        told = self._sections.get("visualization", [])
        keys = [*told, *({"key": key, "required": False, "default": "-", "type": "-", "help": ""} for key in
                         ("camera", "size", "follow", "show"))] if told else []
        return Keys("a view", (key for key in keys if key["key"] != "operators"))

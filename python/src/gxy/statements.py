# SPDX-License-Identifier: Apache-2.0
"""The text of requests, and what replies warn of."""
from __future__ import annotations

import json
import warnings
from typing import Any, Union

import numpy as np

from .client import GalaxyError


def statement(verb: str, *words: Union[str, int], value: Any = None) -> str:
    """The text of a request."""
    parts = [verb, *(json.dumps(word) for word in words)]
    return " ".join(parts if value is None else [*parts, encode(value)])


def encode(value: Any) -> str:
    """JSON, also of NumPy's numbers and arrays."""
    def convert(other: Any) -> Any:
        if isinstance(other, (np.generic, np.ndarray)):
            return other.tolist()
        raise TypeError(f"found {type(other).__name__}")

    try:
        return json.dumps(value, default=convert, allow_nan=False)
    except (TypeError, ValueError) as e:
        raise GalaxyError(f"{e}; expected what JSON has: finite numbers, texts, true or false, lists, dicts") from None


def plain(value: Any) -> Any:
    """The same in types of Python, without NumPy's."""
    return json.loads(encode(value))


def warn(reply: dict[str, Any]) -> None:
    """What the server warns of becomes a warning of Python."""
    for text in reply.get("warnings", []):
        warnings.warn(text, stacklevel=3)

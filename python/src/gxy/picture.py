# SPDX-License-Identifier: Apache-2.0
"""A picture that a server has rendered."""
from __future__ import annotations

import os
from typing import Any, Union

import numpy as np

from . import client


class Picture:
    """What View.render() returns. It is complete, and changes no more.

    array  uint8 (height, width, 4), row 0 on top: red, green, blue and opacity, not premultiplied
    end    what the server says of the frame, a dict: `generations` of the datasets that it shows, `revision` of the graph's
           document, `passes`, `seconds`
    """

    def __init__(self, array: np.ndarray, end: dict[str, Any]) -> None:
        self.array = array
        self.end = end

    @property
    def size(self) -> tuple[int, int]:
        """(width, height) in pixels."""
        return self.array.shape[1], self.array.shape[0]

    def png(self) -> bytes:
        """The picture as a PNG file, without loss."""
        return client.png(self.array[::-1])

    def save(self, path: Union[str, os.PathLike[str]]) -> None:
        """Writes a PNG file. Raises GalaxyError for a name that does not end with .png, and OSError."""
        if not os.fspath(path).lower().endswith(".png"):
            raise client.GalaxyError(f"{os.fspath(path)}: expected a name that ends with .png")
        with open(path, "wb") as file:
            file.write(self.png())

    def _repr_png_(self) -> bytes:
        return self.png()

    def __repr__(self) -> str:
        return f"<Picture {self.size[0]} x {self.size[1]}>"

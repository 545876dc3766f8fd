# SPDX-License-Identifier: Apache-2.0
"""python3 -m gxy STATE.json -o PICTURE.png: one picture of a state file, rendered by a Galaxy server.

Exit status: 0 the picture is written, 1 it could not be made, 2 wrong usage.
"""
from __future__ import annotations

import argparse
import json
import re
import sys
from typing import Any

from . import __version__


def _printable(text: str) -> str:
    """What a terminal could obey in it is replaced."""
    return "".join("\ufffd" if (c < " " and c not in "\n\t") or "\x7f" <= c <= "\x9f" else c for c in text)


def _size(text: str) -> tuple[int, int]:
    match = re.fullmatch(r"([1-9]\d*)x([1-9]\d*)", text)
    if not match:
        raise argparse.ArgumentTypeError(f"{text!r}, expected WIDTHxHEIGHT")
    return int(match[1]), int(match[2])


def _read_state(path: str) -> dict[str, Any]:
    with open(path, encoding="utf-8") as file:
        try:
            state = json.load(file)
        except (ValueError, RecursionError) as e:
            raise ValueError(f"{path}: {e}") from e
    if not isinstance(state, dict):
        raise ValueError(f"{path}: expected a JSON object, a state document")
    if state.get("Cameras") == []:
        raise ValueError(f"{path}: `Cameras` is empty, expected one or more")
    return state


def _size_of(state: dict[str, Any]) -> tuple[int, int]:
    """What the first camera says."""
    camera = state.get("Cameras", state.get("Camera", {}))
    camera = camera[0] if isinstance(camera, list) else camera
    return camera.get("dimensions", (512, 512)) if isinstance(camera, dict) else (512, 512)


def main() -> int:
    parser = argparse.ArgumentParser(prog="gxy", description="One picture of a state file, rendered by a Galaxy server.",
                                     epilog="Exit status: 0 the picture is written, 1 it could not be made, 2 wrong usage.")
    parser.add_argument("--version", action="version", version="gxy " + __version__)
    parser.add_argument("state", metavar="STATE.json", help="its first visualization and camera; names of data files "
                        "are relative to the server's --data folders")
    parser.add_argument("-o", "--output", metavar="PICTURE.png", default="picture.png", help="(default: %(default)s)")
    parser.add_argument("--server", metavar="HOST:PORT", default="localhost:5001", help="(default: %(default)s)")
    parser.add_argument("--token-file", help="file with the server's token; - for none (default: where a server on this "
                        "machine leaves it, if it does; needed for servers elsewhere)")
    parser.add_argument("--size", metavar="WIDTHxHEIGHT", type=_size, help="(default: the camera's dimensions)")
    parser.add_argument("--passes", type=int, default=1, help="so many times the state's rays per pixel")
    arguments = parser.parse_args()
    try:
        from .client import Client, GalaxyError, split_address, write_png
    except ImportError as e:
        print(f"gxy: error: {e}", file=sys.stderr)
        return 1
    try:
        host, port = split_address(arguments.server)
    except GalaxyError as e:
        parser.error(str(e))
    try:
        state = _read_state(arguments.state)
        with Client(host, port, token_file=arguments.token_file) as client:
            window = client.window(1, size=arguments.size or _size_of(state))
            for warning in window.set(state).get("warnings", []):
                print(f"gxy: warning: {_printable(warning)}", file=sys.stderr)
            picture = window.render(timeout=None, levels=[1], passes=arguments.passes)
        if picture.rgba is None:
            raise GalaxyError("the picture has come without pixels")
        write_png(arguments.output, picture.rgba)
    except (GalaxyError, OSError, ValueError) as e:
        print(f"gxy: error: {_printable(str(e))}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())

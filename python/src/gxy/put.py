# SPDX-License-Identifier: Apache-2.0
"""Arrays that go to a server: a stream of one rank and one step."""
from __future__ import annotations

import typing
from typing import Any, Optional, Union

import numpy as np

from .client import GalaxyError, Timeout
from .data import identity
from .waiting import Deadline

if typing.TYPE_CHECKING:
    from .session import Session


def put(session: Session, name: str, array: np.ndarray, origin: tuple[float, float, float],
        spacing: Union[float, tuple[float, float, float]], step: int, time: Optional[float], of: str, options: dict[str, Any],
        deadline: Deadline) -> None:
    """What Session.put() does. It waits until the dataset has one more generation."""
    from .insitu import Result, Simulation
    stream, dot, field = name.partition(".")
    if not (stream and dot and field):
        raise GalaxyError(f'name {name!r}, expected "STREAM.FIELD", as in "heat.T"')
    array = np.asarray(array)
    if array.ndim not in (3, 4) or 0 in array.shape:
        raise GalaxyError(f"array of shape {array.shape}, expected (nz, ny, nx) or (nz, ny, nx, components), none of them 0")
    if np.ndim(spacing) == 0:
        spacing = (spacing, spacing, spacing)  # type: ignore[assignment]
    before = _generation(session, name)
    try:
        with Simulation(stream, **options) as sim:
            sim.grid(size=array.shape[2::-1], origin=origin, spacing=spacing, of=of)
            sim.field(field, array)
            if sim.publish_last(step, step if time is None else time) == Result.OFF:
                raise GalaxyError("publishing is off: the environment variable GALAXY_INSITU says so")
            sim.close(1e6 if deadline.timeout is None else deadline.left())
    except OSError as e:
        raise GalaxyError(str(e)) from e
    except ValueError as e:
        raise GalaxyError(f"{name}: {e}") from e
    if _generation(session, name) == before:
        problems = [s["problem"] for s in session.ask("insitu.streams")["streams"] if s["name"] == stream and "problem" in s]
        text = f'dataset "{name}" has no new generation after {deadline.timeout or 0:g} s'
        raise Timeout("; ".join([text, *problems]))


def _generation(session: Session, name: str) -> tuple[tuple[int, int], ...]:
    """Which generation there is; none where there is no such dataset."""
    return identity(session[name].info) if name in session else ()

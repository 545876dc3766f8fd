# SPDX-License-Identifier: Apache-2.0
"""Waiting with a time limit, and methods that return a Future."""
from __future__ import annotations

import functools
import threading
import time
from concurrent.futures import Future
from typing import Any, Callable, Optional, TypeVar

from .client import Timeout

_T = TypeVar("_T")
FOREVER = 10_000_000  # seconds, the most that the server takes: time limits are those of this side


class Deadline:
    """The moment at which `timeout` seconds are over; None: never."""

    def __init__(self, timeout: Optional[float]) -> None:
        self.timeout = timeout
        self._end = None if timeout is None else time.monotonic() + timeout

    def left(self) -> Optional[float]:
        """Seconds, at least 0; None without a limit."""
        return None if self._end is None else max(0.0, self._end - time.monotonic())


class News:
    """Counts what the server has told. Who waits for something reads the count, asks the server, and if it is not there yet
    waits until there is more than that count. From any thread."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._count = 0

    @property
    def count(self) -> int:
        with self._changed:
            return self._count

    def tell(self, *_: object) -> None:
        """There is something new."""
        with self._changed:
            self._count += 1
            self._changed.notify_all()

    def wait(self, seen: int, deadline: Deadline, what: str) -> None:
        """Until there is more than `seen`. Raises Timeout, which says that `what` has not come."""
        with self._changed:
            if not self._changed.wait_for(lambda: self._count > seen, deadline.left()):
                raise Timeout(f"{what} after {deadline.timeout:g} s")


class Threads:
    """The threads of the methods that return a Future. They are daemons: none keeps Python from ending."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._running: set[threading.Thread] = set()

    def start(self, function: Callable[..., _T], *arguments: Any, **keywords: Any) -> Future[_T]:
        future: Future[_T] = Future()
        future.set_running_or_notify_cancel()

        def run() -> None:
            try:
                future.set_result(function(*arguments, **keywords))
            except BaseException as e:  # whoever has the Future is told
                future.set_exception(e)

        thread = threading.Thread(target=run, name=f"gxy {getattr(function, '__name__', 'call')}", daemon=True)
        with self._lock:
            self._running = {other for other in self._running if other.is_alive()}
            self._running.add(thread)
            thread.start()
        return future

    def join(self, deadline: Deadline) -> None:
        """Waits for all of them but the calling one, or until the deadline."""
        with self._lock:
            running = [thread for thread in self._running if thread is not threading.current_thread()]
        for thread in running:
            thread.join(deadline.left())


def twin(method: Callable[..., _T]) -> Callable[..., Future[_T]]:
    """The method as one that returns a Future at once. Its object is a session, or has one."""

    @functools.wraps(method)
    def start(self: Any, *arguments: Any, **keywords: Any) -> Future[_T]:
        future: Future[_T] = getattr(self, "session", self)._threads.start(method, self, *arguments, **keywords)
        return future

    start.__doc__ = f"As {method.__name__}(), but returns a concurrent.futures.Future of its result at once."
    start.__name__ = method.__name__ + "_async"
    return start

# SPDX-License-Identifier: Apache-2.0
"""A thread of its own for what runs by itself: others hand it requests, and what broke it is kept."""

from __future__ import annotations

import queue
import threading
from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Self

from robotskin.errors import RobotskinError

__all__ = ["OwnThread"]


class OwnThread(ABC):
    """Runs `_work` from `_begin` until `close`; what is asked of it waits until `_work` obeys.

    `_ask` and `close` may be called from any thread.
    """

    def __init__(self, name: str, error: type[RobotskinError], daemon: bool = False) -> None:
        """`name`: in error texts and of the thread. `error`: what is raised once it has ended by itself."""
        self.failure: BaseException | None = None
        """What ended it, where it ended by itself."""
        self._error = error
        self._requests: queue.SimpleQueue[Callable[[], object]] = queue.SimpleQueue()
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._run, name=name, daemon=daemon)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """End the thread, once `_work` has brought to rest what it moves."""
        self._closing.set()
        self._thread.join()

    def _begin(self) -> None:
        """Start the thread; the last thing that a constructor does."""
        self._thread.start()

    def _ask(self, request: Callable[[], object]) -> None:
        """Hand over what the thread is to do. Raises the error that was named at the start if it has ended."""
        if self.failure is not None:
            raise self._error(f"the {self._thread.name} has ended: {self.failure}")
        self._requests.put(request)

    # ---- On the thread ----

    @abstractmethod
    def _work(self) -> None:
        """Run until `_closing` is set; call `_obey` now and then."""

    def _obey(self) -> bool:
        """Do one thing that was asked for; whether there was any."""
        if self._requests.empty():
            return False
        self._requests.get()()
        return True

    def _run(self) -> None:
        try:
            self._work()
        except BaseException as failure:
            self.failure = failure
            raise

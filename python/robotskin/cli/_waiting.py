# SPDX-License-Identifier: Apache-2.0
"""What a person sees while a command works: a bar in a terminal, a plain line every some seconds elsewhere."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Protocol

LINE_S = 5.0
"""Between two lines where standard error is no terminal, such as in a log or a job of a build server."""


class Tell(Protocol):
    """Say what is done now, and which share of it, 0 to 1, is; None where that is not known."""

    def __call__(self, what: str, share: float | None = None, /) -> None:
        """Replaces what was said before."""


@contextmanager
def waiting(what: str) -> Iterator[Tell]:
    """While it is entered, standard error tells how the work goes on. `what` is done first."""
    with _bar(what) if sys.stderr.isatty() else _lines(what) as tell:
        yield tell


@contextmanager
def _bar(what: str) -> Iterator[Tell]:
    from rich.console import Console
    from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    columns = (SpinnerColumn(), TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(what, total=None)

        def tell(now: str, share: float | None = None, /) -> None:
            bar.update(task, description=now, total=None if share is None else 1.0, completed=share or 0.0)

        yield tell


@contextmanager
def _lines(what: str) -> Iterator[Tell]:
    began = time.monotonic()
    said: list[tuple[str, float | None]] = [(what, None)]
    ended = threading.Event()

    def tell(now: str, share: float | None = None, /) -> None:
        said[0] = (now, share)

    def speak() -> None:
        while not ended.wait(LINE_S):
            now, share = said[0]
            part = "" if share is None else f" ({share:.0%})"
            print(f"robotskin: {now}{part}, {time.monotonic() - began:.0f} s", file=sys.stderr, flush=True)

    thread = threading.Thread(target=speak, name="waiting", daemon=True)
    thread.start()
    try:
        yield tell
    finally:
        ended.set()
        thread.join()

# SPDX-License-Identifier: Apache-2.0
"""Something that steps in real time in a process of its own, and does what its owner asks between two steps."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import signal
from collections.abc import Callable
from multiprocessing.connection import Connection
from types import TracebackType
from typing import Any, Protocol, Self

from robotskin.errors import RobotskinError

SLICE_S = 0.01
START_S = 60.0
ANSWER_S = 20.0


class RehearsalError(RobotskinError):
    """A process of a rehearsal that did not start, or does not answer."""


class Runner(Protocol):
    """What a process runs."""

    def run(self, seconds: float) -> None:
        """Let real time pass."""

    def close(self) -> None:
        """End."""


def told(error: BaseException) -> str:
    """One line; the project's own errors are fit to be shown as they are."""
    return str(error) if isinstance(error, RobotskinError) else f"{type(error).__name__}: {error}"


def _serve(make: Callable[..., Runner], arguments: dict[str, Any], pipe: Connection) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the owner, which ends this
    parent = os.getppid()
    try:
        runner = make(**arguments)
    except BaseException as error:
        pipe.send((False, told(error)))
        return
    pipe.send((True, None))
    try:
        while os.getppid() == parent:
            runner.run(SLICE_S)
            while pipe.poll():
                asked = pipe.recv()
                if asked is None:
                    return
                try:
                    pipe.send((True, asked(runner)))
                except Exception as error:
                    pipe.send((False, told(error)))
    except EOFError:
        pass
    finally:
        runner.close()


class Process:
    """`make(**arguments)` in a process of its own, from entering on; `ask` runs a function on it.

    What is asked, and what it answers, is pickled: functions by their name. preloaded: a module that a server process
    imports once, from which this one is forked; None: it starts from nothing.
    """

    def __init__(self, make: Callable[..., Runner], *, preloaded: str | None = None, **arguments: Any) -> None:
        context: Any = multiprocessing.get_context("spawn" if preloaded is None else "forkserver")
        if preloaded is not None:
            context.set_forkserver_preload([preloaded])
        self._pipe, theirs = context.Pipe()
        self._process = context.Process(target=_serve, args=(make, arguments, theirs), daemon=True)
        self._process.start()
        theirs.close()
        try:
            self._answer(START_S)
        except BaseException:
            self.kill()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()

    @property
    def pid(self) -> int:
        """Of the process."""
        return int(self._process.pid or 0)

    def ask(self, what: Callable[[Any], Any]) -> Any:
        """Run a function on what the process runs, between two of its steps. Raises RehearsalError."""
        try:
            self._pipe.send(what)
        except (OSError, ValueError) as error:
            raise RehearsalError(f"the process has ended: {error}") from None
        return self._answer(ANSWER_S)

    def _answer(self, within_s: float) -> Any:
        try:
            if not self._pipe.poll(within_s):
                raise RehearsalError(f"the process does not answer within {within_s:.0f} s")
            good, said = self._pipe.recv()
        except (EOFError, OSError):
            raise RehearsalError("the process has ended") from None
        if not good:
            raise RehearsalError(str(said))
        return said

    def kill(self) -> None:
        """End it in the middle of whatever it does."""
        self._process.kill()
        self._process.join()
        self._pipe.close()

    def close(self) -> None:
        """End it between two steps."""
        if not self._process.is_alive():
            self._pipe.close()
            return
        with contextlib.suppress(OSError, ValueError):
            self._pipe.send(None)
        self._process.join(5.0)
        if self._process.is_alive():
            self._process.kill()
            self._process.join()
        self._pipe.close()

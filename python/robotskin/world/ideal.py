# SPDX-License-Identifier: Apache-2.0
"""Which world is made where none is asked for: the imperfect one, or within `ideal_world` the ideal one."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

from robotskin.simulator import Imperfections

_ideal: ContextVar[bool] = ContextVar("ideal_world", default=False)


@contextmanager
def ideal_world(on: bool = True) -> Iterator[None]:
    """Within it, worlds that are not told otherwise are ideal ones: what `--ideal` asks for.

    Sensors keep noise, offset, scale and drift; all else is just as the models say. Worlds are told when they are made,
    so a session made here stays ideal.
    """
    token = _ideal.set(on)
    try:
        yield
    finally:
        _ideal.reset(token)


def make_ideal(on: bool) -> None:
    """The same for all that follows: what a worker process takes over from the one that began it."""
    _ideal.set(on)


def is_ideal() -> bool:
    """Whether the code runs within `ideal_world`."""
    return _ideal.get()


def default_imperfections() -> Imperfections:
    """Those of a world that is not told otherwise."""
    return Imperfections.ideal() if _ideal.get() else Imperfections()

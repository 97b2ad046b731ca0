# SPDX-License-Identifier: Apache-2.0
"""Which world is made where none is asked for: the imperfect one, or within `ideal_world` the ideal one; and whether
its cells take their time."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

from robotskin.simulator import Imperfections, Processor

_ideal: ContextVar[bool] = ContextVar("ideal_world", default=False)
_taking_time: ContextVar[bool] = ContextVar("cells_take_time", default=True)


@contextmanager
def ideal_world(on: bool = True) -> Iterator[None]:
    """Within it, worlds that are not told otherwise are ideal ones: what `--ideal` asks for.

    Sensors keep noise, offset, scale and drift; all else is just as the models say, and cells compute in no time.
    Worlds are told when they are made, so a session made here stays ideal.
    """
    token = _ideal.set(on)
    try:
        yield
    finally:
        _ideal.reset(token)


@contextmanager
def cells_take_time(on: bool = True) -> Iterator[None]:
    """Within it, cells of worlds that are not told otherwise and not ideal have a processor, or compute in no time:
    what `--ideal-processors` asks for."""
    token = _taking_time.set(on)
    try:
        yield
    finally:
        _taking_time.reset(token)


def asked_for() -> tuple[bool, bool]:
    """What worker processes take over: whether the world is ideal, and whether cells take their time."""
    return _ideal.get(), _taking_time.get()


def make_as_asked(ideal: bool, taking_time: bool) -> None:
    """The same for all that follows in a worker process."""
    _ideal.set(ideal)
    _taking_time.set(taking_time)


def is_ideal() -> bool:
    """Whether the code runs within `ideal_world`."""
    return _ideal.get()


def default_imperfections() -> Imperfections:
    """Those of a world that is not told otherwise."""
    return Imperfections.ideal() if _ideal.get() else Imperfections()


def default_processor() -> Processor:
    """That of cells of a world that is not told otherwise: 48 MHz with one flash wait state.

    None in the ideal world, and within `cells_take_time(False)`.
    """
    return Processor.one_wait_state if _taking_time.get() and not _ideal.get() else Processor.none

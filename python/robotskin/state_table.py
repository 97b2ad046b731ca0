# SPDX-License-Identifier: Apache-2.0
"""A table of states: what leads from one to the next, a row each."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

__all__ = ["Row", "following_row"]


class Moment(Protocol):
    """What a row looks at."""

    @property
    def since_s(self) -> float:
        """Seconds in the present state."""


State = TypeVar("State")
Seen = TypeVar("Seen", bound=Moment)


@dataclass(frozen=True)
class Row(Generic[State, Seen]):
    """A row of the table: after at least `after_s`, and where `holds`, `state` becomes `then`; at `latest_s` anyway."""

    state: State
    holds: Callable[[Seen], bool]
    then: State
    because: str
    after_s: float = 0.0
    latest_s: float = float("inf")


def following_row(table: Sequence[Row[State, Seen]], state: State, seen: Seen) -> Row[State, Seen] | None:
    """The first row of a state that fits a moment; None: the state stays."""
    for row in table:
        if row.state is state and seen.since_s >= row.after_s and (row.holds(seen) or seen.since_s >= row.latest_s):
            return row
    return None

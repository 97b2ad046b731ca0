# SPDX-License-Identifier: Apache-2.0
"""Arms whose cells are lost: they would squeeze harder for want of what they feel, so they open instead."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol, TypeVar

from robotskin.state_table import Row

LOST_SHARE = 0.2
"""Of an area's cells: where more are not alive, arms open, whether those felt something or not."""
AREA_WORDS = {"left": "left arm", "right": "right arm", "chest": "chest"}


class SeenLost(Protocol):
    """A moment that tells which areas have lost cells."""

    @property
    def since_s(self) -> float:
        """Seconds in the present state."""

    @property
    def lost_areas(self) -> frozenset[str]:
        """Areas with a cell that felt something and is lost, or with too few that are alive."""


State = TypeVar("State")
Seen = TypeVar("Seen", bound=SeenLost)


def lost_rows(states: Sequence[State], then: State, _of: type[Seen]) -> list[Row[State, Seen]]:
    """Rows that lead from each of these states to `then` where an area has lost cells, each with its reason."""
    return [_row(state, area, then) for state in states for area in AREA_WORDS]


def _row(state: State, area: str, then: State) -> Row[State, Seen]:
    return Row(state, lambda seen: area in seen.lost_areas, then, f"cells of the {AREA_WORDS[area]} are lost")

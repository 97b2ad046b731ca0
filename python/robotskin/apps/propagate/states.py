# SPDX-License-Identifier: Apache-2.0
"""What the robot is seen to do, from touch and base alone, and what leads from one state to the next."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from robotskin.state_table import Row, following_row

AWAY_M = 0.005
"""A base that is nearer than this to its place counts as at rest there."""
FELT_N = 0.35


class State(StrEnum):
    """Of the application."""

    WAITING = "waits for a touch"
    ARM_GIVES = "the arm gives way"
    BASE_GIVES = "the base gives way, too"
    RETURNING = "the base goes back"


@dataclass(frozen=True)
class Seen:
    """Of one moment. felt_n: newton on all cells, nearness included; base_m: how far the base is from its place."""

    felt_n: float
    base_m: float
    since_s: float = 0.0

    @property
    def touched(self) -> bool:
        """Whether a cell feels anything."""
        return self.felt_n > FELT_N

    @property
    def away(self) -> bool:
        """Whether the base has left its place."""
        return self.base_m > AWAY_M


TABLE: tuple[Row[State, Seen], ...] = (
    Row(State.WAITING, lambda seen: seen.touched, State.ARM_GIVES, "touched"),
    Row(State.ARM_GIVES, lambda seen: seen.away and seen.touched, State.BASE_GIVES, "the base leaves its place"),
    Row(State.ARM_GIVES, lambda seen: not seen.touched, State.RETURNING, "let go"),
    Row(State.BASE_GIVES, lambda seen: not seen.touched, State.RETURNING, "let go"),
    Row(State.BASE_GIVES, lambda seen: not seen.away, State.ARM_GIVES, "the base is at its place"),
    Row(State.RETURNING, lambda seen: seen.touched, State.ARM_GIVES, "touched"),
    Row(State.RETURNING, lambda seen: not seen.away, State.WAITING, "the base is at its place"),
)
"""The first row of a state that fits is taken, one a moment."""


def following(state: State, seen: Seen) -> State:
    """The state after a moment."""
    row = following_row(TABLE, state, seen)
    return state if row is None else row.then

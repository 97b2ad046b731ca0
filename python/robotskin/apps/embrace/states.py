# SPDX-License-Identifier: Apache-2.0
"""What the arms do one after the other when they hug, and what leads from one state to the next."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from robotskin.apps.embrace.lost import lost_rows
from robotskin.apps.embrace.pressed import OUTSIDE, TOO_HARD
from robotskin.state_table import Row, following_row


class State(StrEnum):
    """Of a hug."""

    OPEN = "opens its arms"
    CLOSE = "closes its arms around the person"
    HOLD = "holds the person"
    RELEASE = "lets go"
    RELEASED = "has let go"


@dataclass(frozen=True)
class Seen:
    """Of one moment, told by the skin alone but for `open`, which the arms' own references tell.

    since_s: in this state. regulated: the arms answer to the skin. open, closed: both arms are at that end of their
    paths. arms, chest: each feels the person. outside: a cell where no contact is allowed is pressed. too_hard: a cell
    is pressed harder than is allowed. lost_areas: those of which cells are lost, see `lost.py`.
    """

    since_s: float
    regulated: bool
    open: bool
    closed: bool
    arms: bool
    chest: bool
    outside: bool
    too_hard: bool
    asked_to_release: bool
    lost_areas: frozenset[str] = frozenset()


TABLE: tuple[Row[State, Seen], ...] = (
    Row(State.OPEN, lambda seen: seen.asked_to_release, State.RELEASE, "asked to let go"),
    Row(State.OPEN, lambda seen: seen.open, State.CLOSE, "the arms are open", 1.0),
    Row(State.CLOSE, lambda seen: seen.asked_to_release, State.RELEASE, "asked to let go"),
    *lost_rows((State.CLOSE, State.HOLD), State.RELEASE, Seen),
    Row(State.CLOSE, lambda seen: seen.outside, State.RELEASE, OUTSIDE),
    Row(State.CLOSE, lambda seen: seen.regulated and seen.too_hard, State.RELEASE, TOO_HARD),
    Row(
        State.CLOSE, lambda seen: seen.regulated and seen.arms and seen.chest, State.HOLD, "both arms and chest feel it"
    ),
    Row(State.CLOSE, lambda seen: not seen.regulated and seen.closed, State.HOLD, "at the end of the paths"),
    Row(State.CLOSE, lambda seen: False, State.RELEASE, "the person was not found", latest_s=30.0),
    Row(State.HOLD, lambda seen: seen.asked_to_release, State.RELEASE, "asked to let go"),
    Row(State.HOLD, lambda seen: seen.outside, State.RELEASE, OUTSIDE),
    Row(State.HOLD, lambda seen: seen.regulated and seen.too_hard, State.RELEASE, TOO_HARD),
    Row(
        State.HOLD, lambda seen: seen.regulated and not seen.arms and not seen.chest, State.RELEASE, "nothing felt", 1.0
    ),
    Row(State.RELEASE, lambda seen: seen.open, State.RELEASED, "the arms are open"),
    Row(State.RELEASED, lambda seen: False, State.OPEN, "asked to hug again"),
)
"""The first row of a state that fits is taken, one a moment."""


def following(state: State, seen: Seen) -> tuple[State, str]:
    """The state after a moment, and why it is another one."""
    row = following_row(TABLE, state, seen)
    return (state, "") if row is None else (row.then, row.because)

# SPDX-License-Identifier: Apache-2.0
"""What the hand does one after the other, and what leads from one state to the next."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from robotskin.state_table import Row, following_row


class State(StrEnum):
    """Of a grasp."""

    BRINGING = "is brought to the thing, open"
    OPENING = "opens"
    SURVEY = "looks for the thing with each finger"
    MOVING = "moves to where the thing is"
    APPROACH = "comes near with each finger"
    TOUCHING = "touches, one finger waiting for the other"
    CLOSING = "closes along its path, whatever it feels"
    SQUEEZE = "squeezes to each finger's share"
    HOLD = "holds"
    RELEASE = "lets go"
    RELEASED = "has let go"
    LOST = "has lost the thing"


@dataclass(frozen=True)
class Seen:
    """Of one moment.

    since_s: in this state. lost: a finger's pad is lost, or a cell that felt something. The others are what a finger,
    or all fingers, have reached.
    """

    since_s: float
    reactive: bool
    brought: bool
    open: bool
    surveyed: bool
    near: bool
    touching: bool
    closed: bool
    risen: bool
    held: bool
    asked_to_release: bool
    lost: bool = False


TABLE: tuple[Row[State, Seen], ...] = (
    Row(State.BRINGING, lambda seen: seen.brought, State.OPENING, "there"),
    Row(State.OPENING, lambda seen: seen.open and seen.reactive, State.SURVEY, "open", 0.5),
    Row(State.OPENING, lambda seen: seen.open, State.CLOSING, "open, and goes by its belief alone", 0.5),
    *(
        Row(state, lambda seen: seen.reactive and seen.lost, State.RELEASE, "cells of a finger are lost")
        for state in (State.SURVEY, State.MOVING, State.APPROACH, State.TOUCHING, State.SQUEEZE)
    ),
    Row(State.SURVEY, lambda seen: seen.surveyed, State.MOVING, "every finger is near, or the time is over", 0.3, 2.5),
    Row(State.MOVING, lambda seen: True, State.APPROACH, "moved to the estimate", 0.6),
    Row(State.APPROACH, lambda seen: seen.near, State.TOUCHING, "every finger is 4 mm away or touches", 0.2, 3.0),
    Row(State.TOUCHING, lambda seen: seen.touching, State.SQUEEZE, "every finger touches", 0.0, 5.0),
    Row(State.CLOSING, lambda seen: seen.closed, State.HOLD, "at the end of its path"),
    Row(State.SQUEEZE, lambda seen: seen.asked_to_release, State.RELEASE, "asked to let go"),
    Row(State.SQUEEZE, lambda seen: seen.risen, State.HOLD, "the force has risen", 1.6, 8.0),
    Row(State.HOLD, lambda seen: seen.asked_to_release, State.RELEASE, "asked to let go"),
    Row(State.HOLD, lambda seen: not seen.held, State.LOST, "fewer than two fingers feel it", 0.3),
    Row(State.LOST, lambda seen: seen.asked_to_release, State.RELEASE, "asked to let go"),
    Row(State.RELEASE, lambda seen: seen.open, State.RELEASED, "open", 0.5),
    Row(State.RELEASED, lambda seen: False, State.BRINGING, "asked to grasp again"),
)
"""The first row of a state that fits is taken, one a moment."""


def following(state: State, seen: Seen) -> tuple[State, str]:
    """The state after a moment, and why it is another one."""
    row = following_row(TABLE, state, seen)
    return (state, "") if row is None else (row.then, row.because)

# SPDX-License-Identifier: Apache-2.0
"""What the arms do one after the other when they take a large thing, and what leads from state to state (V-C)."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from robotskin.apps.embrace.lost import lost_rows
from robotskin.apps.embrace.pressed import BLOCKED, OUTSIDE, TOO_HARD
from robotskin.state_table import Row, following_row


class GraspState(StrEnum):
    """Of a grasp with both arms: the paper's four."""

    OPEN = "opens its arms, and waits for a touch on its chest"
    CLOSE = "closes its arms around the thing"
    PULL = "pulls the thing to its chest"
    HOME = "holds the thing at its chest"


@dataclass(frozen=True)
class GraspSeen:
    """Of one moment, told by the skin alone but for `open` and `blocked`.

    since_s: in this state. reactive: the paths adapt to what the skin feels. open: the arms are wide open. closed:
    stiff arms are at the end of their path. asked: a script or a page asked since this state began, or, in OPEN alone,
    the chest was touched and let go. arms, chest: what feels the thing, both arms or the chest. firm: all areas have
    felt what they should for a while. lost: none feels anything. outside: a cell where no contact is allowed is
    pressed. too_hard: a cell is pressed harder than is allowed. blocked: an arm does not come where it is told.
    lost_areas: those of which cells are lost, see `lost.py`.
    """

    since_s: float
    reactive: bool
    open: bool
    closed: bool
    asked: bool
    arms: bool
    chest: bool
    firm: bool
    lost: bool
    outside: bool = False
    too_hard: bool = False
    blocked: bool = False
    lost_areas: frozenset[str] = frozenset()


OPEN, CLOSE, PULL, HOME = GraspState.OPEN, GraspState.CLOSE, GraspState.PULL, GraspState.HOME
GRASP_TABLE: tuple[Row[GraspState, GraspSeen], ...] = (
    Row(OPEN, lambda seen: seen.asked and seen.open, CLOSE, "touched on the chest, or asked", 0.5),
    *(Row(state, lambda seen: seen.asked, OPEN, "asked to open") for state in (CLOSE, PULL)),
    *lost_rows((CLOSE, PULL, HOME), OPEN, GraspSeen),
    *(Row(state, lambda seen: seen.reactive and seen.outside, OPEN, OUTSIDE) for state in (CLOSE, PULL, HOME)),
    *(Row(state, lambda seen: seen.reactive and seen.too_hard, OPEN, TOO_HARD) for state in (CLOSE, PULL, HOME)),
    Row(CLOSE, lambda seen: seen.reactive and seen.blocked, OPEN, BLOCKED),
    Row(CLOSE, lambda seen: seen.reactive and seen.arms, PULL, "both arms feel it"),
    Row(CLOSE, lambda seen: not seen.reactive and seen.closed, PULL, "at the end of the taught path"),
    Row(CLOSE, lambda seen: False, OPEN, "no contact, or with one arm only", latest_s=8.0),
    Row(PULL, lambda seen: seen.reactive and seen.firm, HOME, "both arms and the chest hold it"),
    Row(PULL, lambda seen: seen.reactive and seen.lost, OPEN, "lost while it was pulled", 0.5),
    Row(PULL, lambda seen: not seen.reactive, HOME, "at the end of the taught path", 3.0),
    Row(PULL, lambda seen: False, OPEN, "the chest was not reached", latest_s=10.0),
    Row(HOME, lambda seen: seen.asked, OPEN, "asked to open", 1.0),
    Row(HOME, lambda seen: seen.reactive and seen.lost, OPEN, "dropped", 0.5),
)
"""The first row of a state that fits is taken, one a moment."""


def following_grasp(state: GraspState, seen: GraspSeen) -> tuple[GraspState, str]:
    """The state after a moment, and why it is another one."""
    row = following_row(GRASP_TABLE, state, seen)
    return (state, "") if row is None else (row.then, row.because)

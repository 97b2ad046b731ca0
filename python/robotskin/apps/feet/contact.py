# SPDX-License-Identifier: Apache-2.0
"""Touchdown and lift-off of one foot from its cells alone: states as a table, scuffs told apart."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from robotskin.apps.feet.exoskeleton import REGIONS, Region
from robotskin.apps.feet.settings import Nearness, Settings

Array = NDArray[np.float64]
LEAST_SWING_S = 0.15
"""A foot that was lifted does not land, and no landing is announced, before so long."""
LEAST_STANCE_S = 0.1
"""A foot that landed does not leave before so long: soft cells may feel nothing while the sole still settles."""
APPROACH_S = 0.03
"""Time constant of the speed towards the ground."""
LEAVES_SHARE, LEAVES_M_S = 1.5, 0.05
"""Of the distance at which a landing is announced, and the speed, at which one is no longer expected."""


BEYOND_TOES = REGIONS != Region.FRONT
REST_S = 0.3
"""Time constant of what the accelerometers say of a foot that stands."""


class State(StrEnum):
    """Of one foot."""

    UNKNOWN = "not known"
    SWINGS = "in the air"
    TOUCHES = "touches something"
    STANDS = "on the ground"


@dataclass(frozen=True)
class Felt:
    """What the seven cells of a sole say at one moment; arrays have the cell axis first."""

    time_s: float
    force_n: Array
    """(7,)"""
    distance_m: Array
    """(7,) to what is near, inf where nothing is."""
    acceleration: Array
    """(7, 3) m/s², cell frame."""
    heard: NDArray[np.bool_]
    """(7,) the cell is alive and its sample young."""


@dataclass(frozen=True)
class Event:
    """Something that happened to a foot.

    kind: touchdown, lift-off, stays (the last lift-off was none), scuff, announced (a landing), taken back,
    not heard (no cell of the sole is; what the foot does is not known).
    """

    time_s: float
    kind: str


@dataclass
class Evidence:
    """What is known when the next state is chosen."""

    touched: bool
    """A cell is pressed."""
    free: bool
    """No cell has been pressed for a while in which the sole was heard."""
    beyond_toes: bool
    """A cell of centre or back is pressed."""
    lasts: bool
    """The touch is older than a scuff, and the sole was heard for as long."""
    young: bool
    """The foot was lifted so short a time ago that it cannot have made a step."""
    fresh: bool
    """The foot landed so short a time ago that it cannot have left again."""
    calm: bool
    """The foot's accelerometers have been at rest for a while."""


# When a foot that is heard again landed or left is not known, so neither is told.
TABLE: tuple[tuple[State, Callable[[Evidence], bool], State, str], ...] = (
    (State.UNKNOWN, lambda e: e.touched and (e.beyond_toes or e.lasts or e.calm), State.STANDS, ""),
    (State.UNKNOWN, lambda e: e.free, State.SWINGS, ""),
    (State.SWINGS, lambda e: e.touched and e.young, State.STANDS, "stays"),
    (State.SWINGS, lambda e: e.touched and e.beyond_toes, State.STANDS, "touchdown"),
    (State.SWINGS, lambda e: e.touched, State.TOUCHES, ""),
    (State.TOUCHES, lambda e: e.free, State.SWINGS, "scuff"),
    (State.TOUCHES, lambda e: e.beyond_toes or e.lasts or e.calm, State.STANDS, "touchdown"),
    (State.STANDS, lambda e: e.free and not e.fresh, State.SWINGS, "lift-off"),
)
"""State, condition, next state, event; the first row of a state that fits is taken, one a moment.

It is asked while at least one cell of the sole is heard. A cell that is not heard counts as not pressed.
"""


class FootContact:
    """Follows one foot. Feed `update` with every reading; it tells what happened, and `state` is what is so now."""

    def __init__(self, settings: Settings) -> None:
        self.settings = settings
        self.state = State.UNKNOWN
        self.force_n = np.zeros(7)
        """(7,) newton of each cell above its zero; 0 where it is not heard."""
        self.announced = False
        self._zero = np.zeros(7)
        self._most = np.zeros(7)
        self._pressed = np.zeros(7, dtype=bool)
        self.since_s = -np.inf
        """Since when it swings, touches or stands; where that is not known, when it was last not heard."""
        self._pressed_s = self._lifted_s = self._landed_s = -np.inf
        self._rest: Array | None = None
        self._calm_since_s = np.inf
        self._last_s: float | None = None
        self._approach = Approach(settings.nearness)

    def update(self, felt: Felt) -> list[Event]:
        """What this reading tells: none, one or two events."""
        if self._last_s is None:
            self._last_s = self.since_s = self._pressed_s = felt.time_s
        step = felt.time_s - self._last_s
        self._last_s = felt.time_s
        if not felt.heard.any():
            return self._lose(felt, step)
        evidence = self._look(felt, step)
        events = []
        for state, holds, following, kind in TABLE:
            if state is self.state and holds(evidence):
                if kind:
                    events.append(Event(felt.time_s, kind))
                self.since_s = felt.time_s
                if kind == "lift-off":
                    self._lifted_s = felt.time_s
                if kind == "touchdown":
                    self._landed_s = felt.time_s
                if following is State.SWINGS:
                    self._most[:] = 0
                self.state = following
                break
        away = self.state is not State.SWINGS or felt.time_s - self._lifted_s < LEAST_SWING_S
        self._approach.update(felt, step)
        if self.announced:
            self.announced = not (away or self._approach.leaves)
            if not self.announced and self.state is State.SWINGS:
                events.append(Event(felt.time_s, "taken back"))
        elif self._approach.lands and not away:
            self.announced = True
            events.append(Event(felt.time_s, "announced"))
        return events

    def _lose(self, felt: Felt, step: float) -> list[Event]:
        """No cell is heard: whatever was so may be so no more."""
        known, self.state = self.state is not State.UNKNOWN, State.UNKNOWN
        self.force_n = np.zeros(7)
        self._pressed[:] = False
        # What lasts or is free has to be heard to be so, from now on.
        self.since_s = self._pressed_s = felt.time_s
        self._calm_since_s = np.inf
        self._approach.update(felt, step)
        self.announced = False
        return [Event(felt.time_s, "not heard")] if known else []

    def _look(self, felt: Felt, step: float) -> Evidence:
        touch = self.settings.touch
        self.force_n = np.maximum(felt.force_n - self._zero, 0.0) * felt.heard
        off_n = np.maximum(touch.off_share * touch.on_n, touch.residue_share * self._most)
        self._pressed = self.force_n > np.where(self._pressed, off_n, touch.on_n)
        self._most = np.maximum(self._most, self.force_n)
        touched = bool(self._pressed.any())
        if touched:
            self._pressed_s = felt.time_s
        elif self.state is State.SWINGS:
            self._zero += min(step / touch.zero_s, 1.0) * (felt.force_n - self._zero) * felt.heard
        return Evidence(
            touched=touched,
            free=felt.time_s - self._pressed_s >= touch.free_s,
            beyond_toes=bool(self._pressed[BEYOND_TOES].any()),
            lasts=touched and felt.time_s - self.since_s > touch.front_alone_s,
            young=felt.time_s - self._lifted_s < LEAST_SWING_S,
            fresh=felt.time_s - self._landed_s < LEAST_STANCE_S,
            calm=touched and self._is_calm(felt, step),
        )

    def _is_calm(self, felt: Felt, step: float) -> bool:
        """Whether the accelerometers have long been as they are where the foot stands."""
        now = felt.acceleration[felt.heard].mean(axis=0)
        if self._rest is None:
            self._rest = now
        if self.state is State.STANDS:
            self._rest = self._rest + min(step / REST_S, 1.0) * (now - self._rest)
        away = now - self._rest
        if float(away @ away) > self.settings.touch.calm_m_s2**2:
            self._calm_since_s = np.inf
        elif self._calm_since_s == np.inf:
            self._calm_since_s = felt.time_s
        return felt.time_s - max(self._calm_since_s, self.since_s) > self.settings.touch.calm_s


class Approach:
    """Whether the ground comes near: from how far it is, and how fast that shrinks."""

    def __init__(self, settings: Nearness) -> None:
        self._settings = settings
        self._distance_m = np.inf
        self._speed = 0.0
        self.lands = False
        """The foot would be on the ground soon."""
        self.leaves = False
        """The ground is out of reach, or goes away."""

    def update(self, felt: Felt, step: float) -> None:
        """Take the next reading."""
        heard = felt.distance_m[felt.heard]
        nearest = float(heard.min()) if len(heard) else np.inf
        if nearest == np.inf or self._distance_m == np.inf or step <= 0:
            self._speed = 0.0
        else:
            share = min(step / APPROACH_S, 1.0)
            self._speed += share * ((self._distance_m - nearest) / step - self._speed)
        self._distance_m = nearest
        self.lands = nearest < self._settings.within_m and nearest < self._settings.ahead_s * self._speed
        self.leaves = nearest > LEAVES_SHARE * self._settings.within_m or self._speed < -LEAVES_M_S

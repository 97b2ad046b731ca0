# SPDX-License-Identifier: Apache-2.0
"""Three motors that vibrate on the arm: what drives them, and simulated ones."""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from robotskin.apps.feet.exoskeleton import Region

Array = NDArray[np.float64]
STEPS = 255
"""Of the pulse width."""


class Vibrators(Protocol):
    """Three motors on the arm: front, centre, back."""

    def set_duty(self, duty: Array) -> None:
        """(3,) 0 to 1."""


class SimulatedVibrators:
    """Motors with an unbalanced weight: below a duty they do not turn, and they need time to start and to stop.

    A driver's watchdog stops them when no duty has come for `WATCHDOG_S`. Nothing brakes a motor that is told 0.
    """

    DEAD_DUTY = 0.17
    START_S, STOP_S = 0.030, 0.040
    WATCHDOG_S = 0.1
    RUNS_DOWN_S = STOP_S * math.log(1 / DEAD_DUTY)
    """From full speed to the slowest at which a motor turns, without a duty."""

    def __init__(self) -> None:
        self.strength = np.zeros(len(Region))
        """(3,) what the wearer feels, 1: full speed."""
        self.duty = np.zeros(len(Region))
        """(3,) as told last; 0 once nothing was told for long."""
        self._told_s = -np.inf
        self._now_s = 0.0

    @property
    def still(self) -> NDArray[np.bool_]:
        """(3,) slower than the slowest speed at which a motor that is driven turns."""
        return self.strength < self.DEAD_DUTY

    def set_duty(self, duty: Array) -> None:
        """(3,) 0 to 1."""
        self.duty = np.array(duty)
        self._told_s = self._now_s

    def step(self, now_s: float) -> None:
        """Let time pass until `now_s`."""
        seconds, self._now_s = now_s - self._now_s, now_s
        if now_s - self._told_s > self.WATCHDOG_S:
            self.duty = np.zeros(len(Region))
        goal = np.where(self.duty > self.DEAD_DUTY, self.duty, 0.0)
        settles = np.where(goal > self.strength, self.START_S, self.STOP_S)
        self.strength += np.minimum(seconds / settles, 1.0) * (goal - self.strength)

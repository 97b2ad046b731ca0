# SPDX-License-Identifier: Apache-2.0
"""What carries the hand, on a carriage or an arm: brought to the thing, up and down smoothly, and shaken."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from robotskin.apps.grasp.fingers import LIFT, PALM_FROM_HAND, base_from_hand
from robotskin.robots import Robot
from robotskin.tasks import CartesianTask

Array = NDArray[np.float64]

BEHIND_M, BRING_M_S = 0.15, 0.075
"""An arm begins with the hand so far behind the place of the grasp, against where the palm looks, and brings it there
at this mean speed."""


def grasp_place(robot: Robot, home: Array) -> Array:
    """(3,) metres, base axes: where the origin of the hand's frame is while it grasps. Its axes are the base's."""
    ahead = 0.0 if LIFT in robot.joint_names else BEHIND_M
    return np.asarray(base_from_hand(robot, home)[:3, 3] + [ahead, 0.0, 0.0])


class Carriage:
    """A reference of position and velocity. It begins at a place and rests."""

    def __init__(self, position_m: float = 0.0) -> None:
        self.position_m = position_m
        self._from_m = self._to_m = 0.0
        self._since_s = self._lasts_s = 0.0
        self._amplitude_m = self._hertz = self._shaken_s = self._shakes_s = 0.0

    def go(self, position_m: float, speed_m_s: float = 0.1) -> None:
        """Go there, the mean speed given; it starts and ends at rest."""
        self._from_m, self._to_m, self._since_s = self.position_m, position_m, 0.0
        self._lasts_s = abs(position_m - self.position_m) / speed_m_s

    def shake(self, acceleration_m_s2: float, hertz: float, seconds: float) -> None:
        """Swing about where it is, up to this acceleration, after a rise of one swing."""
        self._amplitude_m, self._hertz = acceleration_m_s2 / (2 * np.pi * hertz) ** 2, hertz
        self._shaken_s, self._shakes_s = 0.0, seconds

    @property
    def rests(self) -> bool:
        """Whether it has arrived and is not shaken."""
        return self._since_s >= self._lasts_s and self._shaken_s >= self._shakes_s

    def step(self, period_s: float) -> tuple[float, float]:
        """The reference after a period: metres and m/s."""
        before = self.position_m + self._swing()
        self._since_s = min(self._since_s + period_s, self._lasts_s)
        self._shaken_s = min(self._shaken_s + period_s, self._shakes_s)
        share = 1.0 if self._lasts_s == 0 else self._since_s / self._lasts_s
        self.position_m = self._from_m + (self._to_m - self._from_m) * share * share * (3 - 2 * share)
        now = self.position_m + self._swing()
        return now, (now - before) / period_s

    def _swing(self) -> float:
        if self._shaken_s >= self._shakes_s:
            return 0.0
        rise = min(1.0, self._shaken_s * self._hertz, (self._shakes_s - self._shaken_s) * self._hertz)
        return float(rise * self._amplitude_m * np.sin(2 * np.pi * self._hertz * self._shaken_s))


class Carrier(Protocol):
    """Moves the hand."""

    @property
    def brought(self) -> bool:
        """Whether the hand is at the place of the grasp."""

    def step(self, up_m: float, up_m_s: float, period_s: float) -> tuple[Array, Array]:
        """The references after a period: (k,) of its joints, and of their speeds; the hand is to be so high."""


class OnCarriage:
    """A hand that is at its place, on a joint that lifts it."""

    brought = True

    def step(self, up_m: float, up_m_s: float, period_s: float) -> tuple[Array, Array]:
        """See `Carrier`."""
        return np.array([up_m]), np.array([up_m_s])


class OnArm:
    """A hand on an arm, which a Cartesian task moves.

    That task takes no speed, and its damper would hold the hand back: the place it is given is ahead by what the
    damper takes, so that K (x_r + D/K x_r' - x) - D x' = K (x_r - x) + D (x_r' - x').

    Args:
        task: of the palm.
        place: (3,) metres, `grasp_place`.
        resting: (k,) rad of the arm's joints, which no joint task holds.
        lead_s: D/K.
    """

    def __init__(self, task: CartesianTask, place: Array, resting: Array, lead_s: float) -> None:
        self._task, self._place, self._resting, self._lead_s = task, place, resting, lead_s
        self._ahead = Carriage(-BEHIND_M)
        self._ahead.go(0.0, BRING_M_S)

    @property
    def brought(self) -> bool:
        """Whether the reference has arrived, and the hand is within 2 mm of it."""
        return self._ahead.rests and float(np.abs(np.asarray(self._task.error)[:3]).max()) < 0.002

    def step(self, up_m: float, up_m_s: float, period_s: float) -> tuple[Array, Array]:
        """See `Carrier`."""
        ahead_m, ahead_m_s = self._ahead.step(period_s)
        pose = np.linalg.inv(PALM_FROM_HAND)
        pose[:3, 3] = self._place + [ahead_m, 0.0, up_m] + self._lead_s * np.array([ahead_m_s, 0.0, up_m_s])
        self._task.request_reference(pose)
        return self._resting, np.zeros(len(self._resting))

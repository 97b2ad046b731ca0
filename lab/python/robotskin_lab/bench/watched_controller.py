# SPDX-License-Identifier: Apache-2.0
"""A rehearsed UR controller that notes how long its arm goes on moving, and how fast."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robotskin.rehearsal import FakeController, Process
from robotskin.rehearsal.ur_controller import REST_RAD_S
from robotskin.robots import Robot, load
from robotskin.robots.gains import gains_of

Floats = NDArray[np.float64]


class WatchedController(FakeController):
    """Notes since `mark`; all times are the controller's."""

    _marked_at = _last_moved_at = 0
    fastest = np.zeros(6)
    """(6) rad/s of each joint since the mark."""

    def __init__(self, robot: Robot, home: Floats, host: str) -> None:
        super().__init__(robot, home, host)
        self._home = home

    def step(self) -> None:
        """As of any controller."""
        super().step()
        speed = np.abs(self.arm.velocity)
        self.fastest = np.maximum(self.fastest, speed)
        if speed.max() > REST_RAD_S:
            self._last_moved_at = self.steps

    def mark(self) -> float:
        """From now on it is noted; rad/s of the fastest joint."""
        self._marked_at = self._last_moved_at = self.steps
        self.fastest = np.abs(self.arm.velocity)
        return float(self.fastest.max())

    def go_home(self) -> None:
        """Back to where it began."""
        self.arm.place(self._home)

    @property
    def moving_s(self) -> float:
        """From the mark until the arm moved last."""
        return (self._last_moved_at - self._marked_at) * self.settings.step_s

    @property
    def rested_s(self) -> float:
        """Since the arm moved last."""
        return (self.steps - self._last_moved_at) * self.settings.step_s


def make(robot: str, host: str) -> WatchedController:
    """In the process that shall run it."""
    model = load(robot)
    return WatchedController(model, gains_of(model).home, host)


def watched_controller(robot: str, host: str) -> Process:
    """Start one at an address of this machine. Raises RehearsalError if it cannot be had."""
    return Process(make, robot=robot, host=host)

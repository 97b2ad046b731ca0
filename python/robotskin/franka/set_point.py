# SPDX-License-Identifier: Apache-2.0
"""Set points that a Franka's controller takes: without jumps of position, speed or acceleration.

libfranka stops the robot by a reflex where a set point's derivatives exceed its limits. The limits here are the lower
ones of Panda and Research 3, with a tenth to spare.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]
JOINTS = 7
SPARE = 0.9
SPEED = SPARE * np.array([2.175, 2.175, 2.175, 2.175, 2.61, 2.61, 2.61])
"""rad/s."""
ACCELERATION = SPARE * np.array([10.0, 7.5, 10.0, 10.0, 10.0, 10.0, 10.0])
"""rad/s²."""
JERK = SPARE * np.array([5000.0, 3750.0, 5000.0, 5000.0, 5000.0, 5000.0, 5000.0])
"""rad/s³."""
TORQUE_RATE = SPARE * 1000.0
"""Nm/s."""
LAG_S, SPEED_LAG_S = 0.02, 0.008
"""With which positions and speeds are followed, where no limit is reached."""
REST_RAD_S, REST_RAD_S2 = 1e-3, 0.5


class SetPoint:
    """Positions (7,) rad with their derivatives, led towards positions or speeds."""

    def __init__(self, position: ArrayLike) -> None:
        self.position: Floats = np.array(position, dtype=float)
        self.velocity, self.acceleration = np.zeros(JOINTS), np.zeros(JOINTS)

    def towards_position(self, aim: Floats, seconds: float) -> Floats:
        """Where it is after a time on the way to (7,) rad."""
        error = aim - self.position
        braking = np.sqrt(ACCELERATION * np.abs(error))
        fastest = np.minimum(SPEED, braking)
        self.towards_velocity(np.clip(error / LAG_S, -fastest, fastest), seconds)
        return self.position

    def towards_velocity(self, aim: Floats, seconds: float) -> Floats:
        """How fast it is after a time on the way to (7,) rad/s."""
        aim = np.clip(aim, -SPEED, SPEED)
        wanted = np.clip((aim - self.velocity) / SPEED_LAG_S, -ACCELERATION, ACCELERATION)
        most = JERK * seconds
        self.acceleration = self.acceleration + np.clip(wanted - self.acceleration, -most, most)
        self.velocity = self.velocity + self.acceleration * seconds
        self.position = self.position + self.velocity * seconds
        return self.velocity

    @property
    def at_rest(self) -> bool:
        """Whether a motion may end here."""
        slow = np.abs(self.velocity).max() < REST_RAD_S
        return bool(slow and np.abs(self.acceleration).max() < REST_RAD_S2)


def led_torque(before: Floats, aim: Floats, seconds: float) -> Floats:
    """Nm (7,) after a time on the way from one torque to another."""
    most = TORQUE_RATE * seconds
    return before + np.clip(aim - before, -most, most)

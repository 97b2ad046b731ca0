# SPDX-License-Identifier: Apache-2.0
"""How a standing robot's soles are tilted against level ground, as encoders and inertial unit tell it.

The robot as built is not quite its model, and its unit is not quite level. So the tilt of each sole is off by an angle
that hardly changes. It is learnt from whatever follows from the tilt: a Kalman filter of four angles.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robotskin.model import ImuReading, RobotDynamics, SensorPlace
from robotskin.robots import Robot
from robotskin.robots.standing import BASE_JOINTS

Array = NDArray[np.float64]
_UNIT_S = 20.0
"""In which "up" follows the unit's own orientation, which wanders; until then it follows the turn rates."""
_RATE_S = 0.015
"""In which the rate follows that of a tilt."""
_OWN_RAD, _COMMON_RAD = 7e-3, 5e-3
"""σ of what is not known at first: of the legs, of each foot its own; of the unit, of both feet the same."""
_OWN_RAD_SQRT_S, _COMMON_RAD_SQRT_S = 1e-4, 3e-4
"""How fast they wander."""


class FootTilts:
    """Of each of two soles: how many metres it rises for a metre along x and along y of its foot's frame, (2, 2)."""

    def __init__(self, robot: Robot, unit: SensorPlace) -> None:
        """`robot`: the model; one that stands. `unit`: where its inertial unit is."""
        standing = robot.standing
        assert standing is not None
        self._core = robot.core
        self._dynamics = RobotDynamics(robot.core)
        self._links = [robot.link_index(link) for link in (unit.link, *(foot.link for foot in standing.feet))]
        self._link_from_unit = np.array(unit.link_from_sensor)[:3, :3]
        self._up: Array | None = None
        self._last: Array | None = None
        self._turning = np.zeros((2, 2))
        self._off = np.zeros(4)
        # Of both tilts of the one foot, then of the other.
        own, common = np.eye(4), np.tile(np.eye(2), (2, 2))
        self._wander = _OWN_RAD_SQRT_S**2 * own + _COMMON_RAD_SQRT_S**2 * common
        self._unsure = _OWN_RAD**2 * own + _COMMON_RAD**2 * common

    def hear(self, unit: ImuReading, period_s: float) -> None:
        """Each reading of the inertial unit, and the time since the one before."""
        told, rates = np.array(unit.up_from_sensor[6:]), np.array(unit.angular_velocity)
        if not np.isfinite([*told, *rates]).all():
            return
        if self._up is None:
            self._up = told
        up = self._up - period_s * np.cross(rates, self._up)
        up += period_s / _UNIT_S * (told - up)
        self._up = up / np.linalg.norm(up)

    def update(self, joints: Array, period_s: float) -> None:
        """At positions (n) of the joints, rad, and the time since the update before."""
        tilts = self._by_model(joints)
        if tilts is None:
            return
        if self._last is not None:
            share = period_s / (period_s + _RATE_S)
            self._turning += share * ((tilts - self._last) / period_s - self._turning)
        self._last = tilts
        self._unsure += period_s * self._wander

    def tilts(self, ahead_s: float = 0.0) -> Array | None:
        """(2, 2) of each sole; None before it is known. `ahead_s`: so much later, as they turn now."""
        return None if self._last is None else self._last + ahead_s * self._turning + self._off.reshape(2, 2)

    @property
    def unsure(self) -> Array:
        """(2, 2) rad^2, variance of each of the tilts' offsets."""
        return np.diag(self._unsure).reshape(2, 2).copy()

    def learn(self, foot: int, wrong: Array, slope: Array, sigma: Array) -> None:
        """From a measure (2,) of what follows from a foot's tilt.

        Args:
            foot: 0 or 1.
            wrong: (2,) how far the measure is from what the tilt makes it.
            slope: (2, 2) of the measure, for a radian of each tilt.
            sigma: (2,) of the measure.
        """
        rows = np.zeros((2, 4))
        rows[:, 2 * foot : 2 * foot + 2] = slope
        gain = np.linalg.solve(rows @ self._unsure @ rows.T + np.diag(sigma**2), rows @ self._unsure).T
        self._off += gain @ wrong
        self._unsure -= gain @ rows @ self._unsure

    def _by_model(self, joints: Array) -> Array | None:
        position = np.array(joints)
        position[: len(BASE_JOINTS)] = 0.0
        if self._up is None or not np.isfinite(position).all():
            return None
        self._dynamics.update(position, np.zeros_like(position))
        unit, *feet = (self._turn_of(link) for link in self._links)
        return np.array([(foot.T @ unit @ self._link_from_unit @ self._up)[:2] for foot in feet])

    def _turn_of(self, link: int) -> Array:
        joint = self._core.link_joints[link]
        base_from_joint = np.eye(3) if joint < 0 else self._dynamics.base_from_joint[joint, :3, :3]
        return np.asarray(base_from_joint @ self._core.joint_from_link[link, :3, :3])

# SPDX-License-Identifier: Apache-2.0
"""Both arms of Talos around an upright axis before the chest: the paths on which they close, from the model alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from robotskin.robots import Robot
from robotskin.session import SessionError

Array = NDArray[np.float64]

SIDES = ("left", "right")
CHEST = "torso_2_link"
TRUNK = ("torso_1_joint", "torso_2_joint")
"""Joints that turn and bend both arms and the chest."""
_BENDS = TRUNK[1]
_ELBOW, _WRIST = "arm_left_4_link", "arm_left_7_link"
_FOREARM_M = 0.266
"""From elbow to wrist."""
_BEGIN = np.array([-0.9, 0.5, 0.5, -1.8])
_MIRRORED = np.array([-1, -1, -1, 1, -1, -1, -1.0])
"""Of the left arm's joints, what makes the right arm's of them."""
_STEP_M = 0.01
_TURNS = 4
"""By which the nearest place on a path is found: it bends between two of its postures."""
_OPENS_FROM_M = 0.20
"""Radius from which on the arms turn outward."""
_FROM_END_RAD = 0.08
"""Kept from the ends of joints, since what the arms hold bends them."""
_TURNS_WITH_HAND = 4
"""Joints of an arm before those that turn the hand alone."""
_HAND = 5
"""Of an arm's joints, the one that turns the hand outward."""


@dataclass(frozen=True)
class Around:
    """How the arms lie around an upright axis.

    height_m: of the middle of the forearms above the chest's joint, elbow_below_m: of the elbow under it. angle_deg:
    where the middle of a forearm stands, from straight ahead; open_angle_deg: the same for open arms. hand_rad: by
    which the hands turn outward.
    """

    height_m: float = 0.11
    elbow_below_m: float = 0.02
    angle_deg: float = 72.0
    open_angle_deg: float = 80.0
    hand_rad: float = 0.0


@dataclass(frozen=True, eq=False)
class Paths:
    """Joints by where the forearms lie.

    axis_m: (A,) metres of the axis before the chest's joint, rising. radius_m: (S,) metres between the axis and the
    middle of a forearm, rising; close to the chest joints end before it lies there. angles: of each side (A, S, 7) rad.
    """

    axis_m: Array
    radius_m: Array
    angles: dict[str, Array]

    def at(self, side: str, radius_m: float, axis_m: float) -> Array:
        """(7,) rad of an arm whose forearm is this far from an axis that far before the chest's joint."""
        table = self.angles[side]
        row, over = _place(self.axis_m, axis_m)
        column, beyond = _place(self.radius_m, radius_m)
        near, far = (one[column] + beyond * (one[column + 1] - one[column]) for one in (table[row], table[row + 1]))
        return np.asarray(near + over * (far - near))

    def radius_near(self, side: str, angles: Array, radius_m: float, axis_m: float) -> float:
        """Metres between the axis and the forearm of an arm with these (7,) rad, on its path beside a given radius."""
        for _ in range(_TURNS):
            here = self.at(side, radius_m, axis_m)
            along = self.at(side, radius_m + _STEP_M, axis_m) - here
            share = float(along @ (angles - here) / max(float(along @ along), 1e-12))
            radius_m = float(np.clip(radius_m + share * _STEP_M, self.radius_m[0], self.radius_m[-1]))
        return radius_m


def _place(values: Array, value: float) -> tuple[int, float]:
    """Which interval of rising values holds it, and where in it, 0 to 1."""
    place = float(np.interp(value, values, np.arange(len(values))))
    low = min(int(place), len(values) - 2)
    return low, place - low


class Arms:
    """The two arms of a robot.

    Args:
        home: (n) rad.
        lean_rad: how far the trunk is bent forward from there.

    Raises:
        SessionError: a robot that has no such arms.
    """

    def __init__(self, robot: Robot, home: Array, lean_rad: float = 0.0) -> None:
        names = [f"arm_{side}_{number}_joint" for side in SIDES for number in range(1, 8)]
        missing = [name for name in names if name not in robot.joint_names]
        if missing:
            raise SessionError(f"embrace with {robot.name}: it has no joint {missing[0]}; use talos or talos_standing")
        self.robot, self.home = robot, home.copy()
        self.home[robot.joint_index(_BENDS)] += lean_rad
        self.origin = robot.base_from_link(home)[robot.link_index(CHEST)][:3, 3]
        """(3,) metres of the chest's joint, in the base's frame at home."""
        self.joints = {
            side: np.array([robot.joint_index(f"arm_{side}_{n}_joint") for n in range(1, 8)]) for side in SIDES
        }
        """Of each side, the indices of its seven joints, from the shoulder."""
        self.both = np.concatenate([self.joints[side] for side in SIDES])
        """(14,) indices of the joints of both arms, side by side."""

    def plan(
        self,
        around: Around,
        axis_m: tuple[float, ...] = (0.165, 0.225, 0.285, 0.345, 0.405),
        radius_m: tuple[float, ...] = (0.10, 0.13, 0.16, 0.20, 0.25, 0.30, 0.35),
    ) -> Paths:
        """Paths for forearms at these radii around axes at these places; the right arm mirrors the left one."""
        joints = self.joints["left"][:_TURNS_WITH_HAND]
        lower, upper = self.robot.lower[joints] + _FROM_END_RAD, self.robot.upper[joints] - _FROM_END_RAD
        table = np.zeros((len(axis_m), len(radius_m), len(_MIRRORED)))
        angles = _BEGIN
        for row, axis in enumerate(axis_m):
            for column in range(len(radius_m))[::-1]:
                radius = radius_m[column]
                share = np.clip((radius - _OPENS_FROM_M) / (radius_m[-1] - _OPENS_FROM_M), 0, 1)
                turn = np.radians(around.angle_deg + share * (around.open_angle_deg - around.angle_deg))
                begin = table[row - 1, column, :_TURNS_WITH_HAND] if row else angles
                elbow, wrist = forearm_lies(around, axis, radius, turn)
                angles = self._reached(self.origin + elbow, self.origin + wrist, begin, lower, upper)
                table[row, column, :_TURNS_WITH_HAND] = angles
                table[row, column, _HAND] = around.hand_rad
        return Paths(np.array(axis_m), np.array(radius_m), {"left": table, "right": table * _MIRRORED})

    def posture(self, paths: Paths, radius_m: dict[str, float], axis_m: float) -> Array:
        """(n) rad: home, with each arm where its path says."""
        posture = self.home.copy()
        for side, joints in self.joints.items():
            posture[joints] = paths.at(side, radius_m[side], axis_m)
        return posture

    def _reached(self, elbow: Array, wrist: Array, begin: Array, lower: Array, upper: Array) -> Array:
        """(4,) rad that bring the left elbow and wrist there, or as near as the joints reach."""
        robot, posture = self.robot, self.home.copy()
        at = [robot.link_index(name) for name in (_ELBOW, _WRIST)]
        joints = self.joints["left"]
        posture[joints[_TURNS_WITH_HAND:]] = 0.0

        def away(angles: Array) -> Array:
            posture[joints[:_TURNS_WITH_HAND]] = angles
            places = robot.base_from_link(posture)[at][:, :3, 3]
            return np.concatenate([4 * (places[0] - elbow), 10 * (places[1] - wrist), 0.02 * (angles - begin)])

        found = least_squares(away, np.clip(begin, lower + 1e-3, upper - 1e-3), bounds=(lower, upper))
        return np.asarray(found.x)


def forearm_lies(around: Around, axis_m: float, radius_m: float, turn_rad: float) -> tuple[Array, Array]:
    """(3,) metres of the left elbow and wrist from the chest's joint; the forearm lies along the tangent."""
    towards = np.array([np.cos(turn_rad), np.sin(turn_rad)])
    middle = np.array([axis_m, 0.0]) + radius_m * towards
    along = np.array([np.sin(turn_rad), -np.cos(turn_rad)]) * _FOREARM_M / 2
    elbow = np.array([*(middle - along), around.height_m - around.elbow_below_m])
    wrist = np.array([*(middle + along), around.height_m + around.elbow_below_m])
    return elbow, wrist

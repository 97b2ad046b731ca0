# SPDX-License-Identifier: Apache-2.0
"""Postures that bring the gripper's middle to a place of the world, looking down as it does at home."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robotskin.model import RobotDynamics
from robotskin.robots import Robot
from robotskin.teaching.gripper import HAND, Gripper, TeachingError

Array = NDArray[np.float64]

STEPS, DAMPING = 200, 0.01
NEAR_M = 5e-4
TO_HOME = 0.1
"""Of a step, the share of the way to home that an arm of more than six joints goes in what the hand leaves free. Else
the arm would wander, and a short way of the hand between two postures would swing aside."""
TURNS_BACK_RAD = 0.004
"""Largest turn towards looking down in one shift, about each axis: joints may have tilted the gripper."""


class Postures:
    """Finds postures by damped least squares from one that is near. home: (n) rad or m, whose direction is kept."""

    def __init__(self, robot: Robot, gripper: Gripper, home: Array) -> None:
        self.robot, self.gripper = robot, gripper
        self._dynamics = RobotDynamics(robot.core)
        self._hand = robot.link_index(HAND)
        self.home = np.array(home, dtype=float)
        self._turn = self._pose(self.home)[:3, :3].copy()
        # The gripper looks straight down, turned about the vertical as at home.
        ahead = np.array([0.0, 0.0, -1.0])
        side = self._turn[:, 0] - ahead * (ahead @ self._turn[:, 0])
        side /= np.linalg.norm(side)
        self._turn = np.column_stack([side, np.cross(ahead, side), ahead])

    def _pose(self, posture: Array) -> Array:
        self._dynamics.update(np.ascontiguousarray(posture), np.zeros(len(posture)))
        return np.array(self._dynamics.base_from_link(self._hand))

    def place_of(self, posture: Array) -> Array:
        """(3) metres, base frame: the point between the pads."""
        return np.asarray((self._pose(posture) @ self.gripper.hand_from_middle)[:3])

    def shifted(self, posture: Array, by_m: Array) -> Array:
        """(n) the posture with the pads' middle moved by a small (3) metres and the gripper turned to look down."""
        pose, error = self._pose(posture), np.empty(6)
        error[:3], error[3:] = by_m, np.clip(0.1 * self._turn_left(pose), -TURNS_BACK_RAD, TURNS_BACK_RAD)
        moved = posture.copy()
        moved[self.gripper.arm] += self._step(pose, error)
        return np.clip(moved, self.robot.lower, self.robot.upper)

    def _turn_left(self, pose: Array) -> Array:
        turn = self._turn @ pose[:3, :3].T
        return 0.5 * np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])

    def _part(self, pose: Array) -> Array:
        """(6, arm's joints) how they move the pads' middle and turn the hand, after `_pose` of the posture."""
        jacobian = np.array(self._dynamics.link_jacobian(self._hand))
        lever = pose[:3, :3] @ self.gripper.hand_from_middle[:3]
        # The point's velocity is that of the link's origin and of its turn.
        jacobian[:3] += np.cross(jacobian[3:].T, lever).T
        return np.asarray(jacobian[:, self.gripper.arm])

    def _step(self, pose: Array, error: Array) -> Array:
        """Of the arm's joints, by damped least squares, after `_pose` of the posture."""
        part = self._part(pose)
        return np.asarray(part.T @ np.linalg.solve(part @ part.T + DAMPING**2 * np.eye(6), error))

    def _step_to_home(self, pose: Array, posture: Array) -> Array:
        """Of the arm's joints, without moving the hand."""
        arm = self.gripper.arm
        way = TO_HOME * (self.home - posture)[arm]
        return way - self._step(pose, self._part(pose) @ way)

    def at(self, place_m: Array, start: Array) -> Array:
        """(n) the posture for a place of the pads' middle; the pads stay as in `start`.

        Raises TeachingError where the robot does not reach it.
        """
        arm = self.gripper.arm
        best, left = np.array(start, dtype=float), np.inf
        for begin in (start, self.home):
            posture = np.array(begin, dtype=float)
            for _ in range(STEPS):
                pose = self._pose(posture)
                error = np.empty(6)
                error[:3] = place_m - (pose @ self.gripper.hand_from_middle)[:3]
                error[3:] = self._turn_left(pose)
                distance = float(np.linalg.norm(error))
                if distance < left:
                    best, left = posture.copy(), distance
                if distance < 1e-5:
                    break
                step = self._step(pose, error)
                if len(arm) > 6:
                    step += self._step_to_home(pose, posture)
                posture[arm] = np.clip(
                    posture[arm] + np.clip(step, -0.2, 0.2), self.robot.lower[arm], self.robot.upper[arm]
                )
            if left < NEAR_M:
                break
        if left >= NEAR_M:
            at = ", ".join(f"{value:.3f}" for value in place_m)
            raise TeachingError(
                f"{self.robot.name} does not reach {at} m with its gripper looking down: {1e3 * left:.0f} mm are left"
            )
        best[self.gripper.joints] = start[self.gripper.joints]
        return best

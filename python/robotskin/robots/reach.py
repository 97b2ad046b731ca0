# SPDX-License-Identifier: Apache-2.0
"""How near the hand of a robot can get to a point."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from robotskin.model import RobotDynamics

if TYPE_CHECKING:
    from robotskin.robots.robot import Robot

Array = NDArray[np.float64]

STARTS, STEPS = 8, 80
DAMPING_M = 0.03


def nearest_to(robot: Robot, link: str, point_m: Array, start: Array) -> tuple[Array, float]:
    """The posture (n) within the limits that brings the origin of a link nearest to a point, and what is left, m.

    Damped least squares from `start` and from postures drawn the same each time; ends at once where it arrives.

    Args:
        robot: n joints.
        link: its name.
        point_m: (3) base frame.
        start: (n) rad or m.
    """
    dynamics = RobotDynamics(robot.core)
    row = robot.link_index(link)
    random = np.random.default_rng(0)
    best, least = np.asarray(start, dtype=float), np.inf
    for number in range(STARTS):
        q = np.asarray(start, dtype=float) if number == 0 else robot.random_posture(random)
        for _ in range(STEPS):
            dynamics.update(np.ascontiguousarray(q), np.zeros(len(q)))
            error = point_m - dynamics.base_from_link(row)[:3, 3]
            left = float(np.linalg.norm(error))
            if left < least:
                best, least = q.copy(), left
            if left < 1e-4:
                return best, least
            jacobian = dynamics.link_jacobian(row)[:3]
            # Joints that stand at a limit and would pass it are left out.
            gram = jacobian @ jacobian.T + DAMPING_M**2 * np.eye(3)
            step = jacobian.T @ np.linalg.solve(gram, error)
            stuck = ((q <= robot.lower) & (step < 0)) | ((q >= robot.upper) & (step > 0))
            free = np.where(stuck, 0.0, jacobian)
            step = free.T @ np.linalg.solve(free @ free.T + DAMPING_M**2 * np.eye(3), error)
            q = np.clip(q + np.clip(step, -0.3, 0.3), robot.lower, robot.upper)
    return best, least

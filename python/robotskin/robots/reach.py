# SPDX-License-Identifier: Apache-2.0
"""How near a link of a robot can get to a point."""

from __future__ import annotations

from collections.abc import Callable, Collection

import numpy as np
from numpy.typing import NDArray

from robotskin.model import BASE, JointKind, RobotDynamics, RobotModel
from robotskin.robots.standing import BASE_JOINTS, feet_of

Array = NDArray[np.float64]

STARTS, STEPS = 8, 80
DAMPING_M, ARRIVED_M = 0.03, 1e-4


def nearest_to(
    robot: RobotModel,
    link: str,
    point_m: Array,
    start: Array,
    joints: Collection[str] = (),
    fits: Callable[[Array], bool] = lambda posture: True,
) -> tuple[Array, float]:
    """The posture (n) within the limits that brings the origin of a link nearest to a point, and what is left, m.

    Damped least squares from `start` and from postures drawn the same each time; ends at once where it arrives. The
    base of a robot on feet has no motor: it stays where it is.

    Args:
        robot: n joints.
        link: its name.
        point_m: (3) base frame.
        start: (n) rad or m.
        joints: those that may move, by name; by default all.
        fits: of postures (n) that arrive; the first that arrives is returned where none fits.
    """
    dynamics = RobotDynamics(robot)
    row = robot.link_index(link)
    random = np.random.default_rng(0)
    start = np.array(start, dtype=float)
    moves = _moving(robot, row, joints)
    best, least = start, np.inf
    for number in range(STARTS):
        q = start.copy()
        if number:
            q[moves] = _drawn(robot, random)[moves]
        for _ in range(STEPS):
            dynamics.update(np.ascontiguousarray(q), np.zeros(len(q)))
            error = point_m - dynamics.base_from_link(row)[:3, 3]
            left = float(np.linalg.norm(error))
            if left < ARRIVED_M and fits(q):
                return q, left
            if left < least and least >= ARRIVED_M:
                best, least = q.copy(), left
            if left < ARRIVED_M:
                break
            jacobian = np.where(moves, dynamics.link_jacobian(row)[:3], 0.0)
            # Joints that stand at a limit and would pass it are left out.
            gram = jacobian @ jacobian.T + DAMPING_M**2 * np.eye(3)
            step = jacobian.T @ np.linalg.solve(gram, error)
            stuck = ((q <= robot.lower) & (step < 0)) | ((q >= robot.upper) & (step > 0))
            free = np.where(stuck, 0.0, jacobian)
            step = free.T @ np.linalg.solve(free @ free.T + DAMPING_M**2 * np.eye(3), error)
            q = np.where(moves, np.clip(q + np.clip(step, -0.3, 0.3), robot.lower, robot.upper), q)
    return best, least


def _moving(robot: RobotModel, link: int, joints: Collection[str]) -> NDArray[np.bool_]:
    """(n) whether a joint carries the link and may move."""
    held = BASE_JOINTS if feet_of(robot) else ()
    moves = np.zeros(robot.joint_count, dtype=bool)
    joint = robot.link_joints[link]
    while joint != BASE:
        name = robot.joint_names[joint]
        moves[joint] = (not joints or name in joints) and name not in held
        joint = robot.joint_parents[joint]
    return moves


def _drawn(robot: RobotModel, generator: np.random.Generator) -> Array:
    """(n) a posture within the limits; joints without any between -π and π rad, or -1 and 1 m."""
    slides = np.array([kind == JointKind.prismatic for kind in robot.joint_kinds])
    ends = np.where(slides, 1.0, np.pi)
    lower = np.where(np.isfinite(robot.lower), robot.lower, -ends)
    upper = np.where(np.isfinite(robot.upper), robot.upper, ends)
    return generator.uniform(lower, upper)

# SPDX-License-Identifier: Apache-2.0
"""Postures in which a robot presses a cell against a fixed, vertical post, and what its joints feel of that."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robotskin.calibration.force_sensors import Array
from robotskin.layout import Layout
from robotskin.model import RobotDynamics
from robotskin.robots import Robot
from robotskin.robots.free_space import FreeSpace
from robotskin.robots.gains import gains_of

LEAST_LEVER_NM_PER_N = 0.1
"""Of the joint that feels most: less is lost in the noise of the torques."""
CLOSE_M = 0.005
"""So close a drawn posture must bring a cell to the post; the rest is the press itself."""
LEVEL = 0.65
"""The cell's normal may rise or fall by so much: the sine of the angle."""
ROOM_M, BESIDE_M = 0.01, 0.06
"""Room between the post and other cells, but for those beside the pressed one."""


@dataclass(frozen=True)
class AtPost:
    """One cell at the post. position: (n,) rad; lever_nm_per_n: (n,) torque of a newton on the cell; at_m: (3,)."""

    cell: int
    position: Array
    lever_nm_per_n: Array
    at_m: Array


class Levers:
    """What the joints feel of a newton on each cell."""

    def __init__(self, robot: Robot, layout: Layout) -> None:
        self._robot, self._layout = robot, layout
        self._links = np.array([robot.link_index(name) for name in layout.links])[layout.link]
        self._moves = _moves(robot)[np.asarray(robot.core.link_joints)[self._links]]
        self._dynamics = RobotDynamics(robot.core)

    def at(self, position: Array) -> tuple[Array, Array, Array]:
        """(N, n) torque of a newton on each cell, (N, 3) places, (N, 3) outward normals, base frame, metres."""
        base_from_cell = self._robot.base_from_link(position)[self._links] @ self._layout.link_from_cell
        at, normal = base_from_cell[:, :3, 3], base_from_cell[:, :3, 2]
        self._dynamics.update(position, np.zeros(self._robot.joint_count))
        motion = self._dynamics.joint_motions  # (n, 6) linear at the base's origin, then angular
        velocity = motion[None, :, :3] + np.cross(motion[None, :, 3:], at[:, None, :])
        return -np.einsum("ncj,nj->nc", velocity, normal) * self._moves, at, normal


def postures_at_post(
    robot: Robot, layout: Layout, *, distance_m: float = 0.5, radius_m: float = 0.02, draws: int = 20000, seed: int = 1
) -> dict[int, AtPost]:
    """For each cell that can be brought to the post, the posture of those drawn whose joints feel most of it.

    Args:
        robot, layout: N cells. distance_m: of the post's axis from the base's. radius_m: of the post.
        draws: random postures; more find a few cells more.

    The first joint turns about the base's axis, so what counts is how far a cell is from that axis; the joint turns it
    to the post. Postures in which links or other cells meet the post, the floor or each other are left out.
    """
    draw = np.random.default_rng([seed, 41])
    space = FreeSpace(robot, floor_m=0.0, home=gains_of(robot).home)
    levers = Levers(robot, layout)
    best: dict[int, tuple[float, AtPost]] = {}
    for _ in range(draws):
        position = draw.uniform(space.lower, space.upper)
        lever, at, normal = levers.at(position)
        level = np.linalg.norm(normal[:, :2], axis=1)
        axis = at[:, :2] + radius_m * normal[:, :2] / np.maximum(level, 1e-6)[:, None]
        felt = np.abs(lever).max(axis=1)
        close = np.abs(np.linalg.norm(axis, axis=1) - distance_m) < CLOSE_M
        close &= (np.abs(normal[:, 2]) < LEVEL) & (felt > LEAST_LEVER_NM_PER_N)
        better = [cell for cell in np.flatnonzero(close).tolist() if cell not in best or felt[cell] > best[cell][0]]
        if not better or not space.is_free(position):
            continue
        for cell in better:
            others = np.linalg.norm(at - at[cell], axis=1) > BESIDE_M
            if (np.linalg.norm(at[others, :2] - axis[cell], axis=1) > radius_m + ROOM_M).all():
                best[cell] = (felt[cell], AtPost(cell, position, lever[cell], at[cell]))
    return {cell: found for cell, (_, found) in sorted(best.items())}


def _moves(robot: Robot) -> Array:
    """(n + 1, n) 1 where a joint moves what hangs on another; the last row is of what no joint moves."""
    parents = np.asarray(robot.core.joint_parents)
    moves = np.zeros((robot.joint_count + 1, robot.joint_count))
    for joint in range(robot.joint_count):
        moves[joint] = moves[parents[joint]] if parents[joint] >= 0 else 0
        moves[joint, joint] = 1
    return moves

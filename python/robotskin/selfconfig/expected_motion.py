"""What a kinematic model expects of cells: their Jacobian along the normal, and gravity while a joint swings."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robotskin._core.model import BASE, RobotDynamics
from robotskin.robots import Robot
from robotskin.selfconfig.gravity_samples import GRAVITY_MPS2
from robotskin.selfconfig.joint_sine import JointSine

Array = NDArray[np.float64]


def normal_jacobian(robot: Robot, link: NDArray[np.integer], link_from_cell: Array, posture: Array) -> Array:
    """(N, n) m/rad, how fast each cell moves along its outward normal for a unit velocity of each joint.

    Args:
        robot: whose kinematics hold.
        link: (N,) indices into its links; link_from_cell: (N, 4, 4) metres.
        link_from_cell: see link.
        posture: (n) rad or m.
    """
    dynamics = RobotDynamics(robot.core)
    dynamics.update(np.ascontiguousarray(posture, dtype=float), np.zeros(robot.joint_count))
    result = np.zeros((len(link), robot.joint_count))
    for number in np.unique(link):
        if robot.core.link_joints[number] == BASE:
            continue
        cells = np.flatnonzero(link == number)
        rotation = dynamics.base_from_link(int(number))[:3, :3]
        linear, angular = np.split(dynamics.link_jacobian(int(number)), 2)
        arm, normal = link_from_cell[cells, :3, 3] @ rotation.T, link_from_cell[cells, :3, 2] @ rotation.T
        moved = linear.T[None] + np.cross(angular.T[None], arm[:, None])
        result[cells] = np.einsum("cji,ci->cj", moved, normal)
    return result


def gravity_while_swinging(
    robot: Robot, link: NDArray[np.integer], link_from_cell: Array, swing: JointSine, time_s: Array, nodes: int = 33
) -> Array:
    """(N, M, 3) m/s², cell frame: what gravity alone makes cells feel during a swing.

    Gravity turns by a smooth function of the joint's displacement, which is evaluated at `nodes` and interpolated (to
    1e-5 of g for swings below half a radian).

    Args:
        robot: whose kinematics hold.
        link: (N,) indices into its links; link_from_cell: (N, 4, 4) metres.
        link_from_cell: see link.
        swing: the motion; time_s: (M,) since its start.
        time_s: see swing.
        nodes: displacements at which the model is asked.
    """
    moved = swing.displacement(time_s)
    ladder = np.linspace(moved.min(), moved.max() + 1e-12, nodes)
    up = []
    for displacement in ladder:
        posture = swing.centre.copy()
        posture[swing.joint] += displacement
        up.append(robot.base_from_link(posture)[:, 2, :3])
    at = np.clip((moved - ladder[0]) / (ladder[1] - ladder[0]), 0, nodes - 1.000001)
    low = at.astype(int)
    share = (at - low)[:, None]
    table = np.array(up)
    result = np.empty((len(link), len(time_s), 3))
    for number in np.unique(link):
        cells = np.flatnonzero(link == number)
        there = table[low, number] * (1 - share) + table[low + 1, number] * share
        result[cells] = GRAVITY_MPS2 * np.einsum("nji,mj->nmi", link_from_cell[cells, :3, :3], there)
    return result

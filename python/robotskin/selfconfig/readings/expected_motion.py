# SPDX-License-Identifier: Apache-2.0
"""What a kinematic model expects of cells: their Jacobian along the normal, and gravity while a joint swings."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robotskin.model import BASE, RobotDynamics
from robotskin.robots import Robot
from robotskin.selfconfig.babbling.joint_sine import JointSine
from robotskin.selfconfig.readings.link_motion import link_gravity

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
    robot: Robot, link: NDArray[np.integer], link_from_cell: Array, swing: JointSine, time_s: Array
) -> Array:
    """(N, M, 3) m/s², cell frame: what gravity alone makes cells feel during a swing.

    Args:
        robot: whose kinematics hold.
        link: (N,) indices into its links; link_from_cell: (N, 4, 4) metres.
        link_from_cell: see link.
        swing: the motion; time_s: (M,) since its start.
        time_s: see swing.
    """
    names = [robot.link_names[number] for number in np.unique(link)]
    gravity = link_gravity(robot, names, swing, time_s)
    result = np.empty((len(link), len(time_s), 3))
    for name, felt in gravity.items():
        cells = np.flatnonzero(link == robot.link_index(name))
        result[cells] = felt @ link_from_cell[cells, :3, :3]
    return result

# SPDX-License-Identifier: Apache-2.0
"""Where the cells of a skin are at a posture, which way they face, and how joints move them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robotskin.model import BASE, RobotDynamics, RobotModel
from robotskin.skin import SkinModel

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class CellLevers:
    """Of N cells and n joints, base frame."""

    point: Floats
    """(N, 3) m."""
    inward: Floats
    """(N, 3) unit vectors into the robot."""
    jacobian: Floats
    """(N, 3, n) velocity of a cell by joint velocity; 0 on the base."""

    @property
    def torque(self) -> Floats:
        """(N, n) of an inward newton on the cell."""
        return np.einsum("ci,cij->cj", self.inward, self.jacobian)


def cell_levers(robot: RobotModel, skin: SkinModel, dynamics: RobotDynamics) -> CellLevers:
    """Levers of the cells at the posture of `dynamics`, which are the robot's."""
    point, inward = np.zeros((len(skin), 3)), np.zeros((len(skin), 3))
    jacobian = np.zeros((len(skin), 3, robot.joint_count))
    for index, name in enumerate(skin.link_names):
        cells = np.flatnonzero(skin.link == index)
        if not len(cells):
            continue
        link = robot.link_index(name)
        base_from_link = dynamics.base_from_link(link)
        arm = skin.link_from_cell[cells, :3, 3] @ base_from_link[:3, :3].T
        point[cells] = base_from_link[:3, 3] + arm
        inward[cells] = -skin.link_from_cell[cells, :3, 2] @ base_from_link[:3, :3].T
        if robot.link_joints[link] != BASE:
            linear, angular = np.split(dynamics.link_jacobian(link), 2)
            jacobian[cells] = linear + np.cross(angular.T, arm[:, None, :]).transpose(0, 2, 1)
    return CellLevers(point, inward, jacobian)

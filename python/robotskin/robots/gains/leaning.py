# SPDX-License-Identifier: Apache-2.0
"""How far a touch makes a standing robot lean against it, which takes its cells along: the balance task's lean."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robotskin.model import RobotDynamics
from robotskin.skin import STANDARD_GRAVITY_MPS2
from robotskin.tasks import BalanceGains


def lean_per_newton(
    dynamics: RobotDynamics, point: NDArray[np.float64], inward: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(N, 2) m/N by which the centre of mass leans along x and y against a lasting newton on each cell.

    The newton shifts the point of balance by its moment about the ground below the centre of mass over the weight; the
    robot leans against `BalanceGains.lean` of that.

    Args:
        dynamics: at the posture.
        point: (N, 3) m, base frame, where the cells are.
        inward: (N, 3) unit vectors, base frame, into the robot.
    """
    x, y, _ = dynamics.centre_of_mass
    moment = np.cross(point - np.array([x, y, 0.0]), inward)
    shift = np.stack([moment[:, 1], -moment[:, 0]], axis=1) / (dynamics.mass * STANDARD_GRAVITY_MPS2)
    return -BalanceGains().lean * shift

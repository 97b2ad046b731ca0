# SPDX-License-Identifier: Apache-2.0
"""Joint torques as a linear function of the links' inertial parameters, and which of these torques can tell at all."""

from __future__ import annotations

import numpy as np
import pinocchio
from numpy.typing import NDArray
from scipy.linalg import qr

Array = NDArray[np.float64]


def torque_regressor(model: pinocchio.Model, posture: Array, velocity: Array, acceleration: Array) -> Array:
    """The matrix that times the inertial parameters of all links gives the torques of rigid links.

    Args:
        model: of n revolute joints; its masses do not matter.
        posture: (M, n) rad; velocity: (M, n) rad/s; acceleration: (M, n) rad/s².
        velocity: see posture.
        acceleration: see posture.

    Returns:
        (M n, 10 n), row k n + j is joint j at instant k.
    """
    data = model.createData()
    rows = [
        pinocchio.computeJointTorqueRegressor(model, data, *instant).copy()
        for instant in zip(posture, velocity, acceleration, strict=True)
    ]
    return np.concatenate(rows)


def base_columns(regressor: Array, tolerance: float = 1e-7) -> NDArray[np.int64]:
    """Columns of a largest independent set: the base parameters are those plus what the others add to them.

    Found by QR with pivoting (Gautier, J. Robotic Systems 8(4), 1991).
    """
    _, upper, pivot = qr(regressor, mode="economic", pivoting=True)
    size = np.abs(upper.diagonal())
    return np.sort(pivot[: int((size > tolerance * size[0]).sum())]).astype(np.int64)

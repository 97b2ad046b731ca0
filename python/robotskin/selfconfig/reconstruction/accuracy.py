# SPDX-License-Identifier: Apache-2.0
"""How far estimated cell poses are from true ones, and whether the stated covariance is honest."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

from robotskin.layout.cell import HEXAGON_SIDE_M

Array = NDArray[np.float64]


def pose_errors(estimated: Array, true: Array) -> tuple[Array, Array]:
    """Rotation error (N, 3) rad, right of the estimate in the cell's frame; position error (N, 3) m, true − estimated.

    Args:
        estimated: (N, 4, 4) and true: (N, 4, 4), in the same frame.
        true: see estimated.
    """
    turn = np.swapaxes(estimated[:, :3, :3], 1, 2) @ true[:, :3, :3]
    return Rotation.from_matrix(turn).as_rotvec().reshape(-1, 3), true[:, :3, 3] - estimated[:, :3, 3]


def mean_errors(estimated: Array, true: Array) -> tuple[float, float]:
    """Mean over the cells of the rotation error in degrees and of the position error in millimetres."""
    rotation, position = pose_errors(estimated, true)
    return float(np.degrees(np.linalg.norm(rotation, axis=1).mean())), float(
        1e3 * np.linalg.norm(position, axis=1).mean()
    )


def within_confidence(
    estimated: Array, true: Array, covariance: Array, level: float = 0.95, resolution_m: float = 1e-5
) -> NDArray[np.bool_]:
    """(N,) whether each normalised estimation error eᵀ P⁺ e lies below the chi-square quantile of `level`.

    Hinges that close exactly make a cell's covariance singular. A direction with a deviation below `resolution_m`
    (rotations count by the 14 mm to a hinge) is such a constraint, not an estimate: it takes no part in the sum and in
    the degrees of freedom, and must instead be met to five times the resolution.

    Args:
        estimated: (N, 4, 4); true: (N, 4, 4); covariance: (N, 6, 6) as `Reconstruction.covariance`.
        true: see estimated.
        covariance: see estimated.
        level: of confidence.
        resolution_m: see above.
    """
    lever = np.array([HEXAGON_SIDE_M] * 3 + [1.0] * 3)
    error = np.concatenate(pose_errors(estimated, true), axis=1) * lever
    value, vector = np.linalg.eigh(covariance * lever[:, None] * lever)
    along = np.einsum("nab,na->nb", vector, error)
    free = value > resolution_m**2
    squares = np.where(free, along**2 / np.where(free, value, 1.0), 0.0).sum(axis=1)
    freedom = free.sum(axis=1)
    inside = squares <= chi2.ppf(level, np.maximum(freedom, 1))
    return inside & (np.where(free, 0.0, np.abs(along)) <= 5 * resolution_m).all(axis=1)

# SPDX-License-Identifier: Apache-2.0
"""Where the axis of a swinging joint lies, from the accelerometers of one patch (paper, II-D, phases 1 to 3).

In: statistics of a swing, accelerometers corrected. Out: the axis, gravity, and the way from the axis to the cells.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robotskin.selfconfig.common.gravity import GRAVITY_MPS2
from robotskin.selfconfig.readings.swing_statistics import SIGNALS, SwingStatistics

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class JointLine:
    """The axis of one joint in one posture as one patch sees it.

    direction: (3,) unit vector of a positive turn; point: (3,) metres, on the axis; up: (3,) unit vector opposite to
    gravity; all in the patch's frame. weight: information on the direction, rad⁻².
    """

    direction: Array
    point: Array
    up: Array
    weight: float


def joint_axes(swing: SwingStatistics, up: Array) -> Array:
    """Phase 1: the axis in the frame of each cell, from its own readings alone.

    Whatever a turning link feels besides a constant is perpendicular to the axis: c₁ … c₄ of `SwingStatistics`. Their
    rows, whitened by their covariance, have the axis as the right singular vector of the least singular value.

    Args:
        swing: of N cells, offset and scale removed.
        up: (N, 3) unit vectors opposite to gravity in the cells' frames, at the middle of the swing.

    Returns:
        (N, 3) unit vectors; the sign is that of the displacement.
    """
    whitened = _whitened_motion(swing)
    axis = np.linalg.svd(whitened)[2][:, 2]
    return axis * _sign(swing, axis, up)[:, None]


def tangential(swing: SwingStatistics, axis: Array, up: Array) -> tuple[Array, Array]:
    """Phase 2: the accelerations that are left when gravity, turning with the cell, is taken away.

    Gravity is known from c₀ and the axis: c₁ = g (u − a aᵀu), c₂ = −g a × u. What remains is fitted to d̈ and ḋ² alone;
    its tangential direction is the leading right singular vector of the whitened rows.

    Args:
        swing: of N cells, offset and scale removed.
        axis: (N, 3) in the cells' frames.
        up: (N, 3) as in `joint_axes`.

    Returns:
        coefficient: (N, 2, 3) of d̈ and ḋ², m/s² for one rad/s² and for one (rad/s)². direction: (N, 3) unit vectors.
    """
    coefficient, information = _motion_without_gravity(swing, axis, up)
    rows = np.swapaxes(np.linalg.cholesky(information + 1e-9 * np.eye(2)), 1, 2) @ coefficient
    direction = np.linalg.svd(rows)[2][:, 0]
    along = np.einsum("nk,nk->n", coefficient[:, 0], direction)
    return coefficient, direction * np.where(along < 0, -1.0, 1.0)[:, None]


def radius_vectors(swing: SwingStatistics, axis: Array, up: Array) -> tuple[Array, Array]:
    """Phase 3: from the nearest point of the axis to each cell, by linear least squares.

    The tangential acceleration of one rad/s² is a × r, the centripetal one of one rad/s is −r; both are linear in r.

    Returns:
        vector: (N, 3) metres, cell frame, perpendicular to the axis. weight: (N,) m⁻², its information.
    """
    coefficient, information = _motion_without_gravity(swing, axis, up)
    # In the plane of the turn, with a × as a quarter turn: c3 = Q r, c4 = −r.
    quarter = -np.cross(axis, coefficient[:, 0])
    straight = -(coefficient[:, 1] - axis * np.einsum("nk,nk->n", axis, coefficient[:, 1])[:, None])
    # The covariance between c3 and c4 is that of d̈ with ḋ², which are a quarter period apart.
    one, two = information[:, 0, 0], information[:, 1, 1]
    weight = one + two
    return (quarter * one[:, None] + straight * two[:, None]) / np.maximum(weight, 1e-12)[:, None], weight


def joint_line(swing: SwingStatistics, rotation: Array, position: Array) -> JointLine:
    """The axis as all cells of a patch see it together.

    Args:
        swing: of the n cells of the patch, offset and scale removed.
        rotation: (n, 3, 3) root_from_cell; position: (n, 3) metres.
        position: see rotation.
    """
    level = swing.information[:, 0, 0]
    c0 = np.einsum("nij,nj->ni", rotation, swing.coefficient[:, 0])
    up = (level[:, None] * c0).sum(axis=0)
    up /= np.linalg.norm(up)
    own_up = np.einsum("nji,j->ni", rotation, up)
    rows = np.einsum("nij,naj->nai", rotation, _whitened_motion(swing))
    _, singular, vectors = np.linalg.svd(rows.reshape(-1, 3), full_matrices=False)
    axis = vectors[2]
    own = np.einsum("nji,j->ni", rotation, axis)
    share = _sign_score(swing, own, own_up)
    axis = axis * (1.0 if share.sum() >= 0 else -1.0)
    own = np.einsum("nji,j->ni", rotation, axis)
    vector, weight = radius_vectors(swing, own, own_up)
    foot = position - np.einsum("nij,nj->ni", rotation, vector)
    point = (weight[:, None] * foot).sum(axis=0) / max(weight.sum(), 1e-12)
    return JointLine(axis, point, up, float(singular[1] ** 2))


def _whitened_motion(swing: SwingStatistics) -> Array:
    """(N, 4, 3) coefficients of all but the constant, whitened with the constant left free."""
    information = swing.information
    constant = np.maximum(information[:, 0, 0], 1e-12)
    motion = information[:, 1:, 1:] - information[:, 1:, :1] * information[:, :1, 1:] / constant[:, None, None]
    root = np.linalg.cholesky(motion + 1e-9 * np.eye(SIGNALS - 1))
    return np.asarray(np.swapaxes(root, 1, 2) @ swing.coefficient[:, 1:])


def _motion_without_gravity(swing: SwingStatistics, axis: Array, up: Array) -> tuple[Array, Array]:
    """(N, 2, 3) coefficients of d̈ and ḋ² with gravity known, and (N, 2, 2) their information."""
    along = np.einsum("nk,nk->n", axis, up)[:, None]
    gravity = GRAVITY_MPS2 * np.stack([up, up - axis * along, -np.cross(axis, up)], axis=1)
    residual = swing.coefficient[:, :3] - gravity
    residual[:, 0] = 0.0
    information = swing.information[:, 3:, 3:]
    # What c1 and c2 missed, the correlated c3 and c4 got.
    shift = np.linalg.solve(information + 1e-9 * np.eye(2), swing.information[:, 3:, :3] @ residual)
    return swing.coefficient[:, 3:] + shift, information


def _sign_score(swing: SwingStatistics, axis: Array, up: Array) -> Array:
    """(N,) positive where the axis points as the displacement turns."""
    turning = -GRAVITY_MPS2 * np.cross(axis, up)
    c2, c3, c4 = (swing.coefficient[:, row] for row in (2, 3, 4))
    by_gravity = swing.information[:, 2, 2] * np.einsum("nk,nk->n", turning, c2)
    by_motion = np.sqrt(swing.information[:, 3, 3] * swing.information[:, 4, 4]) * np.einsum(
        "nk,nk->n", np.cross(axis, c3), c4
    )
    return np.asarray(by_gravity + by_motion)


def _sign(swing: SwingStatistics, axis: Array, up: Array) -> Array:
    return np.where(_sign_score(swing, axis, up) < 0, -1.0, 1.0)

# SPDX-License-Identifier: Apache-2.0
"""Small turns as matrices, and the turn between two bundles of directions."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def cross_matrix(vector: Array) -> Array:
    """(..., 3, 3) with matrix @ w = vector x w."""
    matrix = np.zeros((*vector.shape, 3))
    x, y, z = vector[..., 0], vector[..., 1], vector[..., 2]
    matrix[..., 0, 1], matrix[..., 0, 2], matrix[..., 1, 2] = -z, y, -x
    matrix[..., 1, 0], matrix[..., 2, 0], matrix[..., 2, 1] = z, -y, x
    return matrix


def rotation_between(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """The orthogonal Procrustes problem [Cheng19 eq. 2], R = argmin ||R A - B||_F, restricted to proper rotations.

    The paper asks for any orthogonal matrix, which with noise or few poses may be a reflection; no cell is one.

    Args:
        a: (..., K, 3) and b: (..., K, 3), K vectors in two frames.
        b: see a.

    Returns:
        (..., 3, 3) rotation from the frame of a to that of b.
    """
    u, _, vt = np.linalg.svd(np.swapaxes(b, -1, -2) @ a)
    flip = np.ones((*a.shape[:-2], 3))
    flip[..., 2] = np.linalg.det(u @ vt)
    return (u * flip[..., None, :]) @ vt  # [Cheng19 eq. 2]


def by_shears(felt: Array) -> Array:
    """(..., 3, 3) what shears of the axis pairs xy, xz and yz add to felt (..., 3), a column a pair."""
    x, y, z = np.moveaxis(felt, -1, 0)
    nothing = np.zeros_like(x)
    return np.stack(
        [np.stack([y, z, nothing], axis=-1), np.stack([x, nothing, z], axis=-1), np.stack([nothing, x, y], axis=-1)],
        axis=-2,
    )


def shear_matrix(shear: Array) -> Array:
    """(N, 3, 3) symmetric, without a diagonal, of shears (N, 3) of the axis pairs xy, xz and yz."""
    matrix = np.zeros((len(shear), 3, 3))
    for pair, (one, other) in enumerate(((0, 1), (0, 2), (1, 2))):
        matrix[:, one, other] = matrix[:, other, one] = shear[:, pair]
    return matrix


def tangents(direction: Array) -> Array:
    """(K, 3, 2) two unit vectors across each direction (K, 3)."""
    helper = np.where(np.abs(direction[:, :1]) < 0.7, [[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]])
    first = np.cross(direction, helper)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack([first, np.cross(direction, first)], axis=2)

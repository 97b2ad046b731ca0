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
    """The orthogonal Procrustes problem (eq. 2), R = argmin ||R A - B||_F, restricted to proper rotations.

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
    return (u * flip[..., None, :]) @ vt

# SPDX-License-Identifier: Apache-2.0
"""A linear model of an accelerometer in its cell, with what is known of healthy ones: how well an explanation fits.

What an axis shows is e + D e + e x t + S e + b: of what it should feel, e, in g, a scale error of each axis D (3), a
turn t (3), a shear S (3) and an offset b (3). These twelve numbers are Gaussian beforehand. An explanation lets some
of them be anything; its cost is the smallest sum of squares, in standard deviations, of what is left over and of the
numbers themselves.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

SCALE, TURN, SHEAR, OFFSET = slice(0, 3), slice(3, 6), slice(6, 9), slice(9, 12)
PRIOR = np.array([0.02] * 3 + [math.radians(0.6)] * 3 + [0.006] * 3 + [0.04] * 3)
"""(12) standard deviations of healthy ones: 3 % and 66 mg drawn evenly, half a degree, 1 % across the axes."""
SETTLED = np.array([0.004] * 3 + [math.radians(0.2)] * 3 + [0.002] * 3 + [0.006] * 3)
"""(12) by how much one that is known may have changed: temperature, and its model."""
ANYTHING = np.array([0.5] * 3 + [0.6] * 3 + [0.2] * 3 + [0.5] * 3)
WINDOW_G = 0.02
"""What a window's mean may be off by although all is well: motion that is not quite known, bent curves."""


def design(expected: NDArray) -> NDArray[np.float64]:
    """(..., 3, 12) how the numbers show, from (..., 3) what should be felt, in g."""
    x, y, z = expected[..., 0], expected[..., 1], expected[..., 2]
    out = np.zeros((*expected.shape[:-1], 3, 12))
    out[..., 0, 0], out[..., 1, 1], out[..., 2, 2] = x, y, z
    # e x t
    out[..., 0, 4], out[..., 0, 5] = -z, y
    out[..., 1, 3], out[..., 1, 5] = z, -x
    out[..., 2, 3], out[..., 2, 4] = -y, x
    out[..., 0, 6], out[..., 1, 6] = y, x
    out[..., 1, 7], out[..., 2, 7] = z, y
    out[..., 0, 8], out[..., 2, 8] = z, x
    out[..., 0, 9] = out[..., 1, 10] = out[..., 2, 11] = 1.0
    return out


def normal(expected: NDArray, felt: NDArray, weight: NDArray) -> tuple[NDArray, NDArray, NDArray]:
    """(N, 12, 12), (N, 12) and (N): sums over the windows of (K, N, 3) expected and felt, g, weight (K, N)."""
    shown = design(np.where(weight[..., None] > 0, expected, 0.0))
    left = np.where(weight[..., None] > 0, felt - expected, 0.0)
    scaled = shown * (weight / WINDOW_G**2)[..., None, None]
    cells, windows = left.shape[1], left.shape[0]
    rows = shown.transpose(1, 0, 2, 3).reshape(cells, windows * 3, 12)
    heavy = scaled.transpose(1, 0, 2, 3).reshape(cells, windows * 3, 12)
    rest = left.transpose(1, 0, 2).reshape(cells, windows * 3, 1)
    heavy_rest = (left * (weight / WINDOW_G**2)[..., None]).transpose(1, 0, 2).reshape(cells, windows * 3)
    square = np.swapaxes(heavy, 1, 2) @ rows
    side = (np.swapaxes(heavy, 1, 2) @ rest)[..., 0]
    return square, side, (heavy_rest * rest[..., 0]).sum(axis=1)


def cost(
    square: NDArray, side: NDArray, total: NDArray, mean: NDArray, covariance: NDArray
) -> tuple[NDArray, NDArray, NDArray]:
    """(M) cost, (M, 12) numbers and (M, 12) their standard deviations, where the numbers are known to be
    `mean` (M, 12) with `covariance` (M, 12, 12) beforehand."""
    precision = np.linalg.inv(covariance)
    moved = side - (square @ mean[..., None])[..., 0]
    left = total - 2 * (side * mean).sum(axis=-1) + (mean * (square @ mean[..., None])[..., 0]).sum(axis=-1)
    after = np.linalg.inv(square + precision)
    change = (after @ moved[..., None])[..., 0]
    deviation = np.sqrt(np.maximum(np.diagonal(after, axis1=-2, axis2=-1), 0.0))
    return left - (moved * change).sum(axis=-1), mean + change, deviation


def relaxed(covariance: NDArray, which: slice | list[int]) -> NDArray:
    """The same where some of the numbers may be anything."""
    out = covariance.copy()
    index = np.arange(12)[which]
    out[..., index, index] += ANYTHING[index] ** 2
    return out


def common_scale(covariance: NDArray) -> NDArray:
    """The same where all axes may be off by one scale."""
    out = covariance.copy()
    out[..., SCALE, SCALE] += ANYTHING[0] ** 2
    return out


def best_turn(expected: NDArray, felt: NDArray, weight: NDArray) -> NDArray[np.float64]:
    """(M, 3, 3) the rotations that take what is expected to what is felt best: (K, M, 3) each, weight (K, M)."""
    together = np.einsum("km,kmi,kmj->mij", weight, felt, expected)
    together += 1e-6 * np.eye(3)
    left, _, right = np.linalg.svd(together)
    sign = np.sign(np.linalg.det(left @ right))
    left[:, :, 2] *= sign[:, None]
    return left @ right

# SPDX-License-Identifier: Apache-2.0
"""The model of a cell's three force sensors: twelve numbers, gains, offsets and what each shows of the other two.

What they show is diag(gain) (1 + cross) force + offset, newton; a sensor shows nothing below zero.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robotskin.firmware import FORCE_SENSOR_POINTS_M, HEXAGON_SIDE_M

Array = NDArray[np.float64]

PARAMETERS = 12
GAIN, OFFSET, CROSS = slice(0, 3), slice(3, 6), slice(6, 12)
_ROW, _COLUMN = np.nonzero(~np.eye(3, dtype=bool))
UNTOUCHED = np.array([1.0] * 3 + [0.0] * 9)
"""Of a cell that was never calibrated: it is believed as it is."""


def matrix(parameters: Array) -> Array:
    """(..., 3, 3) reading from force, of parameters (..., 12)."""
    mixed = np.broadcast_to(np.eye(3), (*parameters.shape[:-1], 3, 3)).copy()
    mixed[..., _ROW, _COLUMN] = parameters[..., CROSS]
    return parameters[..., GAIN, None] * mixed


def shown(parameters: Array, force_n: Array) -> Array:
    """(..., 3) newton that the sensors show where they feel force_n (..., 3), before they end at zero."""
    return np.einsum("...ij,...j->...i", matrix(parameters), force_n) + parameters[..., OFFSET]


def felt(parameters: Array, reading_n: Array) -> Array:
    """(..., 3) newton that the sensors felt where they show reading_n (..., 3); one at zero feels nothing."""
    above = np.where(reading_n > 0, reading_n - parameters[..., OFFSET], 0.0)
    return np.einsum("...ij,...j->...i", np.linalg.inv(matrix(parameters)), above)


def shares(place_m: Array) -> Array:
    """(..., 3) how a force at (x, y) metres on a cell's face is shared by its three sensors: >= 0, sum 1."""
    points = np.asarray(FORCE_SENSOR_POINTS_M)
    towards = place_m @ (points / np.linalg.norm(points, axis=1, keepdims=True)).T
    share = np.maximum((1 + towards / HEXAGON_SIDE_M) / 3, 0.0)
    return share / share.sum(axis=-1, keepdims=True)

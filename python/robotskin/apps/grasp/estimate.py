# SPDX-License-Identifier: Apache-2.0
"""Where a thing is, from the nearness of four pads: its reflectance and its size are known roughly alone."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from robotskin.apps.grasp.contacts import Shape

Array = NDArray[np.float64]

COVER_M = 0.006
"""The sensor's reading falls with the square of the distance plus this."""
CONE_RAD = np.deg2rad(20.0)
"""Of the outer six of the seven rays that stand for what the sensor sees."""
REACH_M = 0.05
"""Apparent distances beyond this say nothing."""
READING_M = 0.0007
PLACE_M = 0.006
RADIUS_M = 0.002
LOG_REFLECTANCE = 0.35
"""Standard deviations: of a reading, and of what is believed beforehand."""


def rays(normal: Array) -> Array:
    """(4, 7, 3) directions about (4, 3) normals."""
    aside = np.cross(normal, np.where(np.abs(normal[:, 2:]) < 0.8, [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]))
    aside /= np.linalg.norm(aside, axis=1)[:, None]
    other = np.cross(normal, aside)
    turn = np.arange(6) * np.pi / 3
    outer = np.cos(turn)[:, None, None] * aside + np.sin(turn)[:, None, None] * other
    outer = np.cos(CONE_RAD) * normal + np.sin(CONE_RAD) * outer
    return np.concatenate([normal[None], outer]).transpose(1, 0, 2)


def nearest_along(place: Array, along: Array, centre: Array, radius_m: float, seen: Array) -> Array:
    """(4,) metres along the rays (4, 7, 3) from (4, 3) places to a ball or a cylinder; smooth where a ray misses."""
    direction = along * seen
    squared = (direction**2).sum(axis=2)
    start = (place - centre) * seen
    half = (direction * start[:, None]).sum(axis=2) / squared
    inside = half**2 - ((start**2).sum(axis=1)[:, None] - radius_m**2) / squared
    hit = -half - np.sqrt(np.maximum(inside, 0.0))
    missed = np.sqrt(np.maximum(-inside, 0.0))
    return np.asarray(np.maximum((hit + 2 * missed).min(axis=1), 0.0))


def estimate_centre(place: Array, normal: Array, apparent_m: Array, shape: Shape, believed: Array) -> Array:
    """The thing's centre (3,) that fits (4,) apparent distances best; along a cylinder's axis it stays as believed.

    Unknown beside it are a reflectance that all readings share, and the radius. With the reflectance left out, all
    pads seem farther than they are, and the centre slides aside.

    Args:
        place, normal: (4, 3) of the pads, metres, in the hand's frame.
        apparent_m: (4,) what the cells take for the distance.
        shape: as it is believed.
        believed: (3,) metres.
    """
    along = rays(normal)
    heard = apparent_m < REACH_M

    def wrong(unknown: Array) -> Array:
        true = nearest_along(place, along, unknown[:3], shape.radius_m + unknown[4] * RADIUS_M, shape.seen)
        expected = (COVER_M + true) / np.exp(0.5 * LOG_REFLECTANCE * unknown[3]) - COVER_M
        fit = np.where(heard, (expected - apparent_m) / READING_M, 0.0)
        return np.concatenate([fit, (unknown[:3] - believed) / PLACE_M, unknown[3:]])

    start = np.concatenate([believed, [0.0, 0.0]])
    solved = least_squares(wrong, start, x_scale=[0.005, 0.005, 0.005, 1.0, 1.0], diff_step=1e-3, max_nfev=40)
    return np.asarray(np.where(shape.seen > 0, solved.x[:3], believed))

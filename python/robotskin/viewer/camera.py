# SPDX-License-Identifier: Apache-2.0
"""Where the page looks from when it opens, and where on the screen a point of the scene then is."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robotskin.viewer.session_view import Floats

FIELD_OF_VIEW_RAD = 0.7
FROM_FRONT_LEFT = np.array([0.75, -1.0, 0.45])
MARGIN = 1.1
SIDES = 8
CLEARLY = 1.5
"""Another side must show so many times more of the skin than the usual one."""
NARROW = 0.7
"""Screens narrower than this share of their height are telephones, whose controls cover the bottom."""
FREE_OF_CONTROLS = 0.54
"""The share of a telephone's screen above the controls."""


@dataclass(frozen=True)
class Camera:
    """A pinhole camera with z up; the base frame, metres. `field_of_view_rad` is the vertical one."""

    position_m: Floats
    look_at_m: Floats
    field_of_view_rad: float = FIELD_OF_VIEW_RAD

    @classmethod
    def around(cls, points_m: Floats, aspect: float = 1.0, towards: Floats = FROM_FRONT_LEFT) -> "Camera":
        """A camera that sees all points (K, 3) from a side, as near as they fit.

        Args:
            points_m: (K, 3) metres, base frame.
            aspect: width of the screen over its height; a telephone's bottom, where controls are, is left free.
            towards: (3,) from the points to the camera.
        """
        points_m = np.asarray(points_m, dtype=float)
        centre = (points_m.min(axis=0) + points_m.max(axis=0)) / 2
        towards = np.asarray(towards, dtype=float) / np.linalg.norm(towards)
        facing = axes(-towards)
        x, y, z = ((points_m - centre) @ facing).T
        free = FREE_OF_CONTROLS if aspect < NARROW else 1.0
        half = np.tan(FIELD_OF_VIEW_RAD / 2)
        # What is nearer than the middle is drawn farther from it, and rises more where the scene is moved up.
        beside = np.abs(x) / aspect / half - z
        above = (-y / half - z) / free
        below = (y / half - (2 * free - 1) * z) / free
        distance = MARGIN * max(np.max(beside), np.max(above), np.max(below))
        # The middle of what is free lies above the middle of the screen.
        lower = (1 - free) * half * distance * facing[:, 1]
        return cls(centre + lower + distance * towards, centre + lower)

    def pixels(self, points_m: Floats, width: int, height: int) -> NDArray[np.float64]:
        """(K, 2) x right and y down of points (K, 3) on a screen of that size; NaN for those behind the camera."""
        seen = (np.asarray(points_m, dtype=float) - self.position_m) @ axes(self.look_at_m - self.position_m)
        depth = np.where(seen[:, 2] > 0, seen[:, 2], np.nan)
        focal = height / 2 / np.tan(self.field_of_view_rad / 2)
        return seen[:, :2] / depth[:, None] * focal + [width / 2, height / 2]


def side_of_skin(normals: Floats) -> NDArray[np.float64]:
    """(3,) from where most cells are seen, the front left unless another side shows clearly more; normals (N, 3)."""
    angles = 2 * np.pi * np.arange(SIDES) / SIDES
    x, y, z = FROM_FRONT_LEFT / np.linalg.norm(FROM_FRONT_LEFT)
    sides = np.stack(
        [x * np.cos(angles) - y * np.sin(angles), x * np.sin(angles) + y * np.cos(angles), np.full(SIDES, z)], axis=1
    )
    shown = np.maximum(np.asarray(normals, dtype=float) @ sides.T, 0.0).sum(axis=0)
    best = int(np.argmax(shown))
    return sides[best if shown[best] > CLEARLY * shown[0] else 0]


def axes(forward: Floats) -> NDArray[np.float64]:
    """(3, 3) whose columns are right, down and forward of a camera that holds its horizon level."""
    forward = np.asarray(forward, dtype=float) / np.linalg.norm(forward)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(forward, right), forward], axis=1)

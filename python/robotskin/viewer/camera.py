# SPDX-License-Identifier: Apache-2.0
"""Where the page looks from when it opens, and where on the screen a point of the scene then is."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robotskin.viewer.session_view import Floats

FIELD_OF_VIEW_RAD = 0.7
FROM_FRONT_LEFT = np.array([0.75, -1.0, 0.45])
MARGIN = 1.1


@dataclass(frozen=True)
class Camera:
    """A pinhole camera with z up; the base frame, metres. `field_of_view_rad` is the vertical one."""

    position_m: Floats
    look_at_m: Floats
    field_of_view_rad: float = FIELD_OF_VIEW_RAD

    @classmethod
    def around(cls, points_m: Floats) -> "Camera":
        """A camera that sees all points (K, 3) from their front left on a square screen, as near as they fit."""
        points_m = np.asarray(points_m, dtype=float)
        centre = (points_m.min(axis=0) + points_m.max(axis=0)) / 2
        towards = FROM_FRONT_LEFT / np.linalg.norm(FROM_FRONT_LEFT)
        x, y, z = ((points_m - centre) @ axes(-towards)).T
        distance = np.max(np.maximum(np.abs(x), np.abs(y)) / np.tan(FIELD_OF_VIEW_RAD / 2) - z)
        return cls(centre + MARGIN * distance * towards, centre)

    def pixels(self, points_m: Floats, width: int, height: int) -> NDArray[np.float64]:
        """(K, 2) x right and y down of points (K, 3) on a screen of that size; NaN for those behind the camera."""
        seen = (np.asarray(points_m, dtype=float) - self.position_m) @ axes(self.look_at_m - self.position_m)
        depth = np.where(seen[:, 2] > 0, seen[:, 2], np.nan)
        focal = height / 2 / np.tan(self.field_of_view_rad / 2)
        return seen[:, :2] / depth[:, None] * focal + [width / 2, height / 2]


def axes(forward: Floats) -> NDArray[np.float64]:
    """(3, 3) whose columns are right, down and forward of a camera that holds its horizon level."""
    forward = np.asarray(forward, dtype=float) / np.linalg.norm(forward)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(forward, right), forward], axis=1)

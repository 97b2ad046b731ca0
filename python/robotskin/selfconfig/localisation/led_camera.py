# SPDX-License-Identifier: Apache-2.0
"""A camera that looks at the skin: where points land in its image, and one place from which it looked."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import cv2
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

LED_POINT_M: Array = np.zeros(3)
"""(3,) where a cell's LED is, cell frame: the middle of the outer face. No published text says where it is."""


@dataclass(frozen=True, eq=False)
class Camera:
    """A pinhole with lens distortion; its frame has x right, y down, z forward (OpenCV's).

    width, height: pixels; focal_px: focal length; centre_px: (2,) principal point, the middle of the first pixel being
    (0, 0); distortion: OpenCV's k1, k2, p1, p2, k3.
    """

    width: int = 640
    height: int = 480
    focal_px: float = 600.0
    centre_px: tuple[float, float] = (319.5, 239.5)
    distortion: tuple[float, ...] = field(default=(0.0, 0.0, 0.0, 0.0, 0.0))

    def window(self, left: int, top: int, width: int, height: int) -> Camera:
        """The camera that reads out a part of its image only: its pixel (0, 0) is this one's (left, top)."""
        x, y = self.centre_px
        return replace(self, width=width, height=height, centre_px=(x - left, y - top))

    def window_around(self, pixels: Array, margin: int = 24) -> tuple[Camera, NDArray[np.int64]]:
        """The window that holds pixels (N, 2), and its corner (2,) in this camera's image."""
        low = np.clip(np.floor(pixels.min(axis=0)).astype(int) - margin, 0, None)
        high = np.minimum(np.ceil(pixels.max(axis=0)).astype(int) + margin, [self.width, self.height])
        return self.window(*low.tolist(), *(high - low).tolist()), low

    @property
    def matrix(self) -> Array:
        """(3, 3) OpenCV's camera matrix."""
        x, y = self.centre_px
        return np.array([[self.focal_px, 0.0, x], [0.0, self.focal_px, y], [0.0, 0.0, 1.0]])

    def pixels(self, points: Array) -> Array:
        """(N, 2) x right and y down, pixels, of points (N, 3) m in the camera frame; NaN behind the camera."""
        points = np.asarray(points, dtype=float).reshape(-1, 3)
        pixel = np.full((len(points), 2), np.nan)
        before = points[:, 2] > 1e-3
        if before.any():
            image = cv2.projectPoints(points[before], np.zeros(3), np.zeros(3), self.matrix, np.array(self.distortion))
            pixel[before] = image[0].reshape(-1, 2)
        return pixel

    def slopes(self, points: Array) -> Array:
        """(N, 2, 3) pixels a metre: how the pixels of points (N, 3) m in the camera frame move with them; 0 behind."""
        points = np.asarray(points, dtype=float).reshape(-1, 3)
        slope = np.zeros((len(points), 2, 3))
        before = points[:, 2] > 1e-3
        if before.any():
            image = cv2.projectPoints(points[before], np.zeros(3), np.zeros(3), self.matrix, np.array(self.distortion))
            # A shift of the camera's origin moves the points themselves.
            slope[before] = image[1][:, 3:6].reshape(-1, 2, 3)
        return slope

    def rays(self, pixels: Array) -> Array:
        """(N, 3) unit directions, camera frame, seen at pixels (N, 2)."""
        pixels = np.ascontiguousarray(pixels, dtype=float).reshape(-1, 1, 2)
        flat = cv2.undistortPoints(pixels, self.matrix, np.array(self.distortion)).reshape(-1, 2)
        ray = np.column_stack([flat, np.ones(len(flat))])
        return ray / np.linalg.norm(ray, axis=1, keepdims=True)

    def inside(self, pixels: Array, margin: float = 4.0) -> NDArray[np.bool_]:
        """(N,) whether pixels (N, 2) lie in the image, `margin` pixels off its rim."""
        with np.errstate(invalid="ignore"):
            high = np.array([self.width, self.height]) - 1 - margin
            return np.asarray(((pixels >= margin) & (pixels <= high)).all(axis=1), dtype=bool)


@dataclass(frozen=True, eq=False)
class CameraView:
    """One look: base_from_camera (4, 4) metres, and the posture (n) rad or m in which the robot stood still."""

    base_from_camera: Array
    posture: Array


def looking_at(place: Array, target: Array, up: Array = np.array([0.0, 0.0, 1.0])) -> Array:  # noqa: B008 - constant
    """(4, 4) base_from_camera of a camera at `place` that looks at `target`, both (3,) m, its head towards `up`."""
    forward = np.asarray(target, dtype=float) - place
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, up)
    if np.linalg.norm(right) < 1e-6:
        right = np.cross(forward, [1.0, 0.0, 0.0])
    right /= np.linalg.norm(right)
    pose = np.eye(4)
    pose[:3, :3] = np.column_stack([right, np.cross(forward, right), forward])
    pose[:3, 3] = place
    return pose

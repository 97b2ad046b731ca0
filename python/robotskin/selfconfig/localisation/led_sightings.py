# SPDX-License-Identifier: Apache-2.0
"""What was seen of a patch, as residuals of its cells' places on a link; and first guesses of the patch's pose."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from robotskin.robots import Robot
from robotskin.selfconfig.common.rotations import cross_matrix, rotation_between
from robotskin.selfconfig.localisation.led_camera import LED_POINT_M, Camera, CameraView

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Sighting:
    """Cells of one patch in one view: cell (B,) rows of its shape, pixel (B, 2), deviation_px (B,) of a coordinate."""

    view: CameraView
    cell: NDArray[np.int64]
    pixel: Array
    deviation_px: Array


class SeenCells:
    """The B blobs of all views as evidence (`motion_fit.OtherEvidence`) of where n cells are on a candidate link.

    weight: (B,) 0 to 1, square root of how much each is trusted; to be set by a search for outliers.
    """

    def __init__(self, robot: Robot, link: str, camera: Camera, seen: Sequence[Sighting], count: int) -> None:
        self.camera, self.seen, self.count = camera, seen, count
        row = robot.link_index(link)
        self.camera_from_link = np.array(
            [
                np.linalg.inv(sighting.view.base_from_camera) @ robot.base_from_link(sighting.view.posture)[row]
                for sighting in seen
            ]
        )
        self.view = np.repeat(np.arange(len(seen)), [len(sighting.cell) for sighting in seen])
        self.cell = np.concatenate([sighting.cell for sighting in seen])
        self.pixel = np.concatenate([sighting.pixel for sighting in seen])
        self.deviation_px = np.concatenate([sighting.deviation_px for sighting in seen])
        self.weight = np.ones(len(self.cell))

    def used(self) -> NDArray[np.bool_]:
        """(n,) which cells have a blob that counts."""
        result = np.zeros(self.count, dtype=bool)
        result[self.cell[self.weight > 0]] = True
        return result

    def residual(self, rotation: Array, place: Array) -> Array:
        """(n, 2 V) weighted errors of the pixels; see `OtherEvidence`."""
        error = self._errors_px(place + rotation @ LED_POINT_M)
        result = np.zeros((self.count, len(self.seen), 2))
        result[self.cell, self.view] = error * (self.weight / self.deviation_px)[:, None]
        return result.reshape(self.count, -1)

    def slope(self, rotation: Array, place: Array) -> Array:
        """(n, 2 V, 6) derivative of `residual`; see `OtherEvidence`."""
        pose = self.camera_from_link[self.view]
        led = (place + rotation @ LED_POINT_M)[self.cell]
        by_place = self.camera.slopes(np.einsum("bij,bj->bi", pose[:, :3, :3], led) + pose[:, :3, 3]) @ pose[:, :3, :3]
        by_turn = -by_place @ rotation[self.cell] @ cross_matrix(LED_POINT_M)
        result = np.zeros((self.count, len(self.seen), 2, 6))
        weight = (self.weight / self.deviation_px)[:, None, None]
        result[self.cell, self.view] = np.concatenate([by_turn, by_place], axis=2) * weight
        return result.reshape(self.count, -1, 6)

    def distances(self, rotation: Array, place: Array) -> Array:
        """(B,) how far each blob is off, in its own standard deviations."""
        return np.linalg.norm(self._errors_px(place + rotation @ LED_POINT_M), axis=1) / self.deviation_px

    def distances_px(self, link_from_root: Array, points: Array) -> Array:
        """(B,) how far each blob is off if the LEDs sit at points (n, 3) m in the root's frame."""
        return np.linalg.norm(self._errors_px(points @ link_from_root[:3, :3].T + link_from_root[:3, 3]), axis=1)

    def deviations_px(self, deviation_m: Array) -> Array:
        """(B,) standard deviation of a pixel coordinate, that (n,) m of the cell's place included."""
        distance = np.linalg.norm(self.camera_from_link[self.view, :3, 3], axis=1) + 1e-6
        return np.hypot(self.deviation_px, self.camera.focal_px * deviation_m[self.cell] / distance)

    def rays(self) -> tuple[Array, Array]:
        """Origin and unit direction (B, 3) of the line of sight of each blob, link frame."""
        pose = self.camera_from_link[self.view]
        direction = np.einsum("bji,bj->bi", pose[:, :3, :3], self.camera.rays(self.pixel))
        return -np.einsum("bji,bj->bi", pose[:, :3, :3], pose[:, :3, 3]), direction

    def _errors_px(self, led: Array) -> Array:
        pose = self.camera_from_link[self.view]
        error = self.camera.pixels(np.einsum("bij,bj->bi", pose[:, :3, :3], led[self.cell]) + pose[:, :3, 3])
        return np.nan_to_num(error - self.pixel, nan=1e3)


def starts(seen: SeenCells, points: Array) -> Iterator[Array]:
    """Guesses (4, 4) of link_from_root, LEDs at points (n, 3) m in the root's frame.

    Cells seen in several views are points nearest to their lines of sight, onto which the shape is turned; and OpenCV's
    perspective-n-point solutions of the two fullest views.
    """
    rows, place = _crossings(seen)
    if len(points) == 1 and len(rows):
        start = np.eye(4)
        start[:3, 3] = place[0] - points[0]
        yield start
    if len(rows) >= 3:
        start = np.eye(4)
        a, b = points[rows], place
        start[:3, :3] = rotation_between(a - a.mean(axis=0), b - b.mean(axis=0))
        start[:3, 3] = b.mean(axis=0) - start[:3, :3] @ a.mean(axis=0)
        yield start
    if len(points) == 1:
        return
    for index in sorted(range(len(seen.seen)), key=lambda index: -len(seen.seen[index].cell))[:2]:
        sighting = seen.seen[index]
        for solver, least in ((cv2.SOLVEPNP_SQPNP, 4), (cv2.SOLVEPNP_EPNP, 6)):
            if len(sighting.cell) < least:
                continue
            number, turns, shifts, _ = cv2.solvePnPGeneric(
                np.ascontiguousarray(points[sighting.cell]),
                np.ascontiguousarray(sighting.pixel),
                seen.camera.matrix,
                np.array(seen.camera.distortion),
                flags=solver,
            )
            for turn, shift in zip(turns[:number], shifts[:number], strict=True):
                pose = np.eye(4)
                pose[:3, :3], pose[:3, 3] = cv2.Rodrigues(turn)[0], shift.ravel()
                yield np.linalg.inv(seen.camera_from_link[index]) @ pose


def _crossings(seen: SeenCells) -> tuple[NDArray[np.int64], Array]:
    """Rows (M,) of cells whose lines of sight cross clearly, and the points (M, 3) m nearest to them, link frame."""
    origin, direction = seen.rays()
    across = np.eye(3) - direction[:, :, None] * direction[:, None, :]
    left, right = np.zeros((seen.count, 3, 3)), np.zeros((seen.count, 3))
    np.add.at(left, seen.cell, across)
    np.add.at(right, seen.cell, np.einsum("bij,bj->bi", across, origin))
    rows = np.flatnonzero(np.linalg.eigvalsh(left)[:, 0] > 1e-5)
    points = np.linalg.solve(left[rows], right[rows][:, :, None])[:, :, 0]
    return rows.astype(np.int64), np.asarray(points, dtype=np.float64)

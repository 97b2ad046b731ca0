"""Where a patch sits, from pictures of its blinking cells (paper, figure 5a): the skin as its own visual marker.

In: which cell was seen at which pixel, from where, in which posture; the patch's shape. Out: link and pose of the root
cell with covariance. Once a patch. What can go wrong: too few cells seen, links that explain the pictures alike.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy import optimize

from robotskin.robots import Robot
from robotskin.selfconfig.led_camera import LED_POINT_M, Camera, CameraView
from robotskin.selfconfig.localisation import (
    Localisation,
    LocalisationError,
    covariance_of,
    moved,
    moving_joints,
    segments,
)

Array = NDArray[np.float64]

LEAST_MARGIN = 30.0
"""Difference in squared normalised residuals below which two links count as equally good."""
FAR_PX = 40.0
"""How far a start may miss other views before its link is given up, unless all links do worse."""
OUTLIER = 5.0
"""Standard deviations beyond which a blob is not the cell it claims to be."""


@dataclass(frozen=True, eq=False)
class Sighting:
    """Cells of one patch in one view: cell (B,) rows of its shape, pixel (B, 2), deviation_px (B,) of a coordinate."""

    view: CameraView
    cell: NDArray[np.int64]
    pixel: Array
    deviation_px: Array


def localise_by_leds(
    robot: Robot,
    camera: Camera,
    sightings: Sequence[Sighting],
    root_from_cell: Array,
    *,
    shape_covariance: Array | None = None,
    links: Sequence[str] | None = None,
) -> Localisation:
    """Find the link of a patch and the pose of its root cell on it from what a camera saw.

    OpenCV's perspective-n-point solution of the fullest view starts an adjustment over all views. Views in different
    postures tell the link; a lone cell is seen as a point, so that all its turns stay open.

    Args:
        robot: known kinematic model.
        camera: calibrated.
        sightings: views of the patch, the robot at rest in each; four cells in one of them, or two views.
        root_from_cell: (n, 4, 4) metres, shape of the patch as `reconstruct` gives it; (1, 4, 4) for a lone cell.
        shape_covariance: (n, 6, 6) as `Reconstruction.covariance`; by default the shape is exact.
        links: candidates; by default all that some joint moves.

    Raises:
        LocalisationError: too few cells seen, no pose that explains them, or two links that do alike.
        UnknownNameError: no such link.
    """
    seen = [sighting for sighting in sightings if len(sighting.cell)]
    if not seen:
        raise LocalisationError("no cell of the patch was seen in any view")
    count = len(root_from_cell)
    shape = np.zeros((count, 6, 6)) if shape_covariance is None else np.asarray(shape_covariance, dtype=float)
    points = root_from_cell[:, :3, 3] + root_from_cell[:, :3, :3] @ LED_POINT_M
    # One view tells no link from another, but it shall not be taken for one that stands still.
    postures = [sighting.view.posture for sighting in seen]
    moving = moving_joints(postures) if len(seen) > 1 else set(range(robot.joint_count))
    candidates = {joint: names for joint, names in segments(robot, moving, links).items() if joint >= 0 or links}
    problems = [(names, _Problem(robot, names[0], camera, seen, points, shape)) for names in candidates.values()]
    first = {names: problem.first_guess() for names, problem in problems}
    closest = min((guess[0] for guess in first.values()), default=np.inf)
    fits: list[tuple[float, str, tuple[str, ...], Array, Array, list[NDArray[np.bool_]], float]] = []
    for names, problem in problems:
        # A start from one view already misses the others by far where the link is wrong.
        if first[names][0] <= max(10 * closest, FAR_PX):
            best = problem.solve(first[names][1])
            if best is not None:
                fits.append((best[0], names[0], names[1:], *best[1:]))
    if not fits:
        raise LocalisationError(
            f"{sum(len(sighting.cell) for sighting in seen)} sightings in {len(seen)} views are explained by no pose "
            f"on {', '.join(name for names in candidates.values() for name in names)}"
        )
    fits.sort(key=lambda fit: fit[0])
    if len(fits) > 1 and fits[1][0] - fits[0][0] < LEAST_MARGIN:
        raise LocalisationError(
            f"links {fits[0][1]} and {fits[1][1]} explain the pictures alike; name the link, or add a view in which "
            "the joints between them stand otherwise"
        )
    _, link, same, pose, information, good, misfit = fits[0]
    used = np.zeros(count, dtype=bool)
    for sighting, kept in zip(seen, good, strict=True):
        used[sighting.cell[kept]] = True
    common = None
    if count > 1:
        # The root's own share in the shape's errors moves the whole patch; see motion_localisation.
        others = shape[used].copy()
        others[:, :3, :3] = (
            root_from_cell[used, :3, :3] @ shape[used, :3, :3] @ np.swapaxes(root_from_cell[used, :3, :3], 1, 2)
        )
        common = np.zeros((6, 6))
        common[:3, :3] = 0.5 * others[:, :3, :3].mean(axis=0)
    covariance, unknown = covariance_of(information / max(misfit, 1.0) ** 2, robot, link, pose, common)
    return Localisation(link, pose, covariance, unknown, tuple(same), used, misfit)


class _Problem:
    """Reprojection errors of one patch on one candidate link."""

    def __init__(
        self, robot: Robot, link: str, camera: Camera, seen: Sequence[Sighting], points: Array, shape: Array
    ) -> None:
        self.camera, self.seen, self.points = camera, seen, points
        row = robot.link_index(link)
        self.camera_from_link = [
            np.linalg.inv(sighting.view.base_from_camera) @ robot.base_from_link(sighting.view.posture)[row]
            for sighting in seen
        ]
        self.shape_deviation = np.sqrt(shape[:, 3:, 3:].trace(axis1=1, axis2=2) / 3)
        self.lone = len(points) == 1

    def first_guess(self) -> tuple[float, Array]:
        """The start that misses least, pixels (median over the blobs), and the start (4, 4); infinite if none."""
        everything = [np.ones(len(sighting.cell), dtype=bool) for sighting in self.seen]
        unit = np.concatenate([self._deviations(index) for index in range(len(self.seen))])
        best: tuple[float, Array] = (np.inf, np.eye(4))
        for start in self._starts():
            distance = np.linalg.norm(self._residual(start, everything).reshape(-1, 2), axis=1) * unit
            if np.median(distance) < best[0]:
                best = (float(np.median(distance)), start)
        return best

    def solve(self, start: Array) -> tuple[float, Array, Array, list[NDArray[np.bool_]], float] | None:
        """Cost, link_from_root, information, which blobs were good, and misfit; None if no pose explains enough."""
        best = self._refined(start)
        if best is None:
            return None
        cost, pose, good = best
        residual, jacobian = self._residual(pose, good), self._jacobian(pose, good)
        number = int(np.isfinite(residual).sum())
        freedom = max(number - (3 if self.lone else 6), 1)
        misfit = float(np.sqrt((residual**2).sum() / freedom)) if number > 6 else 1.0
        return cost, pose, jacobian.T @ jacobian, good, misfit

    def _starts(self) -> Iterator[Array]:
        if self.lone:
            # The point nearest to all lines of sight.
            left, right = np.zeros((3, 3)), np.zeros(3)
            for pose, sighting in zip(self.camera_from_link, self.seen, strict=True):
                for ray in self.camera.rays(sighting.pixel):
                    along = pose[:3, :3].T @ ray
                    across = np.eye(3) - np.outer(along, along)
                    left += across
                    right += across @ (-pose[:3, :3].T @ pose[:3, 3])
            start = np.eye(4)
            if np.linalg.cond(left) < 1e6:
                start[:3, 3] = np.linalg.solve(left, right)
                yield start
            return
        for index in sorted(range(len(self.seen)), key=lambda index: -len(self.seen[index].cell))[:2]:
            sighting = self.seen[index]
            if len(sighting.cell) < 4:
                continue
            for solver in (cv2.SOLVEPNP_SQPNP, cv2.SOLVEPNP_EPNP):
                if solver == cv2.SOLVEPNP_EPNP and len(sighting.cell) < 6:
                    continue
                number, turns, shifts, _ = cv2.solvePnPGeneric(
                    np.ascontiguousarray(self.points[sighting.cell]),
                    np.ascontiguousarray(sighting.pixel),
                    self.camera.matrix,
                    np.array(self.camera.distortion),
                    flags=solver,
                )
                for turn, shift in zip(turns[:number], shifts[:number], strict=True):
                    pose = np.eye(4)
                    pose[:3, :3], pose[:3, 3] = cv2.Rodrigues(turn)[0], shift.ravel()
                    yield np.linalg.inv(self.camera_from_link[index]) @ pose

    def _refined(self, start: Array) -> tuple[float, Array, list[NDArray[np.bool_]]] | None:
        """Least squares from a start, robust first, then without the blobs that are far off."""
        good = [np.ones(len(sighting.cell), dtype=bool) for sighting in self.seen]
        pose = start
        for loss in ("cauchy", "linear", "linear"):
            # `x` is the motion from the last pose, so that the rotation stays small.
            last = pose
            found = optimize.least_squares(
                lambda x, last=last, good=good: self._residual(moved(last, x), good),
                np.zeros(6),
                x_scale=np.repeat([0.01, 0.001], 3),
                loss=loss,
                max_nfev=25,
            )
            pose = moved(last, found.x)
            everything = self._residual(pose, [np.ones_like(mask) for mask in good]).reshape(-1, 2)
            distance = np.linalg.norm(everything, axis=1)
            # Models of noise are never exact: what is typical decides what is far.
            far = OUTLIER * max(float(np.median(distance)) / 1.18, 1.0)
            parts = np.split(distance < far, np.cumsum([len(mask) for mask in good])[:-1])
            good = [np.asarray(part, dtype=bool) for part in parts]
        number = sum(int(mask.sum()) for mask in good)
        if number < (2 if self.lone else 4) or number < 0.6 * len(distance):
            return None
        if np.median(distance) > 20.0:
            return None
        # Blobs left out count as far as one may be.
        cost = float((distance[np.concatenate(good)] ** 2).sum()) + far**2 * (len(distance) - number)
        return cost, pose, good

    def _deviations(self, index: int) -> Array:
        """(B,) of a pixel coordinate: that of the blob, and that of the cell's place in the patch."""
        sighting = self.seen[index]
        distance = np.linalg.norm(self.camera_from_link[index][:3, 3]) + 1e-6
        shape = self.camera.focal_px * self.shape_deviation[sighting.cell] / distance
        return np.hypot(sighting.deviation_px, shape)

    def _residual(self, pose: Array, good: list[NDArray[np.bool_]]) -> Array:
        parts = []
        for index, (sighting, mask) in enumerate(zip(self.seen, good, strict=True)):
            placed = self.camera_from_link[index] @ pose
            points = self.points[sighting.cell[mask]] @ placed[:3, :3].T + placed[:3, 3]
            error = (self.camera.pixels(points) - sighting.pixel[mask]) / self._deviations(index)[mask, None]
            parts.append(np.nan_to_num(error, nan=1e3))
        return np.concatenate(parts).ravel()

    def _jacobian(self, pose: Array, good: list[NDArray[np.bool_]], step: float = 1e-6) -> Array:
        columns = [
            (self._residual(moved(pose, step * axis), good) - self._residual(moved(pose, -step * axis), good))
            / (2 * step)
            for axis in np.eye(6)
        ]
        return np.stack(columns, axis=1)

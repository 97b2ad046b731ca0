# SPDX-License-Identifier: Apache-2.0
"""Where a patch sits, from pictures of its blinking cells (paper, figure 5a): the skin as its own visual marker.

In: which cell was seen at which pixel, from where, in which posture; the patch's shape; rests, if there are. Out: link
and pose of the root cell with covariance. Once a patch. What can go wrong: too few cells seen, links that explain the
pictures alike.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from robotskin.robots import Robot
from robotskin.selfconfig.common.prior_knowledge import PriorKnowledge
from robotskin.selfconfig.localisation.led_camera import LED_POINT_M, Camera
from robotskin.selfconfig.localisation.led_sightings import SeenCells, Sighting, starts
from robotskin.selfconfig.localisation.localisation import (
    Localisation,
    LocalisationError,
    covariance_of,
    moving_joints,
    segments,
)
from robotskin.selfconfig.localisation.motion_fit import NUISANCES, FitState, MotionFit, rest_signals
from robotskin.selfconfig.localisation.reduced_readings import Readings, Reduced
from robotskin.selfconfig.readings.gravity_samples import GravitySamples

Array = NDArray[np.float64]

LEAST_MARGIN = 30.0
"""Difference in squared normalised residuals below which two links count as equally good."""
FAR_PX = 40.0
"""How far a start may miss other views before its link is given up, unless all links do worse."""
HOPELESS = 30.0
"""How many times the least cost a link may have after the first, rough adjustment."""
OUTLIER = 5.0
"""Standard deviations beyond which a blob is not the cell it claims to be."""


def localise_by_leds(
    robot: Robot,
    camera: Camera,
    sightings: Sequence[Sighting],
    root_from_cell: Array,
    *,
    shape_covariance: Array | None = None,
    links: Sequence[str] | None = None,
    rest_posture: Array | None = None,
    rest: GravitySamples | None = None,
    prior: PriorKnowledge = PriorKnowledge(),  # noqa: B008 - frozen
) -> Localisation:
    """Find the link of a patch and the pose of its root cell on it from what a camera saw.

    One adjustment over all views: the pose, and every cell's pose near its place in the shape. The pictures of several
    postures tell places to a tenth of a millimetre, better than gravity and hinges told the shape; gravity, felt at
    rest in several postures, tells turns better than a small patch's picture. Views in different postures tell the
    link; a lone cell is seen as a point, so that without rests all its turns stay open.

    Args:
        robot: known kinematic model, z of the base frame up.
        camera: calibrated.
        sightings: views of the patch, the robot at rest in each; four cells in one of them, or two views.
        root_from_cell: (n, 4, 4) metres, shape of the patch as `reconstruct` gives it; (1, 4, 4) for a lone cell.
        shape_covariance: (n, 6, 6) as `Reconstruction.covariance`; by default the shape is exact.
        links: candidates; by default all that some joint moves.
        rest_posture: (K, n) rad or m, of rests; rest: what the patch's n cells felt in them.
        rest: see rest_posture.
        prior: what is known of accelerometers.

    Raises:
        LocalisationError: too few cells seen, no pose that explains them, two links that do alike, or arrays that do
            not belong together.
        UnknownNameError: no such link.
    """
    seen = [sighting for sighting in sightings if len(sighting.cell)]
    if not seen:
        raise LocalisationError("no cell of the patch was seen in any view")
    if (rest is None) != (rest_posture is None):
        raise LocalisationError("rests need both the postures and what was felt in them")
    count = len(root_from_cell)
    if rest is not None and len(rest.mean) != count:
        raise LocalisationError(f"rests of {len(rest.mean)} cells for a shape of {count}")
    shape = np.zeros((count, 6, 6)) if shape_covariance is None else np.asarray(shape_covariance, dtype=float)
    # One view tells no link from another, but it shall not be taken for one that stands still.
    postures = [sighting.view.posture for sighting in seen]
    moving = moving_joints(postures) if len(seen) > 1 else set(range(robot.joint_count))
    candidates = {joint: names for joint, names in segments(robot, moving, links).items() if joint >= 0 or links}
    fits = []
    for names in candidates.values():
        felt = None
        if rest is not None and rest_posture is not None:
            felt = rest, rest_signals(robot, names[0], rest_posture)
        fits.append(_LedFit(names, SeenCells(robot, names[0], camera, seen, count), root_from_cell, shape, felt, prior))
    fits.sort(key=lambda fit: fit.start_px)
    # A start from one view already misses the others by far where the link is wrong.
    fits = [fit for fit in fits if fit.start_px <= max(10 * fits[0].start_px, FAR_PX)]
    for fit in fits:
        fit.settle_roughly()
    least = min(fit.cost for fit in fits)
    fits = [fit for fit in fits if fit.cost <= HOPELESS * (least + LEAST_MARGIN)]
    for fit in fits:
        fit.settle()
    fits = sorted((fit for fit in fits if fit.explains()), key=lambda fit: fit.cost)
    if not fits:
        raise LocalisationError(
            f"{sum(len(sighting.cell) for sighting in seen)} sightings in {len(seen)} views are explained by no pose "
            f"on {', '.join(name for names in candidates.values() for name in names)}"
        )
    best = fits[0]
    if len(fits) > 1 and fits[1].cost - best.cost < LEAST_MARGIN:
        raise LocalisationError(
            f"links {best.names[0]} and {fits[1].names[0]} explain the pictures alike; name the link, or add a view in "
            "which the joints between them stand otherwise"
        )
    pose, information = best.placed()
    misfit = best.misfit
    covariance, observed, unknown = covariance_of(information / max(misfit, 1.0) ** 2, robot, best.names[0], pose)
    return Localisation(
        best.names[0], pose, covariance, covariance, observed, unknown, best.names[1:], best.seen.used(), misfit
    )


class _LedFit:
    """One patch on one candidate link: the best start, then the adjustment with the shape left free."""

    def __init__(
        self,
        names: tuple[str, ...],
        seen: SeenCells,
        root_from_cell: Array,
        shape: Array,
        felt: tuple[GravitySamples, Array] | None,
        prior: PriorKnowledge,
    ) -> None:
        self.names, self.seen, self.root_from_cell, self.prior = names, seen, root_from_cell, prior
        self.root = int(np.argmin(np.abs(root_from_cell - np.eye(4)).sum(axis=(1, 2))))
        self.shape = _shared_out(root_from_cell, shape, self.root)
        self.points = root_from_cell[:, :3, 3] + root_from_cell[:, :3, :3] @ LED_POINT_M
        self.reduced, self.noise = Reduced.nothing(len(shape)), np.ones(len(shape))
        if felt is not None:
            self.reduced = Readings(felt[0].mean, np.ones(len(felt[1]))).reduced(felt[1])
            self.noise = np.where(np.isfinite(felt[0].deviation), felt[0].deviation, 1.0)
        self.start_px, self.pose = np.inf, np.eye(4)
        for pose in starts(seen, self.points):
            miss = float(np.median(seen.distances_px(pose, self.points)))
            if miss < self.start_px:
                self.start_px, self.pose = miss, pose
        self.shape_factor, self.cost, self.misfit = 1.0, np.inf, np.inf
        self.state = FitState(self.pose, np.zeros((len(shape), NUISANCES)))

    def settle_roughly(self, passes: int = 8) -> None:
        """A few steps with all blobs, the far ones softly weighted."""
        rigid = self._rigid_distance()
        self.seen.weight = 1.0 / np.hypot(1.0, rigid / (3 * max(float(np.median(rigid)) / 1.18, 1.0)))
        fit = self._fit()
        self.state, _ = fit.settle(self.state, passes)
        self.cost = fit.cost(self.state)

    def settle(self) -> None:
        """Adjust with all blobs, softly weighted; then twice without those that are far off."""
        for _ in range(3):
            fit = self._fit()
            self.state, _ = fit.settle(self.state, passes=25)
            # A blob that bears another cell's name would drag that cell along, so the unbent shape judges it too.
            rigid, free = self._rigid_distance(), self.seen.distances(*fit.cells(self.state))
            far = [OUTLIER * max(float(np.median(distance)) / 1.18, 1.0) for distance in (rigid, free)]
            self.seen.weight = np.where((rigid < far[0]) & (free < far[1]), 1.0, 0.0)
            self._learn_shape_factor(fit)
        fit = self._fit()
        self.state, _ = fit.settle(self.state)
        kept = self.seen.weight > 0
        inside = fit.cost(self.state) + float((self.reduced.floor / self.noise**2).sum())
        freedom = 2 * kept.sum() + self.reduced.readings.sum() - 6
        self.misfit = float(np.sqrt(inside / max(freedom, 1))) if freedom > 6 else 1.0
        # Blobs left out count as far as one may be, and a shape taken for worse as less likely.
        self.cost = inside + far[1] ** 2 * float((~kept).sum()) + 6 * len(self.shape) * np.log(self.shape_factor)

    def explains(self) -> bool:
        """Whether enough of the blobs are where this fit has them."""
        kept = int((self.seen.weight > 0).sum())
        least = 2 if len(self.shape) == 1 else 4
        distance = self.seen.distances_px(self.state.pose, self.points)
        return bool(kept >= least and kept >= 0.6 * len(self.seen.weight) and np.median(distance) <= 20.0)

    def placed(self) -> tuple[Array, Array]:
        """Pose (4, 4) of the root cell and the information (6, 6) on it."""
        return self._fit().placed(self.state, self.root)

    def _fit(self) -> MotionFit:
        scale = np.repeat([1.0, self.shape_factor], 3)
        shape = self.shape * scale[:, None] * scale
        return MotionFit(self.reduced, self.noise, self.root_from_cell, shape, self.prior, self.seen)

    def _rigid_distance(self) -> Array:
        """(B,) how far each blob is off in the unbent shape, in standard deviations with the shape's."""
        deviation_m = self.shape_factor * np.sqrt(self.shape[:, 3:, 3:].trace(axis1=1, axis2=2) / 3)
        return self.seen.distances_px(self.state.pose, self.points) / self.seen.deviations_px(deviation_m)

    def _learn_shape_factor(self, fit: MotionFit) -> None:
        """How much worse than stated the shape's places are, from how far the pictures move them.

        Variance of unit weight: their squares over the number of them that the pictures check. Never below 1.
        """
        known = fit.known[:, 3:6, 3:6]
        shift = self.state.nuisance[:, 3:6]
        squares = float(np.einsum("ni,nij,nj->", shift, known, shift))
        left = fit.nuisance_covariance(self.state)[:, 3:6, 3:6]
        checks = 3 * len(known) - float(np.einsum("nij,nji->", known, left)) - 6
        if checks > 3:
            self.shape_factor = float(np.clip(self.shape_factor * np.sqrt(squares / checks), 1.0, 10.0))


def _shared_out(root_from_cell: Array, shape: Array, root: int) -> Array:
    """(n, 6, 6) each cell's own share of its error about the root; half of the mean of all is the root's.

    The covariance of a cell about the root holds the errors of both.
    """
    if len(shape) == 1:
        return shape
    turn = np.zeros_like(shape)
    turn[:, :3, :3], turn[:, 3:, 3:] = root_from_cell[:, :3, :3], np.eye(3)
    own = 0.5 * shape
    others = np.arange(len(shape)) != root
    own[root] = (turn @ own @ np.swapaxes(turn, 1, 2))[others].mean(axis=0)
    return own

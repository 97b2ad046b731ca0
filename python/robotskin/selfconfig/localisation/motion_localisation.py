"""Which link a patch sits on and where, from motion and gravity alone (paper, II-C step 5, without camera or hands).

In: swings of single joints with what the cells felt, rests if there are, and the shape of the patch. Out: link and pose
of the root cell with covariance. Once a patch. What can go wrong: a patch that no swing moved, links that move it
alike, cells that no place explains (named), directions that motion cannot tell (named, of infinite variance).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robotskin.robots import Robot
from robotskin.selfconfig.common.gravity import ACCELERATION_STEP_MPS2
from robotskin.selfconfig.common.prior_knowledge import PriorKnowledge
from robotskin.selfconfig.localisation.localisation import (
    Localisation,
    LocalisationError,
    covariance_of,
    moving_joints,
    segments,
)
from robotskin.selfconfig.localisation.motion_fit import SIGNALS, FitState, MotionFit, Readings, Reduced, rest_signals
from robotskin.selfconfig.readings.gravity_samples import GravitySamples
from robotskin.selfconfig.readings.link_motion import link_motions
from robotskin.selfconfig.readings.motion_recording import MotionRecording

Array = NDArray[np.float64]

LEAST_MARGIN = 30.0
"""Difference in squared normalised residuals below which two links count as equally good."""


@dataclass(frozen=True, eq=False)
class MotionSignals:
    """The known signals (K, 13) of every segment in the same K instants: all swings, one after another, then rests.

    links: candidates by the joint that moves them; of_joint: their signals; rests: how many of the rows are rests.
    """

    links: dict[int, tuple[str, ...]]
    of_joint: dict[int, Array]
    rests: int


def motion_signals(
    robot: Robot,
    recordings: Sequence[MotionRecording],
    rest_posture: Array | None = None,
    links: Sequence[str] | None = None,
) -> MotionSignals:
    """The signals that `localise_by_motion` needs; the same for all patches, so computed once.

    Args:
        robot: known kinematic model, z of the base frame up.
        recordings: swings; only their motion is used.
        rest_posture: (K, n) of rests, or None.
        links: candidates; by default all that some swing moves.

    Raises:
        LocalisationError: no swings, or none moves any candidate.
        UnknownNameError: no such link.
    """
    if not recordings:
        raise LocalisationError("no swings: a rest tells nothing about place")
    model = robot.model
    swung = {recording.swing.joint for recording in recordings}
    stood = [recording.swing.centre for recording in recordings]
    moving = swung | moving_joints(stood if rest_posture is None else [*stood, *rest_posture])
    numbers = {model.getJointId(robot.joint_names[joint]) for joint in swung}
    candidates = {
        joint: names
        for joint, names in segments(robot, moving, links).items()
        if joint >= 0 and numbers & set(model.supports[model.getJointId(robot.joint_names[joint])])
    }
    if not candidates:
        named = ", ".join(sorted(robot.joint_names[recording.swing.joint] for recording in recordings))
        raise LocalisationError(f"none of the links {', '.join(links or robot.link_names)} moves with {named}")
    rows: dict[int, list[Array]] = {joint: [] for joint in candidates}
    for recording in recordings:
        first = [names[0] for names in candidates.values()]
        motions = link_motions(robot, first, recording.swing, recording.time_s)
        for joint, names in candidates.items():
            motion = motions[names[0]]
            tidal = motion.tidal().reshape(-1, 9)
            rows[joint].append(np.hstack([motion.specific_force, tidal, np.ones((len(tidal), 1))]))
    rests = 0 if rest_posture is None else len(rest_posture)
    if rest_posture is not None:
        for joint, names in candidates.items():
            rows[joint].append(rest_signals(robot, names[0], rest_posture))
    return MotionSignals(candidates, {joint: np.concatenate(parts) for joint, parts in rows.items()}, rests)


def localise_by_motion(
    robot: Robot,
    recordings: Sequence[MotionRecording],
    root_from_cell: Array,
    *,
    cells: NDArray[np.integer] | None = None,
    shape_covariance: Array | None = None,
    rest_posture: Array | None = None,
    rest: GravitySamples | None = None,
    links: Sequence[str] | None = None,
    signals: MotionSignals | None = None,
    prior: PriorKnowledge = PriorKnowledge(),  # noqa: B008 - frozen
) -> Localisation:
    """Find the link of a patch and the pose of its root cell on it.

    For every candidate link the patch's pose, every cell's offset and scale, and the patch's shape within its
    covariance are fitted to all readings at once; the link with the least residual is taken.

    Args:
        robot: known kinematic model, z of the base frame up.
        recordings: swings of single joints, N cells each; the more postures, the better gravity and faults are told
            apart.
        root_from_cell: (n, 4, 4) metres, shape of the patch as `reconstruct` gives it; (1, 4, 4) for a lone cell.
        cells: (n,) rows of the patch's cells in the recordings (`Reconstruction.cells`); by default all N.
        shape_covariance: (n, 6, 6) as `Reconstruction.covariance`; by default the shape is exact.
        rest_posture: (K, n) rad or m, of rests; rest: what all N cells felt in them.
        rest: see rest_posture.
        links: candidates; by default all that some swing moves.
        signals: of the same recordings and postures, if already computed.
        prior: what is known of accelerometers.

    Raises:
        LocalisationError: no swing moves the patch, two links explain it alike, too few readings, or arrays that do
            not belong together.
        UnknownNameError: no such link.
    """
    if (rest is None) != (rest_posture is None):
        raise LocalisationError("rests need both the postures and what was felt in them")
    if not recordings:
        raise LocalisationError("no swings: a rest tells nothing about place")
    rows = np.arange(len(recordings[0].acceleration)) if cells is None else np.asarray(cells)
    count = len(rows)
    if count != len(root_from_cell):
        raise LocalisationError(f"a shape of {len(root_from_cell)} cells for {count} cells of the recordings")
    signals = signals or motion_signals(robot, recordings, rest_posture, links)
    readings = np.concatenate(
        [recording.acceleration[rows] for recording in recordings] + ([] if rest is None else [rest.mean[rows]]), axis=1
    )
    noise = _noise(readings, [len(recording.time_s) for recording in recordings])
    weight = np.ones(readings.shape[1])
    if rest is not None:
        # A rest is a mean of several samples, and counts as many.
        weight[len(weight) - signals.rests :] = np.nanmedian(noise / rest.deviation[rows])
    heard = Readings(readings, weight)
    enough = np.isfinite(noise) & (heard.count >= 3 * 4 * SIGNALS)
    if not enough.any():
        raise LocalisationError(f"none of {count} cells gave {4 * SIGNALS} readings during the swings")
    _require_moved(heard.spread[enough].max(axis=1), noise[enough])
    shape = np.zeros((count, 6, 6)) if shape_covariance is None else np.asarray(shape_covariance, dtype=float)
    fits: dict[int, tuple[float, MotionFit, FitState, Array, NDArray[np.bool_], Reduced]] = {}
    reduced = {joint: heard.reduced(known).of(enough) for joint, known in signals.of_joint.items()}
    floors = {joint: float((of.floor / noise[enough] ** 2).sum()) for joint, of in reduced.items()}
    best = np.inf
    for joint in sorted(floors, key=lambda joint: floors[joint]):
        # No place on a link explains more than its signals do.
        if floors[joint] > best + LEAST_MARGIN:
            break
        fit, state, information, kept = _fit(
            reduced[joint], noise[enough], root_from_cell[enough], shape[enough], prior
        )
        cost = floors[joint] + _bounded_cost(fit, state, reduced[joint])
        fits[joint] = (cost, fit, state, information, kept, reduced[joint])
        best = min(best, cost)
    order = sorted(fits, key=lambda joint: fits[joint][0])
    if len(order) > 1 and fits[order[1]][0] - fits[order[0]][0] < LEAST_MARGIN:
        names = " and ".join(signals.links[joint][0] for joint in order[:2])
        raise LocalisationError(f"links {names} explain the patch's readings alike; swing the joint between them more")
    _, fit, state, information, kept, of = fits[order[0]]
    link, *same = signals.links[order[0]]
    freedom = of.readings[kept].sum() - 6 - 6 * kept.sum()
    squares = (of.floor / noise[enough] ** 2)[kept].sum() + fit.cost(state)
    misfit = float(np.sqrt(squares / freedom))
    common = _common_shape_error(root_from_cell[enough][kept], shape[enough][kept], state.pose)
    covariance, observed, unknown = covariance_of(information / max(misfit, 1.0) ** 2, robot, link, state.pose, common)
    used = np.zeros(count, dtype=bool)
    used[np.flatnonzero(enough)[kept]] = True
    return Localisation(link, state.pose, covariance, observed, unknown, tuple(same), used, misfit)


def _fit(
    reduced: Reduced, noise: Array, root_from_cell: Array, shape: Array, prior: PriorKnowledge
) -> tuple[MotionFit, FitState, Array, NDArray[np.bool_]]:
    """Fit, leave out cells that do not fit, and fit again; at least half of the cells stay."""
    kept = np.ones(len(noise), dtype=bool)
    while True:
        fit = MotionFit(reduced.of(kept), noise[kept], root_from_cell[kept], shape[kept], prior)
        state, information = fit.settle(fit.start())
        cost = fit.cell_costs(state)
        usual = max(float(np.median(cost)), 3.0 * SIGNALS)
        odd = np.flatnonzero(kept)[cost > 4 * usual]
        if len(odd) == 0 or 2 * (kept.sum() - len(odd)) < len(noise):
            return fit, state, information, kept
        kept[odd] = False


def _bounded_cost(fit: MotionFit, state: FitState, reduced: Reduced) -> float:
    """Cost of the fit, with cells left out counted like the worst that stayed."""
    cost = fit.cell_costs(state)
    return float(cost.sum() + (len(reduced.floor) - len(cost)) * cost.max())


def _noise(readings: Array, lengths: Sequence[int]) -> Array:
    """(n,) m/s² standard deviation of single readings: second differences hold noise and hardly any motion.

    Args:
        readings: (n, K, 3), swings one after the other; lengths: how many belong to each swing.
        lengths: see readings.
    """
    squares, number = np.zeros(len(readings)), np.zeros(len(readings), dtype=np.int64)
    begin = 0
    for length in lengths:
        part = readings[:, begin : begin + length]
        begin += length
        bend = part[:, 2:] - 2.0 * part[:, 1:-1] + part[:, :-2]
        there = np.isfinite(bend)
        if not there.all():
            bend = np.where(there, bend, 0.0)
        squares += np.einsum("nka,nka->n", bend, bend)
        number += there.sum(axis=(1, 2))
    noise = np.sqrt(squares / np.maximum(number, 1) / 6)
    return np.where(number > 0, np.maximum(noise, ACCELERATION_STEP_MPS2 / np.sqrt(12)), np.nan)


def _require_moved(spread: Array, noise: Array) -> None:
    """Raise LocalisationError if the readings of all cells vary like noise, both (n,) m/s²."""
    if np.all(spread < 1.2 * noise):
        raise LocalisationError(
            f"no swing moved the patch: its readings vary by {spread.max():.3f} m/s², their noise is {noise.max():.3f}"
        )


def _common_shape_error(root_from_cell: Array, shape: Array, pose: Array) -> Array | None:
    """(6, 6) what all cells err by together, because their shape is told from a root that errs itself.

    The covariance of a cell about the root holds both their errors; half of its mean is the root's.
    """
    if len(root_from_cell) < 2:
        return None
    turned = np.zeros_like(shape)
    turned[:, :3, :3] = root_from_cell[:, :3, :3]
    turned[:, 3:, 3:] = pose[:3, :3]
    return 0.5 * np.mean(turned @ shape @ np.swapaxes(turned, 1, 2), axis=0)

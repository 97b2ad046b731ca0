# SPDX-License-Identifier: Apache-2.0
"""Which link a patch sits on and where, from motion and gravity alone (paper, II-C step 5, without camera or hands).

In: swings of single joints with what the cells felt, rests if there are, and the shape of the patch. Out: link and pose
of the root cell with covariance. Once a patch. What can go wrong: a patch that no swing moved, links that move it
alike, cells that no place explains (named), directions that motion cannot tell (named, of infinite variance).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from robotskin.robots import Robot
from robotskin.selfconfig.common.gravity import ACCELERATION_STEP_MPS2
from robotskin.selfconfig.common.prior_knowledge import PriorKnowledge
from robotskin.selfconfig.localisation.localisation import (
    Localisation,
    LocalisationError,
    ModelEvidence,
    covariance_of,
    moving_joints,
    segments,
)
from robotskin.selfconfig.localisation.model_errors import wrong_models
from robotskin.selfconfig.localisation.motion_fit import FitState, MotionFit, rest_signals
from robotskin.selfconfig.localisation.reduced_readings import SIGNALS, Readings, Reduced
from robotskin.selfconfig.readings.gravity_samples import GravitySamples
from robotskin.selfconfig.readings.link_motion import link_motions
from robotskin.selfconfig.readings.motion_recording import MotionRecording

Array = NDArray[np.float64]

LEAST_MARGIN = 30.0
"""Difference in squared normalised residuals below which two links count as equally good."""
MOST_APART, LEAST_BENDS = 8, 20
"""Noise is told from so many second differences, of instants that lie as near as they must and so far apart at most."""


@dataclass(frozen=True, eq=False)
class MotionSignals:
    """The known signals (K, 13) of every segment in the same K instants: all swings, one after another, then rests.

    links: candidates by the joint that moves them; of_joint: their signals; rests: how many of the rows are rests.
    wrong: (M, K, 13) by the same joint, what they change by if the robot differs from its model by one standard
        deviation in each of M ways; ways: (M,) their numbers, in the order of `wrong_models`.
    """

    links: dict[int, tuple[str, ...]]
    of_joint: dict[int, Array]
    rests: int
    wrong: dict[int, NDArray[np.float32]]
    ways: dict[int, NDArray[np.int64]]


def motion_signals(
    robot: Robot,
    recordings: Sequence[MotionRecording],
    rest_posture: Array | None = None,
    links: Sequence[str] | None = None,
    prior: PriorKnowledge = PriorKnowledge(),  # noqa: B008 - frozen
) -> MotionSignals:
    """The signals that `localise_by_motion` needs; the same for all patches, so computed once.

    Args:
        robot: known kinematic model, z of the base frame up.
        recordings: swings; only their motion is used.
        rest_posture: (K, n) of rests, or None.
        links: candidates; by default all that some swing moves.
        prior: how far the robot may differ from its model.

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
    found = _signals(robot, recordings, rest_posture, candidates)
    # What a wrong model changes hardly depends on what moves beside a swing, which then costs nothing.
    alone, swung_alone = recordings, found
    if any(recording.posture is not None for recording in recordings):
        alone = [replace(recording, posture=None) for recording in recordings]
        swung_alone = _signals(robot, alone, rest_posture, candidates)
    wrong: dict[int, list[NDArray[np.float32]]] = {joint: [] for joint in candidates}
    ways: dict[int, list[int]] = {joint: [] for joint in candidates}
    for way, (joint, other) in enumerate(wrong_models(robot, prior)):
        behind = {one: names for one, names in candidates.items() if joint in _path(robot, one)}
        for one, signals in _signals(other, alone, rest_posture, behind).items():
            # Of a humanoid they are gigabytes; what is small beside the signals needs no more digits.
            wrong[one].append((signals - swung_alone[one]).astype(np.float32))
            ways[one].append(way)
    rests = 0 if rest_posture is None else len(rest_posture)
    stacked = {
        joint: np.array(wrong.pop(joint), dtype=np.float32).reshape(-1, *found[joint].shape) for joint in candidates
    }
    numbered = {joint: np.array(numbers, dtype=np.int64) for joint, numbers in ways.items()}
    return MotionSignals(candidates, found, rests, stacked, numbered)


def _path(robot: Robot, joint: int) -> set[int]:
    """The joints between the base and a link that `joint` carries."""
    found = set()
    while joint >= 0:
        found.add(joint)
        joint = int(robot.core.joint_parents[joint])
    return found


def _signals(
    robot: Robot,
    recordings: Sequence[MotionRecording],
    rest_posture: Array | None,
    candidates: dict[int, tuple[str, ...]],
) -> dict[int, Array]:
    """(K, 13) by joint, of the first of the links that it carries."""
    rows: dict[int, list[Array]] = {joint: [] for joint in candidates}
    for recording in recordings:
        first = [names[0] for names in candidates.values()]
        motions = link_motions(robot, first, recording.swing, recording.time_s, recording.posture)
        for joint, names in candidates.items():
            motion = motions[names[0]]
            tidal = motion.tidal().reshape(-1, 9)
            rows[joint].append(np.hstack([motion.specific_force, tidal, np.ones((len(tidal), 1))]))
    if rest_posture is not None:
        for joint, names in candidates.items():
            rows[joint].append(rest_signals(robot, names[0], rest_posture))
    return {joint: np.concatenate(parts) for joint, parts in rows.items()}


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
        shape_covariance: (n, 6, 6) as `Reconstruction.inner_covariance`; by default the shape is exact.
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
    signals = signals or motion_signals(robot, recordings, rest_posture, links, prior)
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
    reduced = {
        joint: heard.reduced(known, signals.wrong[joint]).of(enough) for joint, known in signals.of_joint.items()
    }
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
    answers = fit.answers(state)
    by_model = answers.T @ answers
    known = information / max(misfit, 1.0) ** 2
    root_error = _root_error(root_from_cell, shape, state.pose)
    common = by_model + root_error
    evidence = ModelEvidence(signals.ways[order[0]], *fit.of_model(state), answers, known, root_error)
    covariance, observed, unknown = covariance_of(known, robot, link, state.pose, common)
    used = np.zeros(count, dtype=bool)
    used[np.flatnonzero(enough)[kept]] = True
    whole = covariance_of(known, robot, link, state.pose, by_model)[0]
    return Localisation(link, state.pose, covariance, whole, observed, unknown, tuple(same), used, misfit, evidence)


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

    They are of neighbouring instants. Of a cell that was read at every second or third instant only, they are of those.

    Args:
        readings: (n, K, 3), swings one after the other; lengths: how many belong to each swing.
        lengths: see readings.
    """
    squares, number = np.zeros(len(readings)), np.zeros(len(readings), dtype=np.int64)
    for apart in range(1, MOST_APART + 1):
        cells = np.flatnonzero(number < 3 * LEAST_BENDS)
        if not len(cells):
            break
        read, begin = readings if len(cells) == len(readings) else readings[cells], 0
        for length in lengths:
            part = read[:, begin : begin + length]
            begin += length
            bend = part[:, 2 * apart :] - 2.0 * part[:, apart:-apart] + part[:, : -2 * apart]
            there = np.isfinite(bend)
            if not there.all():
                bend = np.where(there, bend, 0.0)
            squares[cells] += np.einsum("nka,nka->n", bend, bend)
            number[cells] += there.sum(axis=(1, 2))
    noise = np.sqrt(squares / np.maximum(number, 1) / 6)
    return np.where(number > 0, np.maximum(noise, ACCELERATION_STEP_MPS2 / np.sqrt(12)), np.nan)


def _require_moved(spread: Array, noise: Array) -> None:
    """Raise LocalisationError if the readings of all cells vary like noise, both (n,) m/s²."""
    if np.all(spread < 1.2 * noise):
        raise LocalisationError(
            f"no swing moved the patch: its readings vary by {spread.max():.3f} m/s², their noise is {noise.max():.3f}"
        )


def _root_error(root_from_cell: Array, shape: Array, pose: Array) -> Array:
    """(6, 6) what the root cell errs by beside its patch; its pose stands for the patch's."""
    if len(root_from_cell) < 2:
        return np.zeros((6, 6))
    turned = np.eye(6)
    turned[3:, 3:] = pose[:3, :3]
    root = int(np.argmin(np.abs(root_from_cell - np.eye(4)).max(axis=(1, 2))))
    return np.asarray(turned @ shape[root] @ turned.T, dtype=np.float64)

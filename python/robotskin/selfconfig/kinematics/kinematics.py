# SPDX-License-Identifier: Apache-2.0
"""The robot's kinematics from its skin alone (paper, II-D): axes, patches and cells in one frame, each with its doubt.

In: one swing of a joint after the other, the patches' shapes. Out: a `KinematicEstimate`. Once a configuration.
What can go wrong: too little motion (an error); what motion cannot tell is named, never guessed.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from robotskin.selfconfig.common.prior_knowledge import PriorKnowledge
from robotskin.selfconfig.common.side_by_side import side_by_side
from robotskin.selfconfig.kinematics.activity import activity_matrix, kinematic_tree
from robotskin.selfconfig.kinematics.adjustment import KinematicAdjustment, KinematicState
from robotskin.selfconfig.kinematics.estimate import KinematicEstimate
from robotskin.selfconfig.kinematics.frames import base_convention
from robotskin.selfconfig.kinematics.screw_tree import ScrewTree
from robotskin.selfconfig.kinematics.start import KinematicsError, first_tree
from robotskin.selfconfig.kinematics.unobservable import doubt
from robotskin.selfconfig.readings.gravity_samples import GravitySamples
from robotskin.selfconfig.readings.motion_recording import MotionRecording
from robotskin.selfconfig.readings.swing_statistics import SwingStatistics
from robotskin.selfconfig.reconstruction.rigid_patches import RigidPatches

Array = NDArray[np.float64]

GOOD_FIT = 2.0
"""Noise factor up to which a start that was given is believed to have led to the best fit."""
NO_FIT = 30.0
"""Noise factor above which nothing was found; a model that misses gravity by 5 degrees reaches it."""


def estimate_kinematics(
    recordings: Sequence[MotionRecording | SwingStatistics],
    patches: RigidPatches,
    *,
    joint_names: Sequence[str],
    rests: tuple[Array, GravitySamples] | None = None,
    activity: Mapping[int, NDArray[np.bool_]] | None = None,
    sliding: Collection[int] = (),
    start: ScrewTree | None = None,
    offset: Array | None = None,
    scale: Array | None = None,
    prior: PriorKnowledge = PriorKnowledge(),  # noqa: B008 - frozen
) -> KinematicEstimate:
    """Estimate axes, patches and cells from motion.

    Every joint swings alone, in several postures; every cell feels each swing. The start is the paper's: the axis in
    every cell's frame, tangential acceleration, radius (`joint_axis.py`), undone joint by joint (`start.py`).
    Then all unknowns are refined at once (`adjustment.py`), swings in which a cell was bumped losing weight.

    Args:
        recordings: of the same N cells, or their statistics; joints are revolute, and count as `joint_names` does. Two
            postures a joint, in which the joints further out differ, are the least for a robot of more than one joint;
            gravity should pull along and against each cell's axes.
        patches: shapes of the patches of these cells.
        joint_names: (n) of the robot's joints, in the order of its posture vector.
        rests: postures (K, n) rad and what the cells felt in them.
        activity: by joint, (N,) which cells it moves; from `activity_matrix` of the recordings if not given.
        sliding: indices of prismatic joints. Their swings are left out and their axes not estimated; they may move only
            where no turning joint lies further in, such as a mobile base, which no reading notices.
        start: a model to begin with, such as a nominal one; if it leads to no fit, ours is taken.
        offset: (N, 3) m/s² and scale: (N, 3), of the accelerometers, if the reconstruction found them.
        scale: see offset.
        prior: what is known of accelerometers.

    Raises:
        KinematicsError: no joint moves anything, a patch gave nothing, or the refinement did not settle.
        ValueError: recordings of other cells or joints; an activity that no open chain has.
    """
    swings = _statistics([one for one in recordings if _joint(one) not in sliding], patches, rests)
    rows = _patch_activity(recordings, patches, activity)
    _require_still(swings, rows, sliding, joint_names)
    rows = {joint: moved for joint, moved in rows.items() if joint not in sliding}
    count = len(patches.patch)
    offset = np.zeros((count, 3)) if offset is None else offset
    scale = np.ones((count, 3)) if scale is None else scale
    if not any(moved.any() for moved in rows.values()):
        raise KinematicsError(f"none of the joints {sorted(rows)} moves any of the {count} cells")
    kinematic_tree(np.array(list(rows.values())))
    corrected = [_corrected(swing, offset, scale) for swing in swings]
    tree, order = first_tree(corrected, patches, rows)
    problem = KinematicAdjustment(swings, patches, prior)
    own_start = KinematicState(tree, patches.root_from_cell[:, :3, :3].copy(), offset, scale)
    results = []
    if start is not None:
        if not np.array_equal(start.joints, tree.joints) or start.paths != tree.paths:
            raise ValueError(
                f"start with joints {start.joints.tolist()} on paths {start.paths}: found were {tree.paths}"
            )
        # A start too far off to settle is no worse than none.
        with suppress(KinematicsError):
            results.append(settled(problem, replace(own_start, tree=start)))
    if not results or results[0][1] > GOOD_FIT:
        results.append(settled(problem, own_start))
    state, factor, weights, iterations = min(results, key=lambda result: result[1])
    new_from_base = base_convention(state.tree, state.tree.base_from_root[patches.patch] @ patches.root_from_cell)
    state = replace(state, tree=state.tree.seen_from(new_from_base))
    if factor > NO_FIT:
        raise KinematicsError(f"readings lie {factor:.0f} deviations off the best model: is the order of joints right?")
    normal = problem.linearise(state, weights)
    # A sliding joint's swings told nothing here, so that it counts as one that never swung.
    still = {joint: joint in rows for joint in range(len(joint_names)) if joint not in state.tree.joints}
    knowledge = doubt(state.tree, normal, patches, factor, tuple(joint_names), still, order.open)
    return KinematicEstimate(
        joint_names=tuple(joint_names),
        tree=state.tree,
        patches=patches,
        rotation=state.rotation,
        offset=state.offset,
        scale=state.scale,
        noise_factor=factor,
        swing_weight=weights,
        iterations=iterations,
        axis_deviation_rad=knowledge.axis_deviation_rad,
        point_deviation_m=knowledge.point_deviation_m,
        covariance=knowledge.covariance,
        unobservable=knowledge.unobservable,
    )


def three_phase_tree(
    recordings: Sequence[MotionRecording | SwingStatistics],
    patches: RigidPatches,
    rests: tuple[Array, GravitySamples] | None = None,
    activity: Mapping[int, NDArray[np.bool_]] | None = None,
    offset: Array | None = None,
    scale: Array | None = None,
) -> ScrewTree:
    """The paper's three phases alone (II-D), without the refinement; arguments as `estimate_kinematics`."""
    swings = _statistics(recordings, patches, rests)
    rows = _patch_activity(recordings, patches, activity)
    count = len(patches.patch)
    offset = np.zeros((count, 3)) if offset is None else offset
    scale = np.ones((count, 3)) if scale is None else scale
    return first_tree([_corrected(swing, offset, scale) for swing in swings], patches, rows)[0]


def _statistics(
    recordings: Sequence[MotionRecording | SwingStatistics],
    patches: RigidPatches,
    rests: tuple[Array, GravitySamples] | None,
) -> list[SwingStatistics]:
    if not recordings:
        raise KinematicsError("no recordings: every joint has to swing at least once")
    for number, recording in enumerate(recordings):
        of = recording.coefficient if isinstance(recording, SwingStatistics) else recording.acceleration
        if len(of) != len(patches.patch):
            raise ValueError(f"recording {number} has {len(of)} cells, the patches {len(patches.patch)}")
    swings = list(
        side_by_side(
            lambda one: one if isinstance(one, SwingStatistics) else SwingStatistics.of_recording(one), recordings
        )
    )
    if rests is not None:
        postures, samples = rests
        if samples.mean.shape[:2] != (len(patches.patch), len(postures)):
            raise ValueError(f"rests: samples of shape {samples.mean.shape} for {len(postures)} postures")
        swings += [SwingStatistics.of_rest(posture, samples, pose) for pose, posture in enumerate(postures)]
    return swings


def _patch_activity(
    recordings: Sequence[MotionRecording | SwingStatistics],
    patches: RigidPatches,
    activity: Mapping[int, NDArray[np.bool_]] | None,
) -> dict[int, NDArray[np.bool_]]:
    """By joint, (P,) whether it moves a patch; a fifth of the cells must say so, as one may have been bumped."""
    if activity is None:
        motions = [one for one in recordings if isinstance(one, MotionRecording)]
        if len(motions) < len(recordings):
            raise ValueError("activity: has to be given with statistics, which no longer tell it")
        joints = list(dict.fromkeys(recording.swing.joint for recording in motions))
        activity = dict(zip(joints, activity_matrix(motions), strict=True))
    sizes = np.bincount(patches.patch, minlength=patches.count)
    return {
        joint: np.bincount(patches.patch, weights=cells, minlength=patches.count) >= 0.2 * sizes
        for joint, cells in activity.items()
    }


def _joint(recording: MotionRecording | SwingStatistics) -> int:
    return recording.joint if isinstance(recording, SwingStatistics) else recording.swing.joint


def _require_still(
    swings: Sequence[SwingStatistics],
    rows: Mapping[int, NDArray[np.bool_]],
    sliding: Collection[int],
    names: Sequence[str],
) -> None:
    """A slide behind a turning joint changes how far the cells are from its axis; it must not move between swings."""
    for joint in sliding:
        behind = joint in rows and any(
            (moved & rows[joint]).any() and (moved & ~rows[joint]).any()
            for other, moved in rows.items()
            if other not in sliding
        )
        places = [float(swing.posture[joint]) for swing in swings]
        if behind and max(places) - min(places) > 1e-3:
            raise ValueError(
                f"{names[joint]} slides behind a turning joint and stands from {min(places)} m to {max(places)} m: "
                "it must stand still while others swing"
            )


def _corrected(swing: SwingStatistics, offset: Array, scale: Array) -> SwingStatistics:
    """Coefficients of ideal accelerometers, faults as given."""
    coefficient = swing.coefficient.copy()
    coefficient[:, 0] -= np.where(swing.information[:, :1, 0] > 0, offset, 0.0)
    return replace(swing, coefficient=coefficient / scale[:, None])


def settled(
    problem: KinematicAdjustment, state: KinematicState, least_gain: float = 0.1, passes: int = 300
) -> tuple[KinematicState, float, Array, int]:
    """Levenberg-Marquardt until a step lowers the sum of squares by next to nothing.

    Returns the state, the estimated over the stated deviation of the readings (at least 1), weights, and steps.

    Raises:
        KinematicsError: no settling within `passes` steps.
    """
    damping = 1e-3
    residual = problem.residual(state)
    for number in range(1, passes + 1):
        factor = problem.noise_factor(residual)
        weights = problem.weights(residual, factor)
        normal = problem.linearise(state, weights)
        cost = problem.cost(state, residual, weights)
        while True:
            common, own = normal.step(damping)
            tried = problem.moved(state, common, own)
            then = problem.residual(tried)
            gained = cost - problem.cost(tried, then, weights)
            if gained >= -1e-10 * cost - 1e-9:
                break
            # A coarser ladder lands up to ten times too high, and creeps along a curved valley of lone cells.
            damping *= 3.0
            if damping > 1e8:
                return state, factor, weights, number
        state, residual, damping = tried, then, max(0.1 * damping, 1e-7)
        # What no reading tells may drift without end; it gains nothing.
        if gained < least_gain * factor**2 and damping < 1e-2:
            factor = problem.noise_factor(residual)
            return state, factor, problem.weights(residual, factor), number
    raise KinematicsError(f"no settled kinematics after {passes} steps; the last gained {gained:.1e}")

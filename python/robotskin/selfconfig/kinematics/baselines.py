# SPDX-License-Identifier: Apache-2.0
"""What two published methods minimise, on the same data: named baselines of `robotskin bench selfconfig`.

Watanabe et al. (HIRO, IROS 2021) and, as they describe it, Mittendorfer et al. (Humanoids 2014) find six parameters of
one cell a link on a robot whose joints are known. Both take accelerometers as ideal, and of a swing only its largest
accelerations. Here the joints are the true ones and each cell's search begins at its true place, so that nothing but
the objective limits the result.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from robotskin.selfconfig.common.prior_knowledge import PriorKnowledge
from robotskin.selfconfig.kinematics.adjustment import KinematicAdjustment, KinematicState
from robotskin.selfconfig.kinematics.screw_tree import ScrewTree
from robotskin.selfconfig.readings.gravity_samples import GravitySamples
from robotskin.selfconfig.readings.motion_recording import MotionRecording
from robotskin.selfconfig.readings.swing_statistics import SIGNALS, SwingStatistics, swing_signals
from robotskin.selfconfig.reconstruction.rigid_patches import RigidPatches

Array = NDArray[np.float64]
Objective = Literal["hiro", "mittendorfer"]

LAST_JOINTS = 3
"""Of the joints that carry a cell, those from i − 2 to i are swung for it."""
POINTS = 4
"""Instants of a swing that HIRO's objective takes."""
SMOOTHED = 5
"""Readings about an instant that are averaged."""


def baseline_places(
    objective: Objective,
    recordings: Sequence[MotionRecording],
    rests: tuple[Array, GravitySamples],
    true: ScrewTree,
) -> ScrewTree:
    """Places of lone cells that minimise a published objective.

        e1 = Σ over rests |R(q) g − mean reading|²
        e2 = Σ over the last three joints' swings |measured − modelled acceleration|²

    HIRO: rotations by e1, then positions by e2 at four instants of largest acceleration, modelled in full.
    Mittendorfer: e1 + e2 at once, at the one instant of largest acceleration, of the tangential part alone; gravity is
    that at rest.

    Args:
        objective: which.
        recordings: of C cells, one a link.
        rests: postures (K, n) and what the cells felt.
        true: whose patch c is cell c.

    Returns:
        the true axes with the cells where the method puts them.
    """
    count = len(true.paths)
    postures, samples = rests
    still = [
        replace(one, information=np.sign(one.information))
        for one in (SwingStatistics.of_rest(posture, samples, pose) for pose, posture in enumerate(postures))
    ]
    moving = [_at_peaks(recording, objective, true) for recording in recordings]
    patches = RigidPatches.lone_cells(count)
    ideal = PriorKnowledge(offset_mps2=1e-7, scale=1e-7)
    state = KinematicState(true, np.tile(np.eye(3), (count, 1, 1)), np.zeros((count, 3)), np.ones((count, 3)))
    unknowns = 4 * len(true.joints) + 6 * count
    rotations, positions = np.zeros((2, unknowns), dtype=bool)
    rotations[4 * len(true.joints) :] = np.tile([False] * 3 + [True] * 3, count)
    positions[4 * len(true.joints) :] = np.tile([True] * 3 + [False] * 3, count)
    if objective == "mittendorfer":
        return _minimised(KinematicAdjustment(still + moving, patches, ideal), state, rotations | positions).tree
    turned = _minimised(KinematicAdjustment(still, patches, ideal), state, rotations)
    return _minimised(KinematicAdjustment(moving, patches, ideal), turned, positions).tree


def _at_peaks(recording: MotionRecording, objective: Objective, tree: ScrewTree) -> SwingStatistics:
    """The swing as equations for its coefficients at the instants that an objective takes."""
    swing = recording.swing
    derivatives = [swing.displacement(recording.time_s, order) for order in range(3)]
    signals = swing_signals(derivatives[0], derivatives[1], derivatives[2])
    size = np.abs(derivatives[2])
    inner = np.arange(SMOOTHED, len(size) - SMOOTHED)
    peaks = inner[(size[inner] >= size[inner - 1]) & (size[inner] > size[inner + 1])]
    peaks = peaks[np.argsort(-size[peaks])][: POINTS if objective == "hiro" else 1]
    window = peaks[:, None] + np.arange(SMOOTHED) - SMOOTHED // 2
    readings = recording.acceleration[:, window].mean(axis=2)
    if objective == "hiro":
        rows = signals[peaks]
    else:
        rows = np.zeros((1, SIGNALS))
        rows[:, 3] = signals[peaks, 3]
        readings = readings - recording.acceleration[:, :16].mean(axis=1)[:, None]
    coefficient = np.linalg.pinv(rows) @ readings
    information = np.tile(rows.T @ rows, (len(readings), 1, 1))
    for cell, path in enumerate(tree.paths):
        if swing.joint not in tree.joints[list(path[-LAST_JOINTS:])]:
            information[cell] = 0.0
    return SwingStatistics(swing.joint, np.array(swing.centre), coefficient, information, np.ones(len(readings)))


def _minimised(
    problem: KinematicAdjustment, state: KinematicState, free: NDArray[np.bool_], passes: int = 50
) -> KinematicState:
    """Levenberg-Marquardt over some of the unknowns."""
    weights, damping = problem.heard.astype(float), 1e-3
    cost = problem.cost(state, problem.residual(state), weights)
    for _ in range(passes):
        normal = problem.linearise(state, weights)
        matrix, right = normal.matrix[np.ix_(free, free)], normal.right[free]
        scale = np.sqrt(np.maximum(matrix.diagonal(), 1e-6))
        gained = 0.0
        while damping < 1e8:
            common = np.zeros(len(free))
            scaled = matrix / scale / scale[:, None] + damping * np.eye(len(scale))
            common[free] = np.linalg.solve(scaled, right / scale) / scale
            tried = problem.moved(state, common, np.zeros((len(state.offset), 9)))
            then = problem.cost(tried, problem.residual(tried), weights)
            if then <= cost:
                gained, state, cost = cost - then, tried, then
                break
            damping *= 10.0
        damping = max(0.1 * damping, 1e-9)
        if gained < 1e-7 * cost:
            break
    return state

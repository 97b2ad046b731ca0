# SPDX-License-Identifier: Apache-2.0
"""Which joint moves which cell, and the kinematic tree that follows from it (paper, III-B: activity matrix AM).

In: recordings of all cells while one joint alone swings, one or more a joint. Out: the matrix and the tree.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import f as f_distribution

from robotskin.selfconfig.common.side_by_side import side_by_side
from robotskin.selfconfig.readings.motion_recording import MotionRecording

Array = NDArray[np.float64]

SWAY = 3.0
"""Times as hard as the median cell a cell must be shaken to count as moved, where the whole robot sways."""


def activity_matrix(
    recordings: Sequence[MotionRecording], false_alarm: float = 1e-9, *, sways: bool = False
) -> NDArray[np.bool_]:
    """Which joint moves which cell.

    A moved cell feels gravity turn, with the joint's displacement d, and the motion itself, with d̈ and ḋ². Its three
    readings are regressed on (1, d, d², ḋ², d̈); it is moved if these explain more than chance lets them (F-test). An
    amplitude alone, as in the paper, needs a threshold that grows with the noise of every cell.

    Args:
        recordings: one swing each; the same N cells in all. Several of one joint, in different postures, add up: a cell
            close to a vertical axis feels nothing of it in one posture.
        false_alarm: probability that a cell at rest is called moved, for one cell and joint.
        sways: the robot stands, so that a swing shakes all of it; more than half of its cells are not moved.

    Returns:
        (J, N) a row for each joint, in the order of its first recording; a cell that gave fewer than ten readings
        counts as not moved.

    Raises:
        ValueError: no recordings, or of different numbers of cells.
    """
    if not recordings or len({len(recording.acceleration) for recording in recordings}) != 1:
        raise ValueError(f"{len(recordings)} recordings: at least one is needed, all of the same cells")
    rows: dict[int, NDArray[np.bool_]] = {}
    moves = side_by_side(lambda recording: _moved(recording, false_alarm, sways), recordings)
    for recording, moved in zip(recordings, moves, strict=True):
        joint = recording.swing.joint
        rows[joint] = rows[joint] | moved if joint in rows else moved
    return np.array(list(rows.values()))


def _moved(recording: MotionRecording, false_alarm: float, sways: bool) -> NDArray[np.bool_]:
    swing, time_s = recording.swing, recording.time_s
    angle, rate, acceleration = (swing.displacement(time_s, derivative) for derivative in range(3))
    signals = np.stack([np.ones_like(angle), angle, angle**2, rate**2, acceleration], axis=1)
    signals /= np.abs(signals).max(axis=0)
    moved = np.zeros(len(recording.acceleration), dtype=bool)
    shaken_mps2 = np.full(len(moved), np.nan)
    valid = recording.present
    # Cells that missed the same instants share a regression; most missed none.
    for pattern, cells in _alike(valid):
        count = int(pattern.sum())
        if count < 10:
            continue
        basis = np.linalg.qr(signals[pattern])[0]
        readings = recording.acceleration if len(cells) == len(valid) else recording.acceleration[cells]
        if count < len(pattern):
            readings = readings[:, pattern]
        # The first column is the constant; the others explain what they span of the readings less their mean.
        along = np.matmul(basis.T, readings)
        explained = (along[:, 1:] ** 2).sum(axis=(1, 2))
        left = np.einsum("nma,nma->n", readings, readings) - (along**2).sum(axis=(1, 2))
        used, freedom = 3 * (signals.shape[1] - 1), 3 * (count - signals.shape[1])
        ratio = (explained / used) / np.maximum(left / freedom, 1e-12)
        moved[cells] = f_distribution.sf(ratio, used, freedom) < false_alarm
        shaken_mps2[cells] = np.sqrt(explained / count)
    if sways and moved.any():
        moved &= shaken_mps2 > SWAY * np.nanmedian(shaken_mps2)
    return moved


def _alike(valid: NDArray[np.bool_]) -> Iterator[tuple[NDArray[np.bool_], NDArray[np.int64]]]:
    """Each pattern (M,) of instants with readings, and the cells (n,) that have it."""
    cells: dict[bytes, list[int]] = {}
    for cell, row in enumerate(valid):
        cells.setdefault(row.tobytes(), []).append(cell)
    for same in cells.values():
        yield valid[same[0]], np.array(same)


@dataclass(frozen=True, eq=False)
class KinematicTree:
    """Rigid segments of the robot, as far as the skin can tell them apart.

    segment: (N,) of each cell. joints: for each segment, the rows of the activity matrix between its parent
    and it; more than one where no cell lies between them, so that their order stays open. parent: (S,) segment towards
    the base, -1 for one that no other skinned segment carries.
    """

    segment: NDArray[np.int64]
    joints: tuple[tuple[int, ...], ...]
    parent: NDArray[np.int64]


def kinematic_tree(activity: NDArray[np.bool_]) -> KinematicTree:
    """The tree from the activity matrix: cells moved by the same joints are one segment, more joints lie further out.

    Args:
        activity: (J, N).

    Raises:
        ValueError: two segments share a joint, but none's joints contain the other's and neither do those of a third:
            no open chain moves like that. Names the joints.
    """
    patterns, segment = np.unique(activity.T, axis=0, return_inverse=True)
    sets = [frozenset(np.flatnonzero(pattern).tolist()) for pattern in patterns]
    parent, joints = [], []
    for moved_by in sets:
        inner = [other for other, theirs in enumerate(sets) if theirs < moved_by]
        inner.sort(key=lambda other: len(sets[other]))
        for a, b in itertools.pairwise(inner):
            if not sets[a] <= sets[b]:
                raise ValueError(
                    f"segment moved by joints {sorted(moved_by)} lies behind two that do not lie behind each other: "
                    f"{sorted(sets[a])} and {sorted(sets[b])}"
                )
        above = inner[-1] if inner else -1
        parent.append(above)
        joints.append(tuple(sorted(moved_by - (sets[above] if above >= 0 else frozenset()))))
    return KinematicTree(segment.reshape(-1).astype(np.int64), tuple(joints), np.array(parent, dtype=np.int64))

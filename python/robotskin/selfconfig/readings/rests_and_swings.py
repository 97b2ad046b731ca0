# SPDX-License-Identifier: Apache-2.0
"""What a series of joints and accelerometers tells: its rests, and its motions of single joints.

In: a series of any motion. Out: a recording as a babbling gives one. Instants at which several joints move are left
out.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.signal import savgol_filter

from robotskin.layout.cell import PORTS
from robotskin.selfconfig.readings.felt_series import FeltSeries
from robotskin.selfconfig.readings.measured_swing import MeasuredSwing
from robotskin.selfconfig.readings.motion_recording import MotionRecording
from robotskin.selfconfig.readings.recording import BabblingRecording, RecordingError
from robotskin.selfconfig.readings.swing_statistics import swing_signals
from robotskin.selfconfig.topology.neighbours import NeighbourLists

Array = NDArray[np.float64]
Span = tuple[int, int]
"""First row, and the one after the last."""

STILL_RAD_S, SMOOTH_S = 0.01, 0.06
"""A joint that is slower than this stands; rates are those of a parabola over so many seconds."""
TURN_S = 0.15
"""A joint that stands for less is only turning round."""
SETTLE_S, REST_S, REST_SAMPLES = 0.1, 0.06, 64
"""Of a rest that counts which comes after the first; it lasts the second at least; the last samples are taken."""
SWING_S, SWING_RAD, SWING_SAMPLES = 0.4, 0.01, 64
"""A motion that is shorter, smaller or of fewer instants tells nothing."""
SAME_POSTURE_RAD = 0.02
MOST_LAG_S, LAG_STEP_S = 0.04, 0.004


def recording_of(series: FeltSeries, robot: str, lists: NeighbourLists | None = None) -> BabblingRecording:
    """The recording of a robot by that name; accelerometers that are late by one time are put back onto the joints'.

    Args:
        series: of its n joints and N sensors.
        robot: name.
        lists: which cell is plugged into which, by the sensors' keys; by default that is not known.

    Raises:
        RecordingError: no rest or no motion of a single joint, or neighbours of other cells.
    """
    keys = series.keys()
    lists = lists or NeighbourLists(keys, np.zeros((len(keys), PORTS), dtype=np.int64))
    if sorted(lists.cell.tolist()) != sorted(keys.tolist()):
        odd = sorted(set(lists.cell.tolist()) ^ set(keys.tolist()))
        raise RecordingError(f"cells {odd[:5]} are not among both sensors and neighbours")
    moving = _moving(series)
    rests = _rests(series, moving)
    spans = list(_single_motions(series, moving))
    if not rests or not spans:
        raise RecordingError(
            f"{len(rests)} rests and {len(spans)} motions of single joints: a skin is configured from both. "
            f"A rest lasts {SETTLE_S + REST_S:g} s at least; a joint swings for {SWING_S:g} s while the others stand"
        )
    row = {int(key): number for number, key in enumerate(keys)}
    order = np.array([row[int(key)] for key in lists.cell])
    swings = [_swing(series, joint, span) for joint, span in spans]
    lag_s = _lag_s(swings)
    return BabblingRecording(
        robot=robot,
        joint_names=series.joint_names,
        lists=lists,
        unit_ports=np.empty((0, 4), dtype=np.int64),
        rest_posture=np.array([posture for posture, _ in rests]),
        rest_acceleration=np.stack([felt for _, felt in rests], axis=1)[order],
        swings=tuple(MotionRecording(swing.swing, swing.time_s - lag_s, swing.acceleration[order]) for swing in swings),
        duration_s=float(series.time_s[-1] - series.time_s[0]),
    )


def _moving(series: FeltSeries) -> NDArray[np.bool_]:
    """(T, n) which joints move; a pause of a turn is none."""
    period_s = float(np.median(np.diff(series.time_s)))
    window = max(2 * round(SMOOTH_S / period_s / 2) + 1, 5)
    if len(series.time_s) < window:
        raise RecordingError(
            f"{len(series.time_s)} instants {1e3 * period_s:.0f} ms apart: {window} are needed at least"
        )
    rate = savgol_filter(series.position, window, 2, deriv=1, delta=period_s, axis=0)
    moving = np.abs(rate) > STILL_RAD_S
    for joint in range(moving.shape[1]):
        for begin, end in _runs(~moving[:, joint]):
            inside = begin > 0 and end < len(moving)
            if inside and series.time_s[end - 1] - series.time_s[begin] < TURN_S:
                moving[begin:end, joint] = True
    return moving


def _runs(true: NDArray[np.bool_]) -> Iterator[Span]:
    """Where it is true on end."""
    edges = np.flatnonzero(np.diff(np.r_[False, true, False].astype(int)))
    yield from zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)


def _rests(series: FeltSeries, moving: NDArray[np.bool_]) -> list[tuple[Array, Array]]:
    """Posture (n) and (N, samples, 3) of each posture that was rested in, the first time."""
    found: list[tuple[Array, Array]] = []
    for begin, end in _runs(np.asarray(~moving.any(axis=1), dtype=bool)):
        settled = begin + int(np.searchsorted(series.time_s[begin:end], series.time_s[begin] + SETTLE_S))
        if settled >= end or series.time_s[end - 1] - series.time_s[settled] < REST_S:
            continue
        rows = slice(max(settled, end - REST_SAMPLES), end)
        posture = series.position[rows].mean(axis=0)
        if any(np.abs(posture - other).max() < SAME_POSTURE_RAD for other, _ in found):
            continue
        felt = np.full((len(series.sensor_names), REST_SAMPLES, 3), np.nan)
        taken = series.acceleration[rows].swapaxes(0, 1)
        felt[:, : taken.shape[1]] = taken
        found.append((posture, felt))
    return found


def _single_motions(series: FeltSeries, moving: NDArray[np.bool_]) -> Iterator[tuple[int, Span]]:
    """Joint and rows of each motion in which it moves alone."""
    alone = moving.sum(axis=1) == 1
    for joint in range(moving.shape[1]):
        for begin, end in _runs(alone & moving[:, joint]):
            if end - begin < SWING_SAMPLES or series.time_s[end - 1] - series.time_s[begin] < SWING_S:
                continue
            if np.ptp(series.position[begin:end, joint]) >= SWING_RAD:
                yield joint, (begin, end)


def _swing(series: FeltSeries, joint: int, span: Span) -> MotionRecording:
    rows = slice(*span)
    time_s = series.time_s[rows] - series.time_s[span[0]]
    position = series.position[rows]
    centre = position.mean(axis=0)
    centre[joint] = (position[:, joint].max() + position[:, joint].min()) / 2
    swing = MeasuredSwing.of(joint, centre, time_s, position[:, joint])
    return MotionRecording(swing, time_s, np.ascontiguousarray(series.acceleration[rows].swapaxes(0, 1)))


def _lag_s(swings: list[MotionRecording]) -> float:
    """Seconds by which the accelerometers are later than the joints: where the motion explains most of what is felt."""
    lags = np.arange(-MOST_LAG_S, MOST_LAG_S + LAG_STEP_S / 2, LAG_STEP_S)
    left = np.array([sum(_unexplained(swing, lag) for swing in swings) for lag in lags])
    best = int(np.clip(np.argmin(left), 1, len(lags) - 2))
    low, middle, high = left[best - 1 : best + 2]
    bend = low - 2 * middle + high
    return float(lags[best] + (0.5 * LAG_STEP_S * (low - high) / bend if bend > 0 else 0.0))


def _unexplained(swing: MotionRecording, lag_s: float) -> float:
    """Squares that are left of all readings of whole cells; the lag would move the ends out of the motion."""
    inner = (swing.time_s > MOST_LAG_S) & (swing.time_s < swing.swing.duration_s - MOST_LAG_S)
    whole = swing.present[:, inner].all(axis=1)
    at = swing.time_s[inner] - lag_s
    signals = swing_signals(*(swing.swing.displacement(at, derivative) for derivative in range(3)))
    basis = np.linalg.qr(signals / np.abs(signals).max(axis=0))[0]
    felt = swing.acceleration[whole][:, inner]
    return float((felt**2).sum() - (np.matmul(basis.T, felt) ** 2).sum())

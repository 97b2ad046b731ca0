# SPDX-License-Identifier: Apache-2.0
"""What a series of joints and accelerometers tells: its rests, and its motions of single joints.

In: a series of any motion. Out: a recording as a babbling gives one. Instants at which several joints move are left
out.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d
from scipy.signal import savgol_filter

from robotskin.layout.cell import PORTS
from robotskin.selfconfig.common.gravity import GRAVITY_MPS2
from robotskin.selfconfig.readings.felt_series import FeltSeries
from robotskin.selfconfig.readings.measured_swing import MeasuredSwing
from robotskin.selfconfig.readings.motion_recording import MotionRecording
from robotskin.selfconfig.readings.recording import BabblingRecording, RecordingError
from robotskin.selfconfig.readings.sensor_lag import lag_s_of
from robotskin.selfconfig.topology.neighbours import NeighbourLists

Array = NDArray[np.float64]
Span = tuple[int, int]
"""First row, and the one after the last."""

STILL_RAD_S, SMOOTH_S = 0.01, 0.06
"""A joint that is slower than this stands; rates are those of a parabola over so many seconds."""
TURN_S = 0.15
"""A joint that stands for less is only turning round."""
SHAKEN_SHARE, SHAKEN_S = 0.05, 1.0
"""A joint that is slower than this share of the fastest one, within so many seconds, is only shaken by that: servos
give way a little."""
SETTLE_S, REST_S, REST_SAMPLES = 0.1, 0.06, 64
"""Of a rest that counts which comes after the first; it lasts the second at least; the last samples are taken."""
SWING_S, SWING_RAD, SWING_SAMPLES = 0.4, 0.01, 64
"""A motion that is shorter, smaller or of fewer instants tells nothing."""
SAME_POSTURE_RAD = 0.02
LEAST_GRAVITY, MOST_GRAVITY = 0.75, 1.25
"""Of what an accelerometer at rest reads over gravity: scales and offsets are smaller, other units are farther off."""


def recording_of(series: FeltSeries, robot: str, lists: NeighbourLists | None = None) -> BabblingRecording:
    """The recording of a robot by that name; accelerometers that are late by one time are put back onto the joints'.

    Args:
        series: of its n joints and N sensors.
        robot: name.
        lists: which cell is plugged into which, by the sensors' keys; by default that is not known.

    Raises:
        RecordingError: fewer than two instants, no rest or no motion of a single joint, neighbours of other cells, a
            sensor that does not read gravity at rest, or no lag that can be told.
    """
    keys = series.keys()
    lists = lists or NeighbourLists(keys, np.zeros((len(keys), PORTS), dtype=np.int64))
    if sorted(lists.cell.tolist()) != sorted(keys.tolist()):
        odd = sorted(set(lists.cell.tolist()) ^ set(keys.tolist()))
        raise RecordingError(f"cells {odd[:5]} are not among both sensors and neighbours")
    speed = _speeds(series)
    moving = _moving(series, speed > STILL_RAD_S)
    rests = _rests(series, moving)
    spans = list(_single_motions(series, moving & ~_only_shaken(series, speed)))
    if not rests or not spans:
        raise RecordingError(
            f"{len(rests)} rests and {len(spans)} motions of single joints: a skin is configured from both. "
            f"A rest lasts {SETTLE_S + REST_S:g} s at least; a joint swings for {SWING_S:g} s while the others stand"
        )
    _require_gravity(series, [felt for _, felt in rests])
    row = {int(key): number for number, key in enumerate(keys)}
    order = np.array([row[int(key)] for key in lists.cell])
    swings = [_swing(series, joint, span) for joint, span in spans]
    lag_s = lag_s_of(swings, series.sensor_names)
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


def _speeds(series: FeltSeries) -> Array:
    """(T, n) rad/s without sign."""
    if len(series.time_s) < 2:
        raise RecordingError(f"{len(series.time_s)} instants: a series has rests and motions of some seconds each")
    period_s = float(np.median(np.diff(series.time_s)))
    window = max(2 * round(SMOOTH_S / period_s / 2) + 1, 5)
    if len(series.time_s) < window:
        raise RecordingError(
            f"{len(series.time_s)} instants {1e3 * period_s:.0f} ms apart: {window} are needed at least"
        )
    return np.abs(np.asarray(savgol_filter(series.position, window, 2, deriv=1, delta=period_s, axis=0)))


def _only_shaken(series: FeltSeries, speed: Array) -> NDArray[np.bool_]:
    """(T, n) which joints move so little beside the fastest one that they would stand without it."""
    period_s = float(np.median(np.diff(series.time_s)))
    peak = np.asarray(maximum_filter1d(speed, max(round(SHAKEN_S / period_s), 1), axis=0))
    return np.asarray(peak < SHAKEN_SHARE * peak.max(axis=1, keepdims=True))


def _moving(series: FeltSeries, moving: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """(T, n) which joints move; a pause of a turn is none."""
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


def _require_gravity(series: FeltSeries, rests: list[Array]) -> None:
    """Refuse accelerations in another unit; rests: (N, samples, 3) each."""
    for number, name in enumerate(series.sensor_names):
        whole = [felt[number][np.isfinite(felt[number]).all(axis=1)] for felt in rests]
        # Medians: a bump, or the end of a way that the joints told late, is no other unit.
        sizes = [np.linalg.norm(np.median(samples, axis=0)) for samples in whole if len(samples)]
        if not sizes:
            continue
        reads = float(np.median(sizes))
        if not LEAST_GRAVITY < reads / GRAVITY_MPS2 < MOST_GRAVITY:
            raise RecordingError(
                f"sensor {name} reads {reads:.3g} at rest, where gravity is {GRAVITY_MPS2:.2f} m/s²: accelerations are "
                f"in m/s² (1 g is {GRAVITY_MPS2}); leave the three columns of a broken sensor out"
            )


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

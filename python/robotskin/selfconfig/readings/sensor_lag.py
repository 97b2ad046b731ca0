# SPDX-License-Identifier: Apache-2.0
"""By how much accelerometers are later than the joints: the time at which the motion explains most of what is felt.

In: swings of single joints, with readings missing anywhere. Out: one time, or a refusal where none can be told.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robotskin.selfconfig.readings.motion_recording import MotionRecording
from robotskin.selfconfig.readings.recording import RecordingError
from robotskin.selfconfig.readings.swing_statistics import SIGNALS, swing_signals

Array = NDArray[np.float64]

MOST_LAG_S, LAG_STEP_S = 0.04, 0.004
LEAST_READINGS = 4 * SIGNALS
"""Of a sensor in a swing: with fewer, five signals explain anything."""
CLEAR = 6.0
"""The best lag must explain that many deviations of chance more than the worst."""


def lag_s_of(swings: Sequence[MotionRecording], sensor_names: Sequence[str]) -> float:
    """Seconds by which the accelerometers are later than the joints; each counts at the instants where it was read.

    Args:
        swings: of single joints, as measured; N sensors.
        sensor_names: (N).

    Raises:
        RecordingError: no sensor was read often enough, none answers the motions, or the lag is beyond `MOST_LAG_S`.
    """
    parts = [part for part in map(_Inner.of, swings) if len(part.felt)]
    if not parts:
        further = f" and {len(sensor_names) - 5} more" if len(sensor_names) > 5 else ""
        raise RecordingError(
            f"sensors {', '.join(sensor_names[:5])}{further}: none has {LEAST_READINGS} readings in any motion of a "
            "single joint, so how late they are cannot be told; read them while the joints move"
        )
    # One step beyond the limit on both sides: a lag at the limit still lies between two others.
    steps = round(MOST_LAG_S / LAG_STEP_S) + 1
    lags = LAG_STEP_S * np.arange(-steps, steps + 1)
    left = np.array([sum(part.unexplained(lag) for part in parts) for lag in lags])
    best = int(np.argmin(left))
    noise = left[best] / sum(3 * part.read.sum() for part in parts)
    fitted = sum(3 * SIGNALS * len(part.felt) for part in parts)
    if left.max() - left[best] <= CLEAR * np.sqrt(2 * fitted) * noise:
        raise RecordingError(
            "what the sensors read does not answer the motions of the joints, so how late they are cannot be told; "
            "joints and sensors must be of one robot and one clock, and sensors sit on links that move"
        )
    if best in (0, len(lags) - 1):
        way = "later" if best else "earlier"
        raise RecordingError(
            f"the sensors are {way} than the joints by more than {1e3 * MOST_LAG_S:g} ms, which is the most that is "
            "found; shift their columns in time"
        )
    low, middle, high = left[best - 1 : best + 2]
    return float(lags[best] + 0.5 * LAG_STEP_S * (low - high) / (low - 2 * middle + high))


@dataclass(frozen=True, eq=False)
class _Inner:
    """The instants of a swing that no lag moves out of it, M, and the N sensors that were read often enough there.

    swing: the motion. time_s: (M,). read: (N, M) whether it was. felt: (N, M, 3) m/s², 0 where not read.
    """

    swing: MotionRecording
    time_s: Array
    read: Array
    felt: Array

    @classmethod
    def of(cls, swing: MotionRecording) -> _Inner:
        margin_s = MOST_LAG_S + LAG_STEP_S
        inner = (swing.time_s > margin_s) & (swing.time_s < swing.swing.duration_s - margin_s)
        read = swing.present[:, inner]
        often = read.sum(axis=1) >= LEAST_READINGS
        read = read[often]
        felt = np.where(read[..., None], swing.acceleration[often][:, inner], 0.0)
        return cls(swing, swing.time_s[inner], read.astype(float), felt)

    def unexplained(self, lag_s: float) -> float:
        """Squares of the readings that the motion leaves if the sensors are that late, m²/s⁴."""
        motion = self.swing.swing
        signals = swing_signals(*(motion.displacement(self.time_s - lag_s, derivative) for derivative in range(3)))
        basis = np.linalg.qr(signals / np.abs(signals).max(axis=0))[0]
        along = np.matmul(basis.T, self.felt)
        explained = float((along**2).sum())
        some = np.flatnonzero(self.read.sum(axis=1) < len(self.time_s))
        if len(some):
            # Over some of the instants the signals are no longer orthonormal; the ridge only keeps the inverse finite.
            products = (basis[:, :, None] * basis[:, None, :]).reshape(len(basis), -1)
            gram = (self.read[some] @ products).reshape(-1, SIGNALS, SIGNALS) + 1e-9 * np.eye(SIGNALS)
            explained += float((along[some] * (np.linalg.solve(gram, along[some]) - along[some])).sum())
        return float((self.felt**2).sum()) - explained

# SPDX-License-Identifier: Apache-2.0
"""What one swing of one joint tells about every cell, in five vectors a cell instead of a thousand readings.

In: recordings, or readings at rest. Out: coefficients with their information. Nothing is lost: the sum of squares over
the readings is, up to a constant, the one over the coefficients.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robotskin.selfconfig.common.gravity import ACCELERATION_STEP_MPS2
from robotskin.selfconfig.readings.gravity_samples import GravitySamples
from robotskin.selfconfig.readings.motion_recording import MotionRecording

Array = NDArray[np.float64]

SIGNALS = 5
"""1, cos d − 1, sin d, d̈, ḋ² of the displacement d of the joint."""
AT_REST = -1
"""In place of a joint, where none moves."""


@dataclass(frozen=True, eq=False)
class SwingStatistics:
    """A swing of a revolute joint, or a rest, of N cells.

    A link that turns by d(t) about a fixed line carries its cells so that each feels, in its own frame and exactly,

        f(t) = c₀ + c₁ (cos d − 1) + c₂ sin d + c₃ d̈ + c₄ ḋ²

    c₀ is gravity's reaction at d = 0, c₁ and c₂ its turning, c₃ the tangential acceleration of one rad/s², c₄ the
    centripetal one of one rad/s. A cell that the joint does not move has c₀ alone.

    joint: index of the joint, or AT_REST. posture: (n) rad, at d = 0.
    coefficient: (N, 5, 3) m/s² in the cell's frame.
    information: (N, 5, 5) inverse covariance of the coefficients of one axis, s⁴/m²; zero for a cell without readings.
    deviation: (N,) m/s² of one reading along an axis, as the rest of the fit shows it.
    """

    joint: int
    posture: Array
    coefficient: Array
    information: Array
    deviation: Array

    @classmethod
    def of_recording(cls, recording: MotionRecording, outlier: float = 6.0) -> SwingStatistics:
        """Fit the signals to the readings of every cell.

        Args:
            recording: of one swing; NaN where a reading is missing.
            outlier: readings farther than this many deviations off the fit are left out (a bump, a bit error).
        """
        swing, readings = recording.swing, recording.acceleration
        signals = swing_signals(*(swing.displacement(recording.time_s, derivative) for derivative in range(3)))
        unit = np.abs(signals).max(axis=0)
        basis = signals / unit
        use = recording.present.copy()
        filled = readings if use.all() else np.where(use[..., None], readings, 0.0)
        gram, fit, left = _fitted(basis, filled, use)
        # The largest of a thousand good residuals lies below 5 deviations; only cells with larger ones are looked at.
        squares = np.einsum("nma,nma->n", left, left)
        spread = np.sqrt(squares / np.maximum(3 * use.sum(axis=1), 1))
        for cell in np.flatnonzero(left.max(axis=(1, 2), initial=0.0) > 5 * spread).tolist():
            for _ in range(2):
                typical = np.median(left[cell, use[cell]]) / 0.6745 if use[cell].any() else 0.0
                limit = outlier * max(typical, ACCELERATION_STEP_MPS2 / 3)
                use[cell] &= (left[cell] <= limit).all(axis=1)
                one = slice(cell, cell + 1)
                kept = np.where(use[one][..., None], filled[one], 0.0)
                gram[one], fit[one], left[one] = _fitted(basis, kept, use[one])
                squares[cell] = (left[cell] ** 2).sum()
        freedom = 3 * np.maximum(use.sum(axis=1) - SIGNALS, 1)
        deviation = np.sqrt(squares / freedom)
        deviation = np.maximum(deviation, ACCELERATION_STEP_MPS2 / np.sqrt(12))
        information = gram * unit[:, None] * unit / deviation[:, None, None] ** 2
        enough = use.sum(axis=1) >= 4 * SIGNALS
        return cls(
            joint=swing.joint,
            posture=np.array(swing.centre, dtype=float),
            coefficient=np.where(enough[:, None, None], fit / unit[:, None], 0.0),
            information=np.where(enough[:, None, None], information, 0.0),
            deviation=deviation,
        )

    @classmethod
    def of_rest(cls, posture: Array, samples: GravitySamples, pose: int) -> SwingStatistics:
        """Readings at rest in one posture.

        Args:
            posture: (n) rad.
            samples: of the N cells.
            pose: number of the posture in the samples.
        """
        count = len(samples.mean)
        coefficient, information = np.zeros((count, SIGNALS, 3)), np.zeros((count, SIGNALS, SIGNALS))
        there = samples.present()[:, pose]
        coefficient[there, 0] = samples.mean[there, pose]
        information[there, 0, 0] = samples.deviation[there] ** -2
        return cls(AT_REST, np.array(posture, dtype=float), coefficient, information, samples.deviation)


def swing_signals(displacement: Array, rate: Array, acceleration: Array) -> Array:
    """(M, 5) the signals of a swing at M instants; displacement (M,) rad, rate rad/s, acceleration rad/s²."""
    return np.stack(
        [np.ones_like(displacement), np.cos(displacement) - 1, np.sin(displacement), acceleration, rate**2], axis=1
    )


def _fitted(basis: Array, readings: Array, use: NDArray[np.bool_]) -> tuple[Array, Array, Array]:
    """Gram matrix (n, 5, 5), coefficients (n, 5, 3) and absolute residuals (n, M, 3); readings are 0 where not used."""
    squares = (basis[:, :, None] * basis[:, None, :]).reshape(len(basis), -1)
    whole = bool(use.all())
    counted = np.ones((1, len(basis))) if whole else use.astype(float)
    gram = np.tile((counted @ squares).reshape(-1, SIGNALS, SIGNALS), (len(use) if whole else 1, 1, 1))
    # The ridge only keeps the inverse finite; it is 1e-9 of one reading's information.
    fit = np.linalg.solve(gram + 1e-9 * np.eye(SIGNALS), basis.T @ readings)
    left: Array = basis @ fit
    np.subtract(readings, left, out=left)
    np.abs(left, out=left)
    if not whole:
        left[~use] = 0.0
    return gram, np.asarray(fit), left

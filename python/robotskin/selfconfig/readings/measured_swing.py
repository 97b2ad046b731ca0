# SPDX-License-Identifier: Apache-2.0
"""A motion of one joint as its encoder told it, of any form."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline, make_lsq_spline

from robotskin.selfconfig.babbling.joint_sine import JointSine

Array = NDArray[np.float64]

KNOT_S = 0.05
DEGREE = 5


@dataclass(frozen=True, eq=False)
class MeasuredSwing(JointSine):
    """q(t) = centre + spline(t) on one joint, for 0 <= t <= T.

    The amplitude is half of the way from end to end, the frequency half the number of turns over T.
    """

    spline: BSpline

    @classmethod
    def of(cls, joint: int, centre: Array, time_s: Array, position: Array) -> MeasuredSwing:
        """The smooth motion nearest to positions (M,) of a joint at times (M,) s, which begin with 0."""
        lasts_s = float(time_s[-1])
        inner = np.linspace(0.0, lasts_s, max(round(lasts_s / KNOT_S), 1) + 1)[1:-1]
        # Each knot needs readings beside it: where there are none, no motion can be told either.
        inner = inner[[bool((np.abs(time_s - knot) < KNOT_S).sum() >= DEGREE + 1) for knot in inner]]
        knots = np.r_[[0.0] * (DEGREE + 1), inner, [lasts_s] * (DEGREE + 1)]
        spline = make_lsq_spline(time_s, position - centre[joint], knots, k=DEGREE)
        rate = spline.derivative()(np.linspace(0.0, lasts_s, len(time_s)))
        fast = rate[np.abs(rate) > 0.1 * np.abs(rate).max()]
        turns = int((np.diff(np.sign(fast)) != 0).sum())
        return cls(joint, centre, float(np.ptp(position)) / 2, max(turns, 1) / 2 / lasts_s, lasts_s, spline)

    def displacement(self, time_s: Array, derivative: int = 0) -> Array:
        """Displacement of the joint at times (M,) s, or its first, second, third... derivative."""
        within = np.clip(np.asarray(time_s, dtype=float), 0.0, self.duration_s)
        return np.asarray(self.spline.derivative(derivative)(within) if derivative else self.spline(within))

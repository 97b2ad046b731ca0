# SPDX-License-Identifier: Apache-2.0
"""A tool with two handles on a hinge: where its hinge is, and how much each finger presses so that it does not turn."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import lsq_linear

Array = NDArray[np.float64]

CLOSING_NM = 0.3
"""What the spring of the pliers takes where their jaws meet."""
MARGIN = 1.4
"""By which the hand presses more than that: pads rub along the handles as these turn."""
HINGE_SIGMA_M = 0.010
"""Standard deviation of where the hinge is believed to be along the handles."""
POINT_SIGMA_M = 0.0004
"""Of a contact point across them."""
LEAST_TURN_RAD = 0.03
"""A handle that has turned less tells nothing of the hinge."""
LEAST_N, MOST_N = 0.3, 10.0
"""Of a finger, and of the thumb."""
MOMENT_WEIGHT = 100.0


class Levers:
    """What the hand learns of the tool while it squeezes it. The thumb is on one handle, three fingers on the other.

    Args:
        believed_m: height of the hinge along the handles, in the frame of the heights given later.
        across_m: from the hinge's axis to the outer side of the handle under the fingers.
        even: press with each finger alike, for comparison.
    """

    def __init__(self, believed_m: float, across_m: float, even: bool = False) -> None:
        self.believed_m, self.across_m, self.even = believed_m, across_m, even
        self.hinge_m = believed_m
        self._start: Array | None = None

    def begin(self, closed_m: Array) -> None:
        """The handle of the fingers rests: (3,) metres of their contact points along the way in which it closes."""
        self._start = closed_m.copy()

    def feel(self, height_m: Array, closed_m: Array) -> None:
        """It has turned: contact points (3,) along the handle and along the way in which it closes.

        Its outer side is a line about the hinge. Where the line meets the one at rest, there the hinge is.
        """
        if self._start is None:
            return
        slope, offset = np.polyfit(height_m, closed_m, 1)
        turn = float(np.arctan(-slope))
        if turn < LEAST_TURN_RAD:
            return
        rest = float(self._start.mean()) + self.across_m * (1 - 1 / np.cos(turn))
        found = (rest - offset) / slope
        middle = float(height_m.mean())
        spread = 1 / len(height_m) + (found - middle) ** 2 / float(((height_m - middle) ** 2).sum())
        variance = (POINT_SIGMA_M / turn) ** 2 * (spread + 1 / len(height_m))
        weight = HINGE_SIGMA_M**2 / (HINGE_SIGMA_M**2 + variance)
        self.hinge_m = float(self.believed_m + weight * np.clip(found - self.believed_m, -0.03, 0.03))

    def forces(self, height_m: Array) -> Array:
        """(4,) newton of index, middle, ring finger and thumb that touch at (4,) metres along the handles.

        The thumb closes its handle against the spring. The fingers press as much in all, and turn theirs as much.
        """
        lever = np.maximum(self.hinge_m - height_m, 0.01)
        moment = MARGIN * CLOSING_NM
        thumb = moment / lever[3]
        if self.even:
            return np.append(np.full(3, thumb / 3), thumb)
        rows = np.vstack([10 * np.ones(3), MOMENT_WEIGHT * lever[:3], 0.05 * np.eye(3)])
        wanted = np.concatenate([[10 * thumb, MOMENT_WEIGHT * moment], np.full(3, 0.05 * thumb / 3)])
        return np.append(lsq_linear(rows, wanted, bounds=(LEAST_N, MOST_N)).x, thumb)

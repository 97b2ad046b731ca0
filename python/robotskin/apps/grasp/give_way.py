# SPDX-License-Identifier: Apache-2.0
"""What a hand does where a person pushes one of its fingers from outside: all fingers go along, with what they hold."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robotskin.apps.grasp.fingers import Hand

Array = NDArray[np.float64]

PUSHED_N = 0.5
"""On backs and sides together; below it nothing pushes."""
SPEED_M_S_N = 0.0025
PUSHED_BY_M, MOST_M = 0.004, 0.012
"""All fingers go, by so much at most, until the pushed cell has moved so far: a locked grip is stiff."""
ROLLING_M = 0.003
"""What is round rolls out from between pads that do not go along: they go by so much in any case."""
RETURN_PER_S = 1.0
"""How fast they come back."""
END_RAD, END_GAIN = 0.05, 4.0
"""Nearer to its end a joint's spring is stiffer by this gain: no push must bring it there."""
REACH_M = 0.01
"""Of the damped inverse: what a finger reaches with less than this lever it reaches only in part."""


class GiveWay:
    """Shifts the fingers' references; figures are of the hand's frame.

    across: (3,) unit vector across handles, where pads would come off them; None: what is held is round.
    """

    def __init__(self, hand: Hand, *, across: Array | None) -> None:
        self._hand = hand
        self._least_m = ROLLING_M if across is None else 0.0
        self._ways = np.eye(3) if across is None else np.eye(3) - np.outer(across, across)
        self._cells = np.concatenate(hand.outside)
        self._before: Array | None = None
        """(c, 3) metres where the cells were when the push began."""
        self.shift = np.zeros(3)
        """(3,) metres by which all pads are shifted."""

    def step(self, posture: Array, cell_force: Array, period_s: float) -> bool:
        """Whether something pushes, with (n) rad or m of the robot's joints and (N) newton of all cells."""
        force = cell_force[self._cells]
        if force.sum() < PUSHED_N:
            self._before = None
            self.shift = (1.0 - RETURN_PER_S * period_s) * self.shift
            return False
        hand_from_cell = self._hand.frames(posture, self._cells)
        place = hand_from_cell[:, :3, 3]
        if self._before is None:
            self._before = place
        strongest = int(np.argmax(force))
        moved = float(np.linalg.norm(place[strongest] - self._before[strongest]))
        most = max(MOST_M if moved < PUSHED_BY_M else self._least_m, float(np.linalg.norm(self.shift)))
        shift = self.shift - period_s * SPEED_M_S_N * force @ hand_from_cell[:, :3, 2] @ self._ways
        self.shift = shift * min(1.0, most / max(float(np.linalg.norm(shift)), 1e-9))
        return True

    def shifted(self, angles: Array) -> Array:
        """(4, 4) rad with each pad moved by `shift`, as far as its finger can."""
        if not self.shift.any():
            return angles
        moves = self._hand.pads(angles).moves
        across = moves @ moves.transpose(0, 2, 1) + REACH_M**2 * np.eye(3)
        return np.asarray(angles + np.einsum("fij,fi->fj", moves, np.linalg.solve(across, self.shift[:, None])[..., 0]))

    def kept_from_ends(self, angles: Array, measured: Array) -> Array:
        """(4, 4) rad that pull (4, 4) measured rad back where a joint is near its end."""
        inside = np.clip(measured, self._hand.lower + END_RAD, self._hand.upper - END_RAD)
        return np.asarray(angles + END_GAIN * (inside - measured))

# SPDX-License-Identifier: Apache-2.0
"""The skills of the pads: take, hold, squeeze and let go; each goes on by one look of 4 ms at a time."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from robotskin.teaching.worker import LOOK_S, Steps, Worker

Array = NDArray[np.float64]

CLOSE_M_S, TOUCH_M_S, SQUEEZE_M_S = 0.03, 0.006, 0.004
TOUCH_N, LOOSE_N, HOLD_N, LARGEST_N = 0.25, 2.0, 3.0, 6.5
"""The second is as loose as a thing of 0.25 kg does not slip."""
HELD_N = 0.6
"""A pad that feels less holds nothing."""
NEAR = 0.3
"""Nearness at which the pads slow down."""
FIT_FROM_N, FIT_RANGE_N = 1.5, 1.0
"""Below the first the slope would be that of the uneven touch; a narrower range tells no slope."""
FIXED_CLOSING_M = 0.004
"""By which a baseline closes from the usual size of the thing."""


@dataclass
class Squeezed:
    """What a squeeze has felt. width_m, force_n: the samples; diameter_m: at the first touch."""

    width_m: list[float] = field(default_factory=list)
    force_n: list[float] = field(default_factory=list)
    carrying: list[tuple[int, int]] = field(default_factory=list)
    """How many cells of each pad carried: a second one makes the skin stiffer than before."""
    diameter_m: float = float("nan")
    peak_n: float = 0.0

    @property
    def slope_n_per_m(self) -> float:
        """Of force over closing, skin included; the closing is fitted over the force, which is measured better.

        NaN where it was not squeezed enough.
        """
        return self._slope(self._usable)

    def stiffness_n_per_m(self, skin_n_per_m: float) -> float:
        """Of the thing alone: the skin of both pads, in series with it, taken out.

        skin_n_per_m: of both pads where one cell each carries; where more carry, each pad is stiffer by their number.
        Told by the samples in which the same cells carry, of which there are most. NaN as for the slope.
        """
        carrying = np.array(self.carrying).reshape(-1, 2)
        counts, number = np.unique(carrying[self._usable], axis=0, return_counts=True)
        for cells in counts[np.argsort(-number)]:
            slope = self._slope(self._usable & (carrying == cells).all(axis=1))
            if np.isfinite(slope):
                skin_gives = float((1.0 / cells).mean()) / skin_n_per_m
                return 1.0 / max(1.0 / slope - skin_gives, 1e-6)
        return float("nan")

    @property
    def _usable(self) -> NDArray[np.bool_]:
        force = np.array(self.force_n)
        return (force > FIT_FROM_N) & (force < LARGEST_N)

    def _slope(self, chosen: NDArray[np.bool_]) -> float:
        force, width = np.array(self.force_n)[chosen], np.array(self.width_m)[chosen]
        if len(force) < 10 or float(np.ptp(force)) < FIT_RANGE_N:
            return float("nan")
        gives = -float(np.polyfit(force, width, 1)[0])
        return 1.0 / gives if gives > 0 else float("nan")

    def force_at_n(self, width_m: float) -> float:
        """Newton where the pads were a width apart: the largest felt where they never came so near."""
        width = np.array(self.width_m)
        if not len(width):
            return 0.0
        reached = np.flatnonzero(width <= width_m)
        return self.force_n[reached[0]] if len(reached) else max(self.force_n)


def holds(worker: Worker) -> bool:
    """Whether both pads feel something between them."""
    return bool((worker.force_n > HELD_N).all())


def take(worker: Worker, hold_n: float = HOLD_N) -> Steps:
    """Close until both pads touch, each waiting for the other, then to a force. Returns whether something is held.

    Pads whose cells are lost close no further: they would not feel what they press.
    """
    pads = worker.gripper.joints
    touches = np.zeros(2, dtype=bool)
    while not touches.all():
        if worker.lost.any():
            return False
        near = worker.gripper.nearness(worker.session).max() > NEAR
        speed = TOUCH_M_S if near else CLOSE_M_S
        worker.move_pads(np.where(touches, 0.0, -speed * LOOK_S))
        if (worker.wanted[pads][~touches] <= 1e-4).any():
            return False
        yield
        # A round thing may roll from one pad to the other: only what touches now counts.
        touches = worker.force_n > TOUCH_N
    yield from hold(worker, hold_n, 0.6)
    if not holds(worker):
        worker.hold_n = None
        return False
    return True


def hold(worker: Worker, force_n: float, seconds: float) -> Steps:
    """Hold with a force from now on; goes on for a time."""
    worker.hold_n = force_n
    yield from worker.wait(seconds)


def squeeze(worker: Worker, largest_n: float = LARGEST_N, hold_n: float = HOLD_N) -> Steps:
    """Loosen, then close steadily up to a force, and hold again. Returns what was felt, `Squeezed`."""
    found = Squeezed()
    found.diameter_m = float(worker.openings_m.sum())
    yield from hold(worker, LOOSE_N, 0.8)
    worker.hold_n = None
    patience = round(4.0 / LOOK_S)
    while worker.force_n.mean() < largest_n and patience > 0 and not worker.lost.any():
        patience -= 1
        worker.move_pads(-0.5 * SQUEEZE_M_S * LOOK_S)
        yield
        found.width_m.append(float(worker.openings_m.sum()))
        found.force_n.append(float(worker.force_n.mean()))
        found.carrying.append(worker.carrying())
        found.peak_n = max(found.peak_n, float(worker.force_n.max()))
        if (worker.wanted[worker.gripper.joints] <= 1e-5).all():
            break
    if worker.lost.any():  # what was felt since is less than what presses
        found = Squeezed(diameter_m=found.diameter_m, peak_n=found.peak_n)
    yield from hold(worker, hold_n, 1.2)
    return found


def let_go(worker: Worker) -> Steps:
    """Open the pads. Returns whether nothing is felt any more."""
    worker.hold_n = None
    yield from worker.open()
    yield from worker.wait(0.1)
    return not holds(worker)

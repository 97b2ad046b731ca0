# SPDX-License-Identifier: Apache-2.0
"""A scripted person: two hands push cells so that the gripper goes where it should, or tap and press its button."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robotskin.apps.teach.pushing import Grip, best_grip, shares_of
from robotskin.session import PERIOD_S, Session
from robotskin.teaching.execution import UP_M
from robotskin.teaching.leading import PRESS_S, Leader

Array = NDArray[np.float64]

NEAR_M, BETWEEN_M, ON_THE_WAY_M = 0.001, 0.012, 0.02
STRAIGHT = np.array([3.0, 3.0, 1.0])
"""Beside the way is mended sooner than along it, so that the pads come down straight."""
FINE_N_M, LEAST_N, LARGEST_N = 330.0, 1.1, 15.0
DELAY_S = 0.09
"""From the end of a push until the robot stands."""
OFF, WHILE_PERIODS = 0.35, 50
"""A grip is kept while what it cannot push is a smaller part of what is wanted; looked at so often."""
BARRED_LOOKS = 10
"""After so many looks without a touch the teacher sees that a cell cannot be reached: something is before it."""
PATIENCE_S = 15.0
TAP_N, TAP_S, BETWEEN_S = 4.0, 0.10, 0.22


@dataclass(frozen=True)
class Style:
    """How a person teaches. force_n: of a push on the way; pause_s: between acts; detour_m: beside the straight way."""

    name: str
    force_n: float
    pause_s: tuple[float, float]
    detour_m: float = 0.0


STYLES = (Style("slow", 7.0, (0.8, 2.0)), Style("hasty", 14.0, (0.3, 0.6)), Style("detours", 10.0, (0.5, 1.2), 0.05))


class Teacher:
    """Pushes the arm of a leader. Each act goes on by a period of the session a step; `step` is the leader's."""

    def __init__(self, leader: Leader, style: Style, generator: np.random.Generator) -> None:
        self.leader, self.style, self.generator = leader, style, generator
        self.session: Session = leader.worker.session
        self.errors_m: list[float] = []
        """How far the gripper truly was from where it was meant to be, each time that it was left at a place."""
        self._barred: set[int] = set()
        self.toggled_s: float | None = None
        """When the second tap of a pair, or a press that lasts, began to count."""

    def sees_m(self) -> Array:
        """(3) metres, base frame: the middle of the pads as it truly is, which the robot knows a little less well."""
        poses = self.session.world.base_from_cell()
        pads = [self.session.world_cells[pad] for pad in self.leader.worker.gripper.cells]
        return np.asarray(np.mean([poses[pad][:, :3, 3].mean(axis=0) for pad in pads], axis=0))

    def lower(self, place_m: Array) -> Iterator[None]:
        """Lead to above a place, then straight down to it."""
        yield from self.lead(place_m + UP_M, BETWEEN_M)
        yield from self.lead(place_m)
        self.errors_m.append(float(np.linalg.norm(place_m - self.sees_m())))

    def lead(self, place_m: Array, enough: float = NEAR_M) -> Iterator[None]:
        """Push until the pads' middle is so near to a place."""
        begun = self._now
        hands = self.session.world.hands[:2]
        grip: Grip | None = None
        self._barred, missed = set(), np.zeros(2)
        while self._now - begun < PATIENCE_S:
            error = place_m - self.sees_m()
            left = float(np.linalg.norm(error))
            coasts = DELAY_S * float(np.linalg.norm(self.leader.speed_m_s))
            if left < max(enough, coasts):
                for hand in hands:
                    hand.push(hand.cell, 0.0)
                yield from self.pause(0.3)
                if float(np.linalg.norm(place_m - self.sees_m())) < 1.5 * enough:
                    break
                continue
            wanted = STRAIGHT * error
            wanted *= min(LEAST_N + FINE_N_M * left, self.style.force_n) / float(np.linalg.norm(wanted))
            grip = self._grip(wanted, grip)
            for hand, cell, force in zip(hands, grip.cells, grip.forces_n, strict=True):
                hand.push(self.session.in_world(cell), min(force, LARGEST_N))
            yield from self.pause(WHILE_PERIODS * PERIOD_S)
            for number, (hand, cell, force) in enumerate(zip(hands, grip.cells, grip.forces_n, strict=True)):
                missed[number] = missed[number] + 1 if force > LEAST_N and hand.force_n == 0 else 0
                if missed[number] > BARRED_LOOKS:
                    self._barred.add(cell)
                    grip = None
                    missed[:] = 0
                    break
        for hand in hands:
            hand.leave()
        yield from self.pause(0.25)

    def _grip(self, wanted_n: Array, present: Grip | None) -> Grip:
        """The present cells with new forces where they serve, else the best ones."""
        cells = np.setdiff1d(self.leader.leading, list(self._barred))
        poses = self.session.world.base_from_cell()[self.session.world_cells[cells]]
        inward = -poses[:, :3, 2]
        if present is not None:
            rows = [int(np.flatnonzero(cells == cell)[0]) for cell in present.cells]
            forces, off = shares_of(inward[rows], wanted_n)
            if off < OFF:
                return Grip(present.cells, forces)
        return best_grip(cells, inward, poses[:, :3, 3], wanted_n, () if present is None else present.cells)

    def double_tap(self) -> Iterator[None]:
        """Tap the button twice: the gripper opens or closes."""
        cell = self.session.in_world(int(self.leader.worker.gripper.button[0]))
        hand = self.session.world.hands[1]
        hand.approach(cell, 0.01)
        yield from self.pause(1.0)
        for tap in range(2):
            hand.push(cell, TAP_N)
            yield from self._felt(True)
            if tap == 1:
                self.toggled_s = self._now
            yield from self.pause(TAP_S)
            hand.approach(cell, 0.008)
            yield from self._felt(False)
            yield from self.pause(BETWEEN_S - TAP_S)
        hand.leave()

    def press(self) -> Iterator[None]:
        """Press the button until the gripper squeezes."""
        cell = self.session.in_world(int(self.leader.worker.gripper.button[0]))
        hand = self.session.world.hands[1]
        hand.approach(cell, 0.01)
        yield from self.pause(1.0)
        hand.push(cell, TAP_N)
        yield from self._felt(True)
        yield from self.pause(PRESS_S)
        self.toggled_s = self._now
        yield from self.pause(0.15)
        hand.leave()

    def until_done(self) -> Iterator[None]:
        """Wait until the gripper has done what it was asked."""
        yield from self.pause(0.1)
        while self.leader.worker.busy:
            yield

    def pause(self, seconds: float) -> Iterator[None]:
        """Do nothing for a time."""
        for _ in range(round(seconds / PERIOD_S)):
            yield

    def rest(self) -> Iterator[None]:
        """Pause as long as the style has it."""
        yield from self.pause(float(self.generator.uniform(*self.style.pause_s)))

    def beside(self, place_m: Array) -> Array:
        """(3) metres, a point of a detour on the way to a place."""
        aside = self.generator.normal(size=2)
        aside *= self.style.detour_m / np.linalg.norm(aside)
        return 0.5 * (place_m + self.sees_m()) + [*aside, 0.02]

    @property
    def _now(self) -> float:
        return self.session.world.time_s

    def _felt(self, wanted: bool, patience_s: float = 0.5) -> Iterator[None]:
        begun, hand = self._now, self.session.world.hands[1]
        while (hand.force_n > 0.5 * TAP_N if not wanted else hand.force_n < 0.5 * TAP_N) and (
            self._now - begun < patience_s
        ):
            yield

# SPDX-License-Identifier: Apache-2.0
"""Touches of the skin at random while an application works, and the largest contact that comes of them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robotskin.session import SafetyState, Session

LEAST_N, PUSHES_S, RESTS_S = 1.0, (0.2, 1.5), (0.5, 4.0)
LOOK_PERIODS = 4
WAY_M, CLEAR_M = 0.08, 0.010
"""The hand comes straight from so far; so much wider than the hand its way must be free of other links' cells."""
TRIES = 30


class RandomTouches:
    """Touches one of `cells` after the other by the last hand of the world; call `step` after each of the session's."""

    def __init__(self, session: Session, cells: Sequence[int], most_n: float, seed: int) -> None:
        self.session, self.cells, self.most_n = session, list(cells), most_n
        self.generator = np.random.default_rng([seed, 67])
        self.hand = session.world.hands[-1]
        self.count = 0
        self.peak_n = 0.0
        """The largest force of one hand, or of one thing, on all cells together."""
        self.running = True
        self._until_s, self._periods = session.world.time_s + 1.0, 0
        self._pushes = False

    def step(self) -> None:
        """One period."""
        session = self.session
        self._periods += 1
        self.running = self.running and session.state in (SafetyState.running, SafetyState.degraded)
        if self._periods % LOOK_PERIODS:
            return
        self.peak_n = max(self.peak_n, float(session.world.contact_normal_force().max(initial=0.0)))
        if session.world.time_s < self._until_s:
            return
        self._pushes = not self._pushes
        cell = self._reachable() if self._pushes else None
        self._pushes = cell is not None
        if cell is not None:
            self.hand.push(session.in_world(cell), float(self.generator.uniform(LEAST_N, self.most_n)))
            self.count += 1
        else:
            self.hand.leave()
        self._until_s = session.world.time_s + float(self.generator.uniform(*(PUSHES_S if self._pushes else RESTS_S)))

    def _reachable(self) -> int | None:
        """A cell, drawn among those to which the way is free now; None where such a cell is not found.

        Between two fingers is no room for a person's: there the hand would be squeezed, whatever the robot does.
        """
        layout, world = self.session.layout, self.session.world
        base_from_cell = world.base_from_cell()[[self.session.in_world(cell) for cell in range(len(layout))]]
        for cell in self.generator.permutation(self.cells)[:TRIES]:
            others = np.flatnonzero(layout.link != layout.link[cell])
            away = base_from_cell[others, :3, 3] - base_from_cell[cell, :3, 3]
            normal = base_from_cell[cell, :3, 2]
            radius = self.hand.radius_m
            along = np.clip(away @ normal, radius, radius + WAY_M)
            if np.linalg.norm(away - along[:, None] * normal, axis=1).min(initial=np.inf) > radius + CLEAR_M:
                return int(cell)
        return None

    def end(self) -> None:
        """The hand leaves."""
        self.hand.leave()
        self._pushes, self._until_s = False, np.inf

    def figures(self, label: str) -> dict[str, float]:
        """What must hold of a soak."""
        return {
            f"{label}_soak_touches": float(self.count),
            f"{label}_soak_peak_contact_n": self.peak_n,
            f"{label}_soak_violations": float(self.session.controller.report.violations),
            f"{label}_soak_stops": float(not self.running),
        }

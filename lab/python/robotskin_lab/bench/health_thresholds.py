# SPDX-License-Identifier: Apache-2.0
"""What a maintainer would write in an afternoon: a threshold a channel, over the last ten seconds."""

from __future__ import annotations

import numpy as np

from robotskin.health import Finding, Kind
from robotskin.health.healthy import STEP
from robotskin.skin import STANDARD_GRAVITY_MPS2, Health, SkinState

WINDOW_S = 10.0


class Thresholds:
    """Names cells by the mean and the spread of each channel alone."""

    def __init__(self, cells: int) -> None:
        self.named: dict[int, tuple[Finding, float]] = {}
        self._rows: list[np.ndarray] = []
        self._cells, self._begun = cells, 0.0

    def tick(self, state: SkinState, time_s: float) -> None:
        """After a read."""
        if (silent := np.flatnonzero(np.asarray(state.health) != int(Health.alive))).size:
            for cell in silent:
                self._name(int(cell), Kind.dead, time_s)
        row = np.concatenate(
            [np.asarray(state.proximity)[:, None], state.normal_force, state.acceleration, state.temperature], axis=1
        )
        self._rows.append(row.copy())
        if time_s - self._begun < WINDOW_S:
            return
        self._judge(np.stack(self._rows), time_s)
        self._rows, self._begun = [], time_s

    def _judge(self, rows: np.ndarray, time_s: float) -> None:
        mean, spread = rows.mean(axis=0), np.diff(rows, axis=0).std(axis=0) / np.sqrt(2)
        size = np.linalg.norm(mean[:, 4:7], axis=1) / STANDARD_GRAVITY_MPS2
        rules = (
            (Kind.stuck, (rows.max(axis=0) == rows.min(axis=0))[:, [4, 5, 6, 8]].any(axis=1)),
            (Kind.end_of_range, (mean[:, 1:4] > 9.9).any(axis=1) | (np.abs(mean[:, 4:7]) > 19.0).any(axis=1)),
            (Kind.overheated, mean[:, 7] > 50.0),
            (Kind.noisy, (spread > 4 * STEP * [1.2, 0.5, 0.5, 0.5, 2.6, 2.6, 2.6, 1, 1.6]).any(axis=1)),
            (Kind.offset, (mean[:, 1:4] > 0.8).any(axis=1)),
            (Kind.mis_scaled, np.abs(size - 1) > 0.15),
        )
        for kind, cells in rules:
            for cell in np.flatnonzero(cells):
                self._name(int(cell), kind, time_s)

    def _name(self, cell: int, kind: Kind, time_s: float) -> None:
        self.named.setdefault(cell, (Finding(cell, kind), time_s))

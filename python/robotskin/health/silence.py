# SPDX-License-Identifier: Apache-2.0
"""Silent cells: those that are dead, and those that no living cell or cable leads to any more."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from robotskin.health.kinds import Finding, Kind

if TYPE_CHECKING:
    from robotskin.layout import Layout

OWN_S = 2.5
"""A cell that was silent for so long while a cell beside it was heard is dead, whatever becomes of the others."""


class Silence:
    """How long each of N cells has been silent, and whether it had a way out meanwhile.

    A silent cell beside one that is heard, or with a cable of its own, is dead, or its connectors are. One that is
    wired to silent cells only may well be alive: nothing that it sends gets out.

    Args:
        cells: N. layout: whose wires and cables are looked at; None, or one without cables: every cell has its own way.
    """

    def __init__(self, cells: int, layout: Layout | None = None) -> None:
        self._wired, self._cabled = np.full((cells, 1), cells), np.ones(cells, bool)
        if layout is not None and layout.section_unit_ports:
            wired = layout.neighbours[:, :, 0]
            self._wired = np.where(wired < 0, cells, wired)
            self._cabled = np.isin(np.arange(cells), [place.cell for place in layout.section_unit_ports])
        self._way_out = np.ones(cells, bool)
        self.seconds = np.zeros(cells)
        """(N) for which each cell has been silent."""
        self.own_seconds = np.zeros(cells)
        """(N) of them, those in which it had a way out."""

    def add(self, window: Mapping[str, Any], seconds: float) -> None:
        """Take in one window of `CellWindows.take` that lasted so long."""
        quiet = window["silent"] > 0.9 * max(window["ticks"], 1)
        heard = np.append((window["samples"] > 0) & ~quiet, False)
        self._way_out = self._cabled | heard[self._wired].any(axis=1)
        self.seconds = np.where(quiet, self.seconds + seconds, 0.0)
        self.own_seconds = np.where(quiet, self.own_seconds + seconds * self._way_out, 0.0)

    def judged(self, after_s: float) -> Iterator[Finding]:
        """The cells that have been silent for so long."""
        silent = self.seconds >= after_s
        dead = silent & (self._way_out | (self.own_seconds >= OWN_S))
        for cell in np.flatnonzero(silent):
            if dead[cell]:
                yield Finding(int(cell), Kind.dead)
            else:
                yield Finding(int(cell), Kind.cut_off, partner=self._nearest(int(cell), dead))

    def _nearest(self, cell: int, dead: np.ndarray) -> int | None:
        """The dead cell that is the fewest wires away."""
        seen, next_ones = {cell, len(dead)}, deque([cell])
        while next_ones:
            for other in self._wired[next_ones.popleft()]:
                if int(other) in seen:
                    continue
                if dead[other]:
                    return int(other)
                seen.add(int(other))
                next_ones.append(int(other))
        return None

# SPDX-License-Identifier: Apache-2.0
"""Cells that fall silent while an application goes by what they feel."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Cells = NDArray[np.bool_]


class LostCells:
    """Which of N cells are silent, and which of these felt something when last heard of."""

    def __init__(self, count: int) -> None:
        self.lost: Cells = np.zeros(count, dtype=bool)
        """(N,) cells that are silent."""
        self.bearing: Cells = np.zeros(count, dtype=bool)
        """(N,) cells that feel something, or did when they were last heard of."""

    def look(self, silent: Cells, touched: Cells) -> None:
        """Take which of the (N,) cells are silent now, and which feel something."""
        self.lost = silent
        self.bearing = np.where(silent, self.bearing, touched)

    def forget(self) -> None:
        """What lost cells felt counts no more: the hand or the arms are open, and begin again."""
        self.bearing = self.bearing & ~self.lost

    def among(self, cells: NDArray[np.int64], most_share: float = 1.0) -> bool:
        """Whether one of these cells (K) that felt something is lost, or more than this share of them all."""
        lost = self.lost[cells]
        return bool((lost & self.bearing[cells]).any()) or bool(lost.mean() > most_share)

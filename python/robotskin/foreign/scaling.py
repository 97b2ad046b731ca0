# SPDX-License-Identifier: Apache-2.0
"""From the counts of a frame to samples of cells in SI units."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robotskin.foreign.declared import SENSORS, Declared, Source
from robotskin.foreign.errors import ForeignSkinError
from robotskin.foreign.frames import Counts
from robotskin.layout import Layout


class Scaling:
    """The cells of one source: which slots are theirs, and what their counts mean.

    Raises ForeignSkinError where the layout has no cell of this source.
    """

    def __init__(self, source: Source, declared: Declared, layout: Layout) -> None:
        ids = np.asarray(layout.id, dtype=np.int64)
        slot = ids - source.first_id
        mine = (np.asarray(layout.group) == source.group) & (slot >= 0) & (slot < source.slots)
        if not mine.any():
            last = source.first_id + source.slots - 1
            raise ForeignSkinError(
                f"{declared.name}: {source.at}: cells {source.first_id} to {last} of group {source.group}: the layout "
                f"of {len(layout)} cells has none of them; it has groups {sorted(set(map(int, layout.group)))}"
            )
        self.cells = np.flatnonzero(mine).astype(np.int32)
        """(M) of the layout."""
        self._slots = slot[mine]
        ordered = sorted(enumerate(declared.channels), key=lambda one: list(SENSORS).index(one[1].sensor))
        starts = np.cumsum([0, *(channel.values for channel in declared.channels)])
        columns: list[int] = []
        for index, channel in ordered:
            for place in range(SENSORS[channel.sensor]):
                columns.append(int(starts[index]) + min(place, channel.values - 1))
        self._columns = columns
        self._taken = np.empty((len(self._slots), int(starts[-1])))
        """Of a sample, which column of a frame each is; the others are of the frame's columns."""
        told = [channel for channel in declared.channels for _ in range(channel.values)]
        one_force = [channel.sensor == "force" and channel.values == 1 for channel in told]
        self._zero = np.array([channel.zero for channel in told])
        self._scale = np.array(
            [channel.scale / (3.0 if one else 1.0) for channel, one in zip(told, one_force, strict=True)]
        )
        self._lowest = np.array([channel.lowest for channel in told])
        self._highest = np.array([channel.highest for channel in told])
        # Below nothing is noise; forces keep theirs until their zero is taken.
        self._floor = np.array([0.0 if channel.sensor == "proximity" else -np.inf for channel in told])
        self._has_floor = bool(np.isfinite(self._floor).any())

    def samples(self, counts: Counts) -> tuple[NDArray[np.int32], NDArray[np.float32], NDArray[np.bool_]]:
        """Cells (M), values (M, V) in SI units, saturated (M). A cell without any value is left out; a count beyond its
        range is no number, and its cell is then not believed."""
        taken = counts.take(self._slots, axis=0, out=self._taken, mode="clip")  # slots are within
        cells = self.cells
        least, most = taken.min(axis=0), taken.max(axis=0)
        if not (np.isfinite(least).all() and np.isfinite(most).all()):
            there = _any_of_row(np.isfinite(taken))
            taken, cells = taken[there], cells[there]
        # Frames in which no count is at the end of its range are the rule: the looks at each cell are left out.
        beyond = not (least >= self._lowest).all() or not (most <= self._highest).all()
        inside = bool((least > self._lowest).all() and (most < self._highest).all())
        saturated = np.zeros(len(cells), dtype=bool) if inside else self._saturated(taken)
        outside = (taken < self._lowest) | (taken > self._highest) if beyond else None
        taken -= self._zero
        taken *= self._scale
        if self._has_floor:
            np.maximum(taken, self._floor, out=taken)
        if outside is not None:
            taken[outside] = np.nan
        spread = np.empty((len(cells), len(self._columns)), dtype=np.float32)
        for place, column in enumerate(self._columns):
            spread[:, place] = taken[:, column]
        return cells, spread, saturated

    def _saturated(self, taken: Counts) -> NDArray[np.bool_]:
        at_end = ((taken == self._lowest) & (self._scale < 0)) | ((taken == self._highest) & (self._scale > 0))
        return _any_of_row(at_end)


def _any_of_row(flags: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """As `flags.any(axis=1)`, which is slow on rows of few."""
    found = flags[:, 0].copy()
    for column in range(1, flags.shape[1]):
        found |= flags[:, column]
    return found

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
        self._columns = np.array(columns)
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

    def samples(self, counts: Counts) -> tuple[NDArray[np.int32], NDArray[np.float32], NDArray[np.bool_]]:
        """Cells (M), values (M, V) in SI units, saturated (M). A cell without any value is left out; a count beyond its
        range is no number, and its cell is then not believed."""
        taken = counts[self._slots]
        there = _any_of_row(np.isfinite(taken))
        cells = self.cells
        if not there.all():
            taken, cells = taken[there], cells[there]
        values = (taken - self._zero) * self._scale
        np.maximum(values, self._floor, out=values)
        values[(taken < self._lowest) | (taken > self._highest)] = np.nan
        saturated = ((taken == self._lowest) & (self._scale < 0)) | ((taken == self._highest) & (self._scale > 0))
        spread = np.ascontiguousarray(values.astype(np.float32).take(self._columns, axis=1))
        return cells, spread, _any_of_row(saturated)


def _any_of_row(flags: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """As `flags.any(axis=1)`, which is slow on rows of few."""
    found = flags[:, 0].copy()
    for column in range(1, flags.shape[1]):
        found |= flags[:, column]
    return found

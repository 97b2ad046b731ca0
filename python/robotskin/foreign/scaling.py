# SPDX-License-Identifier: Apache-2.0
"""From the counts of a frame to samples of cells in SI units."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robotskin.foreign.declared import SENSORS, Channel, Declared, Source
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
        parts: list[tuple[Channel, float]] = []
        for index, channel in ordered:
            for place in range(SENSORS[channel.sensor]):
                columns.append(int(starts[index]) + min(place, channel.values - 1))
                share = 3.0 if channel.sensor == "force" and channel.values == 1 else 1.0
                parts.append((channel, share))
        self._columns = np.array(columns)
        self._zero = np.array([channel.zero for channel, _ in parts])
        self._scale = np.array([channel.scale / share for channel, share in parts])
        self._lowest = np.array([channel.lowest for channel, _ in parts])
        self._highest = np.array([channel.highest for channel, _ in parts])
        # Below nothing is noise; forces keep theirs until their zero is taken.
        self._floor = np.array([0.0 if channel.sensor == "proximity" else -np.inf for channel, _ in parts])

    def samples(self, counts: Counts) -> tuple[NDArray[np.int32], NDArray[np.float32], NDArray[np.bool_]]:
        """Cells (M), values (M, V) in SI units, saturated (M). A cell without any value is left out; a count beyond its
        range is no number, and its cell is then not believed."""
        taken = counts[self._slots][:, self._columns]
        there = np.isfinite(taken).any(axis=1)
        taken = taken[there]
        values = np.maximum((taken - self._zero) * self._scale, self._floor)
        values[(taken < self._lowest) | (taken > self._highest)] = np.nan
        saturated = ((taken == self._lowest) & (self._scale < 0)) | ((taken == self._highest) & (self._scale > 0))
        return self.cells[there], np.ascontiguousarray(values, np.float32), saturated.any(axis=1)

# SPDX-License-Identifier: Apache-2.0
"""A recording at a fixed rate: the last value of every cell and joint at each frame, and between two frames."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robotskin.layout import Layout
from robotskin.record import Recording
from robotskin.record.recording import WIDTHS

Floats = NDArray[np.float32]
EVENT = 1
"""The bit of `flags` of a sample that a cell sent because something had changed."""


@dataclass
class Frames:
    """F frames of N cells and n joints; `window` has k instants up to each frame, the frame itself last."""

    force: Floats
    """(F, N) newton, the sum of a cell's three sensors."""
    window: Floats
    """(F, k, N) newton."""
    proximity: Floats
    """(F, N) share of full scale."""
    acceleration: Floats
    """(F, N, 3) m/s², cell frame."""
    contact: Floats
    """(F, L) newton, the sum over the cells of each link."""
    position: Floats
    """(F, n) rad or m."""
    action: Floats
    """(F, n) what the robot was commanded, in the unit of its interface."""


def blocks(
    recording: Recording, fps: int, instants: int, block: int, hear: Callable[[Mapping[str, NDArray], NDArray], None]
) -> Iterator[Frames]:
    """The frames, at most `block` at a time; the first one is 1 / fps after the recording's begin.

    hear: hears all samples on the way, as `Recording.messages` gives them, in the order of the file, and the cell of
    each as an index of the layout, -1 where it has none.
    """
    count = int(recording.seconds * fps)
    cells, links = len(recording.layout), len(recording.layout.links)
    ticks = recording.start_ns + np.arange(1, count * instants + 1) * (1e9 / (fps * instants))
    position = _held(recording, "/robot/joints", "stamp_ns", "position", ticks[instants - 1 :: instants])
    action = _held(recording, "/robot/commands", "time_ns", "value", ticks[instants - 1 :: instants])
    on_link = np.zeros((cells, links), np.float32)
    on_link[np.arange(cells), np.asarray(recording.layout.link)] = 1.0
    held = _Held(recording, hear)
    for first in range(0, count, block):
        frames = range(first, min(first + block, count))
        size = len(frames)
        out = Frames(
            force=np.empty((size, cells), np.float32),
            window=np.empty((size, instants, cells), np.float32),
            proximity=np.empty((size, cells), np.float32),
            acceleration=np.empty((size, cells, 3), np.float32),
            contact=np.empty((size, links), np.float32),
            position=position[first : first + size],
            action=action[first : first + size],
        )
        for row, frame in enumerate(frames):
            for instant in range(instants):
                held.advance(ticks[frame * instants + instant])
                out.window[row, instant] = held.force
            out.force[row], out.proximity[row], out.acceleration[row] = held.force, held.proximity, held.acceleration
        out.contact[:] = out.force @ on_link
        yield out
    held.end()


class _Held:
    """The last value of every cell, as time goes on."""

    def __init__(self, recording: Recording, hear: Callable[[Mapping[str, NDArray], NDArray], None]) -> None:
        cells = len(recording.layout)
        self._cell_of_key = _cell_of_key(recording.layout)
        self._messages = recording.messages("/skin/samples")
        self._stamp, self._cell, self._values = np.empty(0, np.int64), np.empty(0, int), np.empty((0, 5), np.float32)
        self._hear = hear
        self._at, self._known_ns = 0, -1
        self._state = np.zeros((cells, 5), np.float32)

    @property
    def force(self) -> Floats:
        """(N)."""
        return self._state[:, 0]

    @property
    def proximity(self) -> Floats:
        """(N)."""
        return self._state[:, 1]

    @property
    def acceleration(self) -> Floats:
        """(N, 3)."""
        return self._state[:, 2:5]

    def advance(self, time_ns: float) -> None:
        """Take in every sample up to a time."""
        if self._known_ns < time_ns + LATE_NS:
            self._read(time_ns + LATE_NS + AHEAD_NS)
        # A whole number: for another one numpy would make all stamps such.
        end = self._at + int(np.searchsorted(self._stamp[self._at :], np.int64(time_ns), side="right"))
        # Of several samples of a cell the last one stays.
        self._state[self._cell[self._at : end]] = self._values[self._at : end]
        self._at = end

    def end(self) -> None:
        """Read what is behind the last frame."""
        self._read(math.inf)

    def _read(self, until_ns: float) -> None:
        """Many messages at once: each sorting and joining costs as much for a few samples as for many."""
        taken: list[dict[str, NDArray]] = []
        newest_ns = float(self._known_ns)
        while newest_ns < until_ns and (found := next(self._messages, None)) is not None:
            taken.append(found[1])
            newest_ns = max(newest_ns, float(found[1]["stamp_ns"].max(initial=-1)))
        if not taken:
            return
        fields = {name: np.concatenate([one[name] for one in taken]) for name in taken[0]}
        cell = self._cell_of_key.take(fields["key"], mode="clip")
        self._hear(fields, cell)
        values = np.empty((len(cell), 5), np.float32)
        # What the skin lacks is no number; those who write it leave it out.
        force, near, felt = fields["normal_force"], fields["proximity"], fields["acceleration"]
        values[:, 0] = sum(force.reshape(len(cell), -1).T) if len(force) else np.nan
        values[:, 1] = near if len(near) else np.nan
        values[:, 2:] = felt.reshape(-1, WIDTHS["acceleration"]) if len(felt) else np.nan
        own = cell >= 0
        stamp = np.concatenate([self._stamp[self._at :], fields["stamp_ns"][own]])
        cell = np.concatenate([self._cell[self._at :], cell[own]])
        values = np.concatenate([self._values[self._at :], values[own]])
        if (stamp[1:] < stamp[:-1]).any():
            order = np.argsort(stamp, kind="stable")
            stamp, cell, values = stamp[order], cell[order], values[order]
        self._stamp, self._cell, self._values = stamp, cell, values
        self._at = 0
        self._known_ns = int(newest_ns)


def _cell_of_key(layout: Layout) -> NDArray[np.int64]:
    """The cell of every key up to the greatest, -1 where there is none; a search for each sample takes far longer."""
    return layout.cells_of(np.arange(layout.keys.max() + 2))


LATE_NS = 300_000_000
"""How much later than another's a sample may stand in the file."""
AHEAD_NS = 1_000_000_000


def _held(recording: Recording, topic: str, time: str, field: str, ticks: NDArray) -> Floats:
    """(F, n) the last value at each tick; before the first, that one."""
    times, values = [], []
    for _, fields in recording.messages(topic):
        times.append(fields[time])
        values.append(fields[field].reshape(len(fields[time]), -1))
    if not times:
        return np.zeros((len(ticks), 0), np.float32)
    every, all_values = np.concatenate(times), np.concatenate(values)
    row = np.clip(np.searchsorted(every, ticks, side="right") - 1, 0, len(every) - 1)
    return np.asarray(all_values[row], np.float32)

# SPDX-License-Identifier: Apache-2.0
"""The last minute of windows, and what a skin's model says about its cells."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from robotskin.health.healthy import FORCES, PROXIMITY, Healthy
from robotskin.health.silence import Silence
from robotskin.skin import SkinModel

if TYPE_CHECKING:
    from robotskin.layout import Layout

WINDOWS = 64
WINDOW_S = 1.0
BESIDE = 12

Windows = NDArray[np.float32]


class Evidence:
    """Rings of the last windows of N cells; the newest is last in every array that is handed out."""

    def __init__(self, skin: SkinModel, healthy: Healthy, layout: Layout | None = None) -> None:
        cells = len(skin)
        self.healthy = healthy
        self.link = np.asarray(skin.link)
        self.links = len(skin.link_names)
        self.link_from_cell = np.asarray(skin.link_from_cell)[:, :3, :3]
        self.neighbours = np.asarray(_neighbours(skin, cells))
        self.count = 0
        """Windows so far."""
        self.now: dict[str, Any] = {}
        """The newest window, as `CellWindows.take` tells it."""
        self._time = np.zeros(WINDOWS)
        self._mean = np.zeros((WINDOWS, cells, 9), np.float32)
        self._noise = np.zeros((WINDOWS, cells, 9), np.float32)
        self._most = np.zeros((WINDOWS, cells, 9), np.float32)
        self._least = np.zeros((WINDOWS, cells, 9), np.float32)
        self._expected = np.full((WINDOWS, cells, 3), np.nan, np.float32)
        self._samples = np.zeros((WINDOWS, cells), np.int32)
        self._near = np.zeros((WINDOWS, cells), bool)
        self.silence = Silence(cells, layout)
        self.stuck_s = np.zeros(cells)
        """(N) seconds for which its reader has called it stuck."""
        self.pressed = np.zeros(cells, bool)
        """(N) cells that feel more than pre-loads and zeros can be, or a force that comes or goes."""
        self.leant_on = np.zeros(cells, bool)
        """(N) cells that came to feel something, however little, as their proximity came to its end, and still do."""
        self.came_near = np.zeros(cells, bool)
        """(N,) cells whose proximity came to its end from near there, not long ago, as of a thing that comes slowly."""
        self._before_n, self._before_near = np.full(cells, np.inf), np.zeros(cells)
        self._near_s, self._felt_less_s = np.zeros(cells), np.zeros(cells)
        self.blind = np.zeros(cells, bool)
        """(N) cells that were touched and saw nothing of it, and whose proximity has not moved since."""
        self.sightless = np.zeros(cells, bool)
        """(N) cells whose proximity is named ill: it tells nothing of what touches the cells beside them."""
        self.at_end_s = np.zeros((cells, 9))
        """(N, 9) seconds for which a channel has been at the end of its range."""
        self.crept_n = np.zeros((cells, 3))
        """(N, 3) newton: the load of each force sensor behind a first-order lag, from which its creep follows."""

    @property
    def cells(self) -> int:
        """N."""
        return len(self.link)

    def add(self, window: Mapping[str, Any]) -> None:
        """Take in one window."""
        self.now = dict(window)
        row = self.count % WINDOWS
        seconds = max(1e-9 * (window["ended_ns"] - window["begun_ns"]), 1e-3)
        ticks = max(window["ticks"], 1)
        alive = window["samples"] > 0
        self._time[row] = 1e-9 * window["ended_ns"]
        for ring, name in (
            (self._mean, "mean"),
            (self._noise, "noise"),
            (self._most, "most"),
            (self._least, "least"),
        ):
            ring[row] = window[name]
        self._expected[row] = window["expected"]
        self._samples[row] = window["samples"]
        self._near[row] = ~(window["most"][:, PROXIMITY] <= self.healthy.free_share)
        self._look_at_presses(window)
        self._look_at_light_touches(window, seconds)
        self.count += 1
        self.silence.add(window, seconds)
        self.stuck_s = np.where(window["stuck"] > 0.9 * ticks, self.stuck_s + seconds, 0.0)
        ends = window["at_end"] > 0.9
        self.at_end_s = np.where(ends & alive[:, None], self.at_end_s + seconds, 0.0)
        share = 1 - np.exp(-seconds / self.healthy.creep_time_s) if self.count > 1 else 1.0
        force = np.where(alive[:, None], window["mean"][:, FORCES], self.crept_n)
        self.crept_n = self.crept_n + share * (force - self.crept_n)

    def last(self, windows: int) -> dict[str, NDArray]:
        """The last windows, oldest first: time (K) s; mean, noise, most, least (K, N, 9); expected (K, N, 3) m/s²;
        samples, touched (K, N)."""
        rows = np.arange(max(self.count - windows, self.count - WINDOWS, 0), self.count) % WINDOWS
        return {
            "time": self._time[rows],
            "mean": self._mean[rows],
            "noise": self._noise[rows],
            "most": self._most[rows],
            "least": self._least[rows],
            "expected": self._expected[rows],
            "samples": self._samples[rows],
            "touched": self._touched(rows),
        }

    def _touched(self, rows: NDArray[np.int_]) -> NDArray[np.bool_]:
        """(K, N) whether something may touch a cell: it, or a cell beside it, sees something very near, or the skin has
        no proximity to tell."""
        near = self._near[rows]
        told = np.pad(near & ~self.sightless, ((0, 0), (0, 1)))
        return near | told[:, self.neighbours].any(axis=2)

    def _look_at_presses(self, window: Mapping[str, Any]) -> None:
        """A touch lasts a second or two, too short to be judged often: which cells it found blind is kept."""
        healthy = self.healthy
        swings = (window["most"] - window["least"])[:, FORCES]
        swing = swings.sum(axis=1)
        force = window["mean"][:, FORCES].sum(axis=1)
        self.pressed = (force > 3 * healthy.rest_force_n) | (swing > healthy.touched_n)
        # A wrong zero presses for ever: a cell is blind to what came or went. The soft layer carries a little of a hard
        # press to cells that nothing is in front of.
        load = np.maximum(force, swing)
        carried = healthy.carried_share * np.append(load, 0.0)[self.neighbours].max(axis=1, initial=0.0)
        # It may have moved in the touch, and rest since: all of the window counts.
        unmoved = window["unchanged"][:, PROXIMITY] >= healthy.stuck_samples
        unmoved &= window["most"][:, PROXIMITY] == window["least"][:, PROXIMITY]
        beside = np.append(window["most"][:, PROXIMITY], 0.0)[self.neighbours].max(axis=1, initial=0.0)
        # Cells beside it see what presses, or several of its own force sensors feel it: one alone may be ill.
        several = (swings > healthy.touched_n / 2).sum(axis=1) >= 2
        touched = (beside > healthy.free_share) | several
        seen = (swing > healthy.touched_n) & (load > carried) & touched
        self.blind = (self.blind | seen) & unmoved

    def _look_at_light_touches(self, window: Mapping[str, Any], seconds: float) -> None:
        """Something that is held rests on a cell for long and presses little: less than a wrong zero may be.

        It is seen and felt at about the same time. A force that comes later, or goes while the cell sees something
        still, is a touch of a proximity sensor that is ill, or a zero that drifts.
        """
        healthy = self.healthy
        force = window["mean"][:, FORCES].sum(axis=1)
        ended = window["at_end"][:, PROXIMITY] > 0
        rise = force - self._before_n
        self.came_near = ended & (self.came_near | ((self._near_s == 0.0) & (self._before_near > healthy.comes_share)))
        self._before_near = np.where(ended, 0.0, window["most"][:, PROXIMITY])
        self._near_s = np.where(ended, self._near_s + seconds, 0.0)
        self.came_near &= self._near_s <= healthy.stays_s
        self._felt_less_s = np.where(rise > healthy.leant_n / 2, 0.0, self._felt_less_s + seconds)
        comes = (rise > healthy.leant_n) & (self._near_s <= healthy.end_s)
        self.leant_on = ended & (self.leant_on | comes) & (self._felt_less_s <= healthy.leaves_s)
        self._before_n = np.where(ended, self._before_n, force)


def _neighbours(skin: SkinModel, cells: int) -> list[list[int]]:
    """(N, 12) indices of the nearest cells of the same link, within some two of the usual distance; N: none."""
    place = np.asarray(skin.link_from_cell)[:, :3, 3]
    link = np.asarray(skin.link)
    found = np.full((cells, BESIDE), cells)
    nearest = np.full(cells, np.inf)
    ordered: list[NDArray] = []
    for cell in range(cells):
        same = np.flatnonzero((link == link[cell]) & (np.arange(cells) != cell))
        distance = np.linalg.norm(place[same] - place[cell], axis=1)
        order = np.argsort(distance)[:BESIDE]
        nearest[cell] = distance[order[0]] if len(order) else np.inf
        ordered.append(np.stack([same[order], distance[order]]) if len(order) else np.zeros((2, 0)))
    usual = float(np.median(nearest[np.isfinite(nearest)])) if np.isfinite(nearest).any() else 0.0
    for cell, (same, distance) in enumerate(ordered):
        near = same[distance < 2.2 * usual].astype(int)
        found[cell, : len(near)] = near
    return found.tolist()

# SPDX-License-Identifier: Apache-2.0
"""What both soles of a standing robot bear, also a sole on an edge where none of its cells is.

Such a sole bears what the other one lacks of the robot's weight, and presses where it is lowest. While its cells feel
more, they tell where it presses, and so how the robot as built differs from its model.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robotskin.apps.balance.foot_tilts import FootTilts

Array = NDArray[np.float64]
_UNFELT_S = 0.5
"""A robot both of whose soles feel nothing for longer hangs."""
_FELT = 0.06
"""Of the weight: soles that together feel less feel nothing."""
_LEAST_SHARE = 0.05
"""Of the weight, that a sole is taken to bear where neither feels enough."""
_TILT_RAD = 6e-4
"""σ of a tilt, beside what is not known of its offset: foam follows it, but not quite as told."""
_LEAST_M = 5e-3
"""σ, at least, of where a tilt tells that a sole presses: also on an edge, where the tilt counts for nothing."""
_MISSED = 5.0
"""Cells that miss all of the load would know so much less where it is than those that feel all of it."""
_MOST_TOO_MUCH = 0.9
"""Of what cells tell of a load, what they may have told beyond it: sensors at their end leave a plane open."""
_ALIKE = 5.0
"""Samples in a row are wrong alike: σ of one, times this, for what is learnt from each."""
_CORNERS = np.array([(along, across) for along in (-1.0, 1.0) for across in (-1.0, 1.0)])


@dataclass(frozen=True)
class SoleFoam:
    """What a stiff, flat sole with foam under its corners does on level ground.

    half_m: (x, y) half its length and width; newton_per_m: of all its foam; lag_s: in which the foam follows a tilt.
    """

    half_m: tuple[float, float]
    newton_per_m: float
    lag_s: float

    def centre(self, tilt: Array, load_n: float) -> Array:
        """(2,) m from its middle, where it presses with a load; `tilt` (2,): its rise for a metre along x and y."""
        corners = _CORNERS * self.half_m
        height = corners @ tilt
        # Pressed from above, the lowest corners bear first.
        lowest = np.sort(height)
        count = np.arange(1, len(corners) + 1)
        depth = np.min((len(corners) * load_n / self.newton_per_m + np.cumsum(lowest)) / count)
        pressed = np.maximum(depth - height, 0.0)
        return np.asarray(pressed @ corners / pressed.sum())

    def slope(self, tilt: Array, load_n: float, way_rad: Array) -> Array:
        """(2, 2) m/rad, how the centre moves with the tilt about each axis, on the way from -`way_rad` (2,) to it."""
        ends = [[self.centre(tilt + sign * step, load_n) for sign in (1.0, -1.0)] for step in np.diag(way_rad)]
        return np.column_stack([(high - low) / (2 * way) for (high, low), way in zip(ends, way_rad, strict=True)])


class StandingSoles:
    """Of two soles with cells, and a robot that knows its weight and how its soles are tilted."""

    def __init__(self, foam: SoleFoam, tilts: FootTilts, weight_n: float) -> None:
        self._foam, self._tilts, self._weight_n = foam, tilts, weight_n
        self._shares = np.array([0.5, 0.5])
        self._unfelt_s = np.inf

    def loads(self, felt: Array, unsure: Array, doubt: Array, joints: Array, period_s: float) -> Array:
        """(2, 3) newton and newton metres, as `SolePressure.load`, about each sole's middle.

        Args:
            felt: (2, 3) newton and newton metres, as `SolePressure.load`, that the cells of each sole tell.
            unsure: (2, 2) σ of where they say that each sole presses, over half its length and half its width.
            doubt: (2,) how much of its load each sole's cells may miss, one beside the other.
            joints: (n,) rad, positions as measured; those of the base count for nothing.
            period_s: since the call before.
        """
        self._tilts.update(joints, period_s)
        anything = felt[:, 0].sum() > _FELT * self._weight_n
        self._unfelt_s = 0.0 if anything else self._unfelt_s + period_s
        tilts = self._tilts.tilts(self._foam.lag_s)
        if tilts is None or self._unfelt_s > _UNFELT_S:
            return felt
        found = felt.copy()
        found[:, 0] += self._missed(felt[:, 0], doubt)
        for foot, load in enumerate(found[:, 0]):
            found[foot, 1:] = load * self._centre(foot, tilts[foot], max(load, 1.0), felt[foot], unsure[foot])
        self._shares = np.maximum(found[:, 0] / found[:, 0].sum(), _LEAST_SHARE)
        return found

    def _missed(self, load_n: Array, doubt: Array) -> Array:
        """(2,) N by which the cells of each sole miss its load, of what both lack of the weight or feel beyond it: more
        of that where a sole bears more and its cells may be more wrong."""
        missed = (doubt + 1e-6) * self._shares
        lack = (self._weight_n - load_n.sum()) * missed / missed.sum()
        return np.asarray(np.maximum(lack, -_MOST_TOO_MUCH * load_n))

    def _centre(self, foot: int, tilt: Array, load_n: float, felt: Array, unsure: Array) -> Array:
        """(2,) m: of what its cells and its tilt tell, each by how sure it is; the tilt is learnt from the cells."""
        half, off = np.array(self._foam.half_m), np.sqrt(self._tilts.unsure[foot])
        stands = self._foam.centre(tilt, load_n)
        if felt[0] < _FELT * self._weight_n:
            return stands
        told = np.clip(felt[1:] / felt[0], -half, half)
        by_cells = half * unsure * (1 + _MISSED * abs(load_n - felt[0]) / load_n)
        slope = self._foam.slope(tilt, load_n, np.hypot(off, _TILT_RAD))
        by_foam = np.sqrt(slope**2 @ np.full(2, _TILT_RAD**2))
        by_tilt = np.sqrt(slope**2 @ off**2 + by_foam**2 + _LEAST_M**2)
        self._tilts.learn(foot, told - stands, slope, _ALIKE * np.hypot(by_cells, by_foam))
        # What cells feel is not on the other side of the sole: a tilt that says so is learnt wrong.
        by_tilt = np.hypot(by_tilt, np.maximum(np.abs(told - stands) - 3 * by_cells, 0.0))
        share = by_tilt**2 / (by_cells**2 + by_tilt**2)
        return np.asarray(share * told + (1 - share) * stands)

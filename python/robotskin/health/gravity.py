# SPDX-License-Identifier: Apache-2.0
"""Accelerometers against the motion of their links: offset, scale, looseness and exchanged cells.

Every explanation of what a cell felt in the last windows has a cost (`accelerometer.py`). One is named if it is much
better than "healthy" and than every other, and if nothing is left over that it does not explain. What a healthy cell
showed before is kept, so that a change tells more than a value.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robotskin.health import accelerometer as model
from robotskin.health.evidence import Evidence
from robotskin.health.healthy import ACCELERATIONS
from robotskin.health.kinds import CHANNELS, Finding, Kind
from robotskin.skin import STANDARD_GRAVITY_MPS2

HORIZONS = (15, 40)
"""Windows that are looked at: the short one is quick, the long one sees more postures."""
KEPT_WEIGHT, KEPT_WINDOWS = 0.3, 200.0
"""Of a window in what is remembered of a cell, and how many of them count."""
BETTER = 30.0
CLEARLY = 15.0
FITS = 2.0
"""Cost a window at most: more is left over while a fault begins within the horizon."""
SHARED_AFTER = 25
MAY_SHARE = ({Kind.offset, Kind.loose}, {Kind.offset, Kind.mis_scaled})
NEAR_G = 0.13
UNTURNED_G = 0.1
"""Gravity that moves less in a cell's frame leaves offset, scale and turn alike."""
LEAST_TURN_RAD, LEAST_SCALE, LEAST_OFFSET_G, LEAST_CHANGE_G = 0.044, 0.10, 0.085, 0.06


@dataclass
class _Tried:
    kind: Kind
    axes: tuple[int, ...]
    cost: NDArray
    size: NDArray
    large: NDArray


class GravityJudge:
    """Remembers what each of N healthy accelerometers showed."""

    def __init__(self, evidence: Evidence) -> None:
        cells = evidence.cells
        self._evidence = evidence
        self._kept_square = np.zeros((cells, 12, 12))
        self._kept_side = np.zeros((cells, 12))
        self._doubtful = np.zeros(cells, int)
        self._windows: list[tuple[NDArray, NDArray, NDArray]] = []
        self._sums = {
            horizon: (np.zeros((cells, 12, 12)), np.zeros((cells, 12)), np.zeros(cells)) for horizon in HORIZONS
        }
        """Of each horizon, the normal equations of its windows."""

    def judged(self, others_ill: NDArray[np.bool_]) -> Iterator[Finding]:
        """After every window. `others_ill` (N): cells that another judge names, whose accelerations say nothing."""
        expected, felt, weight = self._newest(others_ill)
        self._windows.append((expected, felt, weight))
        self._sum_up()
        found: dict[int, Finding] = {}
        suspect = np.zeros(self._evidence.cells, bool)
        if len(self._windows) >= HORIZONS[0]:
            mean, covariance = self._known()
            for horizon in HORIZONS:
                if len(self._windows) < horizon:
                    break
                for finding in self._look(horizon, mean, covariance, suspect):
                    found.setdefault(finding.cell, finding)
        self._doubtful = np.where(suspect, self._doubtful + 1, 0)
        yield from found.values()

    # ---- What is known ----

    def _newest(self, others_ill: NDArray[np.bool_]) -> tuple[NDArray, NDArray, NDArray]:
        """(N, 3) expected and felt, g, and (N) weight of the newest window; what a link's cells have in common is
        the motion, not they."""
        now, evidence = self._evidence.now, self._evidence
        felt = now["mean"][:, ACCELERATIONS].astype(float) / STANDARD_GRAVITY_MPS2
        expected = now["expected"].astype(float) / STANDARD_GRAVITY_MPS2
        known = (now["samples"] >= 3) & np.isfinite(expected).all(axis=1) & ~others_ill
        # What is cut off at the end of the range has another mean.
        known &= (now["at_end"][:, ACCELERATIONS] == 0).all(axis=1)
        expected = np.where(known[:, None], expected, 0.0)
        turned = np.einsum("nij,nj->ni", evidence.link_from_cell, felt - expected)
        good = known & (self._doubtful == 0)
        for link in range(evidence.links):
            on = good & (evidence.link == link)
            if on.sum() >= 6:
                common = np.median(turned[on], axis=0)
                here = evidence.link == link
                expected[here] += np.einsum("nji,j->ni", evidence.link_from_cell[here], common)
        return expected, felt, known.astype(float)

    def _sum_up(self) -> None:
        """Adds the newest window to the sums, takes off what has left a horizon, and keeps what has left them all."""
        count = len(self._windows)
        newest = _normal(self._windows[-1])
        for horizon in HORIZONS:
            left = _normal(self._windows[-horizon - 1]) if count > horizon else None
            for part, total in enumerate(self._sums[horizon]):
                total += newest[part]
                if left is not None:
                    total -= left[part]
            if left is not None and horizon == HORIZONS[-1]:
                self._keep(self._windows.pop(0)[2], left)

    def _keep(self, weight: NDArray, window: tuple[NDArray, NDArray, NDArray]) -> None:
        taken = KEPT_WEIGHT * (self._doubtful == 0)
        fade = np.where(taken * weight > 0, 1 - 1 / KEPT_WINDOWS, 1.0)
        self._kept_square = self._kept_square * fade[:, None, None] + taken[:, None, None] * window[0]
        self._kept_side = self._kept_side * fade[:, None] + taken[:, None] * window[1]

    def _known(self) -> tuple[NDArray, NDArray]:
        """(N, 12) and (N, 12, 12): the numbers of each cell, as they were before."""
        after = np.linalg.inv(self._kept_square + np.diag(model.PRIOR**-2.0))
        mean = (after @ self._kept_side[..., None])[..., 0]
        return mean, after + np.diag(model.SETTLED**2)

    # ---- Explanations ----

    def _look(self, horizon: int, mean: NDArray, covariance: NDArray, suspect: NDArray[np.bool_]) -> Iterator[Finding]:
        windows = self._windows[-horizon:]
        square, side, total = self._sums[horizon]
        healthy, _, _ = model.cost(square, side, total, mean, covariance)
        weight = np.stack([one[2] for one in windows])
        enough = weight.sum(axis=0) >= 0.7 * len(windows)
        cells = np.flatnonzero(enough & (healthy > BETTER))
        if len(cells) == 0:
            return
        suspect[cells] = True
        expected, felt = (np.stack([one[part] for one in windows]) for part in (0, 1))
        data = (square[cells], side[cells], total[cells])
        tried = self._tried(data, mean[cells], covariance[cells])
        tried.append(self._loose(expected[:, cells], felt[:, cells], weight[:, cells], mean[cells], covariance[cells]))
        partner, swapped = self._swapped(cells, expected, felt, weight, mean[cells], covariance[cells])
        bound = FITS * weight[:, cells].sum(axis=0) + 12
        unturned = _unturned(expected[:, cells], weight[:, cells])
        row_of = {int(cell): row for row, cell in enumerate(cells)}
        for row, cell in enumerate(cells):
            if partner[row] >= 0:
                # Two cells that were exchanged are one explanation, and both of them its evidence.
                pair = [row, row_of[int(partner[row])]]
                if swapped[pair].sum() < min(bound[pair].sum(), healthy[cells[pair]].sum() - 2 * BETTER):
                    yield Finding(int(cell), Kind.swapped, partner=int(partner[row]))
                    continue
            finding = self._named(
                int(cell), row, tried, float(healthy[cell]), float(bound[row]), unturned=bool(unturned[row])
            )
            if finding is not None:
                yield finding

    def _tried(self, data: tuple[NDArray, NDArray, NDArray], mean: NDArray, covariance: NDArray) -> list[_Tried]:
        out = []
        for axis in range(3):
            index = model.OFFSET.start + axis
            found, numbers, deviation = model.cost(*data, mean, model.relaxed(covariance, [index]))
            size, change = numbers[:, index], numbers[:, index] - mean[:, index]
            large = (np.abs(size) > LEAST_OFFSET_G + deviation[:, index]) | (np.abs(change) > LEAST_CHANGE_G)
            out.append(_Tried(Kind.offset, (axis,), found, size, large))
            found, numbers, _ = model.cost(*data, mean, model.relaxed(covariance, [axis]))
            out.append(
                _Tried(Kind.mis_scaled, (axis,), found, numbers[:, axis], np.abs(numbers[:, axis]) > LEAST_SCALE)
            )
        found, numbers, _ = model.cost(*data, mean, model.common_scale(covariance))
        size = numbers[:, model.SCALE].mean(axis=1)
        out.append(_Tried(Kind.mis_scaled, (0, 1, 2), found, size, np.abs(size) > LEAST_SCALE))
        return out

    def _loose(self, expected: NDArray, felt: NDArray, weight: NDArray, mean: NDArray, covariance: NDArray) -> _Tried:
        """The turn is taken out first, as it may be large; what is left of it is small."""
        turned, angle = expected, np.zeros(expected.shape[1])
        for _ in range(2):
            square, side, total = model.normal(turned, felt, weight)
            _, numbers, _ = model.cost(square, side, total, mean, model.relaxed(covariance, model.TURN))
            plain = felt - (model.design(turned) @ _without_turn(numbers)[None, :, :, None])[..., 0]
            rotation = model.best_turn(expected, plain, weight)
            turned = np.einsum("mij,kmj->kmi", rotation, expected)
            trace = np.clip((np.trace(rotation, axis1=1, axis2=2) - 1) / 2, -1, 1)
            angle = np.arccos(trace)
        square, side, total = model.normal(turned, felt, weight)
        found, numbers, _ = model.cost(square, side, total, mean, model.relaxed(covariance, model.TURN))
        small = np.linalg.norm(numbers[:, model.TURN] - mean[:, model.TURN], axis=1)
        size = np.maximum(angle, small)
        # Three numbers are free, an offset has one.
        return _Tried(Kind.loose, (0, 1, 2), found + 3.0, size, size > LEAST_TURN_RAD)

    def _swapped(
        self, cells: NDArray, expected: NDArray, felt: NDArray, weight: NDArray, mean: NDArray, covariance: NDArray
    ) -> tuple[NDArray, NDArray]:
        """(M) the doubtful cell in whose place each fits, -1: none, and at which cost; both must fit."""
        partner, best = np.full(len(cells), -1), np.full(len(cells), np.inf)
        away = expected[:, None, cells] - felt[:, cells, None]  # (K, M felt, M place, 3)
        off = np.sqrt((away**2).sum(axis=-1).mean(axis=0))
        np.fill_diagonal(off, np.inf)
        near = (off < NEAR_G) & (off.T < NEAR_G)
        one, other = np.nonzero(near)
        if len(one) == 0:
            return partner, best
        square, side, total = model.normal(expected[:, cells[other]], felt[:, cells[one]], weight[:, cells[one]])
        found, _, _ = model.cost(square, side, total, mean[one], covariance[one])
        costs = np.full(off.shape, np.inf)
        costs[one, other] = found
        both = costs + costs.T
        for row in range(len(cells)):
            column = int(np.argmin(both[row]))
            if np.isfinite(both[row, column]) and int(np.argmin(both[column])) == row:
                partner[row], best[row] = int(cells[column]), costs[row, column]
        return partner, best

    def _named(
        self, cell: int, row: int, tried: list[_Tried], healthy: float, bound: float, *, unturned: bool
    ) -> Finding | None:
        """The explanation that is clearly the best one; two that nothing tells apart for long, if they may share."""
        ordered = sorted((one for one in tried if one.large[row]), key=lambda one: float(one.cost[row]))
        if not ordered or healthy - ordered[0].cost[row] < BETTER or ordered[0].cost[row] > bound:
            return None
        best = ordered[0]
        rivals = sorted(
            (one for one in tried if one.kind is not best.kind and one.cost[row] < best.cost[row] + CLEARLY),
            key=lambda one: float(one.cost[row]),
        )
        other = None
        if rivals:
            other = rivals[0].kind
            # Where gravity never turns nothing will ever tell three apart: the two that fit best are told.
            two = unturned or len({one.kind for one in rivals}) == 1
            if not two or {best.kind, other} not in MAY_SHARE or self._doubtful[cell] < SHARED_AFTER:
                return None
        unit = {Kind.offset: "g", Kind.loose: "degrees", Kind.mis_scaled: ""}[best.kind]
        size = float(np.degrees(best.size[row]) if best.kind is Kind.loose else best.size[row])
        if best.kind is Kind.mis_scaled:
            size, unit = 1 + size, "times"
        channels = () if best.kind is Kind.loose else tuple(CHANNELS[ACCELERATIONS.start + axis] for axis in best.axes)
        return Finding(cell, best.kind, channels, size=size, unit=unit, or_kind=other)


def _unturned(expected: NDArray, weight: NDArray) -> NDArray[np.bool_]:
    """(M) whether what should be felt, (K, M, 3) in g, has hardly turned in the windows of a weight (K, M)."""
    known = weight[..., None] > 0
    mean = np.where(known, expected, 0.0).sum(axis=0) / np.maximum(known.sum(axis=0), 1)
    away = np.linalg.norm(np.where(known, expected - mean, 0.0), axis=2)
    return np.asarray(away.max(axis=0) < UNTURNED_G)


def _normal(window: tuple[NDArray, NDArray, NDArray]) -> tuple[NDArray, NDArray, NDArray]:
    expected, felt, weight = window
    return model.normal(expected[None], felt[None], weight[None])


def _without_turn(numbers: NDArray) -> NDArray:
    out = numbers.copy()
    out[..., model.TURN] = 0.0
    return out

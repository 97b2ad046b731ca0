# SPDX-License-Identifier: Apache-2.0
"""What cells felt, reduced to known signals: thousands of readings become thirteen numbers an axis, without loss."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

SIGNALS = 13
"""f (3), Ω row by row (9), and one; see `motion_fit.py`."""


@dataclass(frozen=True, eq=False)
class Reduced:
    """n cells' readings, reduced to signals of one link.

    factor: (n, 13, 13) and target: (n, 13, 3): the squared residual of coefficients θ (13, 3) is
        |factor @ θ - target|² + floor.
    floor: (n,) what no coefficients explain; readings: (n,) numbers of scalar readings.
    others: (n, M, 13, 13): readings that followed M other signals with coefficients θ add others @ θ to the target.
    beyond: (n, M, 13, 3), beyond_gram: (M, 13, M, 13): what the readings say of the other signals beyond what these
        signals can follow: coefficients x of the others (times θ) lower `floor` by 2 x·beyond - x·beyond_gram·x.
    """

    factor: Array
    target: Array
    floor: Array
    readings: NDArray[np.int64]
    others: Array
    beyond: Array
    beyond_gram: Array

    def of(self, cells: NDArray[np.bool_]) -> Reduced:
        """Those of some cells, a mask (n,)."""
        return Reduced(
            self.factor[cells],
            self.target[cells],
            self.floor[cells],
            self.readings[cells],
            self.others[cells],
            self.beyond[cells],
            self.beyond_gram,
        )

    @classmethod
    def nothing(cls, count: int) -> Reduced:
        """What `count` cells say that were never read."""
        empty, others = np.zeros(count), np.zeros((count, 0, SIGNALS, SIGNALS))
        factor, target = np.zeros((count, SIGNALS, SIGNALS)), np.zeros((count, SIGNALS, 3))
        gram = np.zeros((0, SIGNALS, 0, SIGNALS))
        return cls(factor, target, empty, empty.astype(np.int64), others, others[..., :3], gram)


class Readings:
    """n cells' readings (n, K, 3), NaN where missing, with row weights (K,): square roots of weights."""

    def __init__(self, readings: Array, weight: Array) -> None:
        self.weight = weight
        # Axis by axis, so that all readings of one axis lie side by side: (n, 3, K).
        felt = np.ascontiguousarray(np.swapaxes(readings, 1, 2))
        valid = np.asarray(np.isfinite(felt[:, 0] + felt[:, 1] + felt[:, 2]), dtype=bool)
        self.count = 3 * valid.sum(axis=1)
        # Missing ones become zero readings of zero signals.
        if not valid.all():
            felt = np.where(valid[:, None], felt, 0.0)
        self.felt = felt * weight
        squares = np.einsum("nak,nak->na", self.felt, self.felt)
        self.squares = squares.sum(axis=1)
        total = valid @ weight**2
        mean = (self.felt @ weight) / np.maximum(total, 1e-12)[:, None]
        self.spread = np.sqrt(np.maximum(squares / np.maximum(total, 1e-12)[:, None] - mean**2, 0.0))
        """(n, 3) m/s² standard deviation of each axis' readings."""
        # Cells that missed the same instants share their signals; most missed none.
        keys: dict[bytes, list[int]] = {}
        for cell, row in enumerate(valid):
            keys.setdefault(row.tobytes(), []).append(cell)
        self.groups = [(valid[cells[0]], np.array(cells)) for cells in keys.values()]

    def reduced(self, signals: Array, others: NDArray[np.floating] | None = None) -> Reduced:
        """The readings reduced to signals (K, 13); others: (M, K, 13) that may be in the readings, too."""
        cells = len(self.felt)
        if others is None:
            others = np.zeros((0, *signals.shape))
        mixed = np.zeros((cells, len(others), SIGNALS, SIGNALS))
        beyond = np.zeros((cells, len(others), SIGNALS, 3))
        gram, largest = np.zeros((len(others), SIGNALS, len(others), SIGNALS)), 0
        factor, target = np.zeros((cells, SIGNALS, SIGNALS)), np.zeros((cells, SIGNALS, 3))
        for valid, group in self.groups:
            known = signals * (self.weight * valid)[:, None]
            size, vector = np.linalg.eigh(known.T @ known)
            root = np.sqrt(np.where(size > 1e-13 * size[-1], size, 0.0))
            inverse = np.where(root > 0, 1 / np.where(root > 0, root, 1.0), 0.0)
            factor[group] = root[:, None] * vector.T
            felt = self.felt if len(group) == cells else self.felt[group]
            projected = (felt.reshape(-1, felt.shape[2]) @ known).reshape(len(group), 3, SIGNALS)
            target[group] = (inverse[:, None] * vector.T) @ np.swapaxes(projected, 1, 2)
            if not len(others):
                continue
            # (K, 13 M): the other signals as these cells' readings weigh them.
            flat = np.swapaxes(others, 0, 1).reshape(len(known), -1) * (self.weight * valid)[:, None]
            inside = (inverse[:, None] * vector.T) @ (known.T @ flat)
            mixed[group] = np.swapaxes(inside.reshape(SIGNALS, len(others), SIGNALS), 0, 1)
            flat -= (known @ (vector * inverse)) @ inside
            said = (felt.reshape(-1, felt.shape[2]) @ flat).reshape(len(group), 3, len(others), SIGNALS)
            beyond[group] = np.moveaxis(said, 1, 3)
            # The few readings that some cells miss change what the others could say by next to nothing.
            if len(group) > largest:
                gram, largest = (flat.T @ flat).reshape(gram.shape), len(group)
        floor = np.maximum(self.squares - (target**2).sum(axis=(1, 2)), 0.0)
        return Reduced(factor, target, floor, self.count, mixed, beyond, gram)

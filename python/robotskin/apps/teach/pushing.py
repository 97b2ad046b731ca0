# SPDX-License-Identifier: Apache-2.0
"""Which two cells to push, and how hard, so that the pushes add up to a wanted force: fingers only push."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls

Array = NDArray[np.float64]

APART_M = 0.10
"""Two hands need so much room."""
EFFORT = 0.03
"""Cells whose pushes work against each other cost this much more, for each part of wasted force."""


MOVE = 0.05
"""What it costs that a hand changes its cell: meanwhile it does not push."""


@dataclass(frozen=True)
class Grip:
    """Two cells, indices, and the force on each, newton."""

    cells: tuple[int, int]
    forces_n: tuple[float, float]


def shares_of(inward: Array, wanted_n: Array) -> tuple[tuple[float, float], float]:
    """Forces, newton and >= 0, along two inward normals (2, 3) that come nearest to a force (3).

    Returns them and the length of what is left, as a part of the wanted force.
    """
    forces, left = nnls(inward.T, wanted_n)
    return (float(forces[0]), float(forces[1])), float(left / np.linalg.norm(wanted_n))


def best_grip(
    cells: NDArray[np.int64], inward: Array, at_m: Array, wanted_n: Array, present: tuple[int, ...] = ()
) -> Grip:
    """The two of N cells, with inward normals (N, 3) at places (N, 3) metres, that push best along a force (3).

    Where little is lost by it, one hand stays where it is; `present` are the cells under the hands now.
    """
    along = inward @ (wanted_n / np.linalg.norm(wanted_n))
    between = inward @ inward.T
    width = np.maximum(1.0 - between**2, 1e-9)
    first = (along[:, None] - between * along[None, :]) / width
    second = first.T
    both = (first > 0) & (second > 0) & (width > 1e-3)
    alone = np.maximum(along, 0.0)[:, None]
    told = np.where(both, first * along[:, None] + second * along[None, :], alone**2)
    cost = np.sqrt(np.maximum(1.0 - told, 0.0)) + EFFORT * np.where(both, first + second, alone)
    moves = ~np.isin(cells, present)
    cost = cost + MOVE * (moves[:, None] * 1.0 + moves[None, :])
    cost[np.linalg.norm(at_m[:, None] - at_m[None, :], axis=2) < APART_M] = np.inf
    rows = [int(row) for row in np.unravel_index(int(np.argmin(cost)), cost.shape)]
    if len(present) == 2 and (cells[rows[0]] == present[1] or cells[rows[1]] == present[0]):
        rows.reverse()
    forces, _ = shares_of(inward[rows], wanted_n)
    return Grip((int(cells[rows[0]]), int(cells[rows[1]])), forces)

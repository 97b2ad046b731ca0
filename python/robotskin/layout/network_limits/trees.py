# SPDX-License-Identifier: Apache-2.0
"""The best forest of one-parent trees: each cell sends through one neighbour, each tree hangs on one cable.

The fullest cable of a forest carries at least ceil(N / K) cells, and at least what it carries where frames may be split
(`least_fullest`). Where a forest reaches that bound it is proven best; most do. To reach it is NP-hard in general
(confluent flow, Chen et al., J. ACM 2007), so a forest is sought by simulated annealing (`annealing`), and small parts
are then decided exactly by an integer program (`exact`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import maximum_flow

from robotskin.layout.cell_network import CellNetwork
from robotskin.layout.network_limits.annealing import STEPS_PER_CELL, annealed_forest

Integers = NDArray[np.int64]

EXACT_UP_TO = 160
"""Cells times cables of a part that the integer program decides."""


@dataclass(frozen=True, eq=False)
class Forest:
    """Trees of one connected part.

    cells: (n,) indices; cables: (k,) indices into the network's cables; owner: (n,) index into `cables` of each cell.
    bound: no forest has a fullest cable with fewer cells.
    """

    cells: Integers
    cables: Integers
    owner: Integers
    bound: int

    @property
    def loads(self) -> Integers:
        """(k,) cells of each cable."""
        return np.bincount(self.owner, minlength=len(self.cables)).astype(np.int64)

    @property
    def fullest(self) -> int:
        """Cells of the fullest cable."""
        return int(self.loads.max())

    @property
    def proven(self) -> bool:
        """Whether no forest is better."""
        return self.fullest == self.bound


def best_forest(network: CellNetwork, part: int, seed: int = 0, steps_per_cell: int = STEPS_PER_CELL) -> Forest | None:
    """The best forest found for a connected part; None without a cable. The same seed gives the same forest."""
    cells = np.flatnonzero(network.part == part)
    near, roots = roots_and_neighbours(network, part)
    if not roots:
        return None
    cable_at = {int(root): number for number, root in reversed(list(enumerate(network.roots)))}
    cables = [cable_at[int(cells[root])] for root in roots]
    bound = least_fullest(near, roots)
    found = annealed_forest(near, roots, bound, seed=seed, steps_per_cell=steps_per_cell)
    forest = Forest(cells, np.array(cables), np.array(found), bound)
    if not forest.proven and len(cells) * len(roots) <= EXACT_UP_TO:
        from robotskin.layout.network_limits.exact import exact_forest

        owner, bound = exact_forest(near, roots, forest.bound, forest.fullest)
        forest = Forest(cells, np.array(cables), forest.owner if owner is None else np.array(owner), bound)
    return forest


def roots_and_neighbours(network: CellNetwork, part: int) -> tuple[list[list[int]], list[int]]:
    """The neighbours of each cell of a connected part and its cells with a cable, as indices into the part's cells."""
    cells = np.flatnonzero(network.part == part)
    place = np.full(len(network), -1)
    place[cells] = np.arange(len(cells))
    near: list[list[int]] = [[] for _ in cells]
    links = network.links[place[network.links[:, 0]] >= 0]
    for first, second in zip(place[links[:, 0]].tolist(), place[links[:, 2]].tolist(), strict=True):
        near[first].append(second)
        near[second].append(first)
    # A second cable at one cell cannot relieve the first: the cell has one parent.
    roots = dict.fromkeys(int(place[root]) for root in network.roots if place[root] >= 0)
    return near, list(roots)


def least_fullest(near: list[list[int]], roots: list[int]) -> int:
    """A bound that no forest's fullest cable undercuts: the load where frames may be split among neighbours.

    As in a forest, a cell with a cable sends by its cable and passes nothing on to others: a cable whose cell is walled
    in by other cables' cells serves few, however well all is shared.
    """
    count, sink = len(near), len(near) + 1
    arcs = [(cell, other) for cell in range(count) if cell not in set(roots) for other in near[cell]]
    arcs += [(root, sink) for root in roots] + [(count, cell) for cell in range(count)]
    rows, columns = np.array(arcs, dtype=np.int64).T
    load = -(-count // len(roots))
    while True:
        sizes = np.where(rows == count, 1, load).astype(np.int32)
        graph = csr_matrix((sizes, (rows, columns)), shape=(count + 2, count + 2))
        heard = int(maximum_flow(graph, count, sink).flow_value)
        if heard == count:
            return load
        load += 1

"""The best forest of one-parent trees: each cell sends through one neighbour, each tree hangs on one cable.

The fullest cable of a forest carries at least ceil(N / K) cells, and at least what it carries where frames may be split
(`least_fullest`). Where a forest reaches that bound it is proven best; most do. To reach it is NP-hard in general
(confluent flow, Chen et al., J. ACM 2007), so a forest is sought by simulated annealing over moves of a cell with all
that hangs on it alone, and small parts are then decided exactly by an integer program (`exact`).
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from random import Random

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import maximum_flow

from robotskin.layout.cell_network import CellNetwork

Integers = NDArray[np.int64]

EXACT_UP_TO = 160
"""Cells times cables of a part that the integer program decides."""
STEPS_PER_CELL = 150


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
    search = Search(near, roots, Random(seed))
    search.anneal(bound, steps_per_cell * len(cells))
    forest = Forest(cells, np.array(cables), np.array(search.best), bound)
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


def nearest_roots(near: list[list[int]], roots: list[int]) -> list[int]:
    """The tree of each cell, where each goes to a nearest root."""
    owner = [-1] * len(near)
    for tree, root in enumerate(roots):
        owner[root] = tree
    queue = deque(roots)
    while queue:
        cell = queue.popleft()
        for other in near[cell]:
            if owner[other] < 0:
                owner[other] = owner[cell]
                queue.append(other)
    return owner


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


class Search:
    """Annealing over forests. near: neighbours of each cell; roots: the cell of each cable."""

    def __init__(self, near: list[list[int]], roots: list[int], random: Random) -> None:
        self.near, self.roots, self.random = near, roots, random
        self.owner = nearest_roots(near, roots)
        self.best = list(self.owner)
        self.loads = [self.owner.count(tree) for tree in range(len(roots))]
        self.weight = [0] * len(near)
        for tree in range(len(roots)):
            self.weigh(tree)

    def weigh(self, tree: int) -> None:
        """The weight of each cell of a tree's set: itself and all that the root reaches through it only.

        Articulation points by depth-first search (Hopcroft and Tarjan 1973).
        """
        owner, near, weight = self.owner, self.near, self.weight
        root = self.roots[tree]
        order = {root: 0}
        low = {root: 0}
        size = {root: 1}
        weight[root] = 1
        stack = [(root, -1, iter(near[root]))]
        while stack:
            cell, above, rest = stack[-1]
            for other in rest:
                if owner[other] != tree or other == above:
                    continue
                if other in order:
                    low[cell] = min(low[cell], order[other])
                else:
                    order[other] = low[other] = len(order)
                    size[other] = weight[other] = 1
                    stack.append((other, cell, iter(near[other])))
                    break
            else:
                stack.pop()
                if stack:
                    low[above] = min(low[above], low[cell])
                    size[above] += size[cell]
                    if low[cell] >= order[above]:
                        weight[above] += size[cell]

    def hanging(self, cell: int) -> list[int]:
        """A cell and all that its root reaches through it only."""
        tree = self.owner[cell]
        root = self.roots[tree]
        reached = {root, cell}
        queue = deque([root])
        while queue:
            for other in self.near[queue.popleft()]:
                if self.owner[other] == tree and other not in reached:
                    reached.add(other)
                    queue.append(other)
        reached.discard(cell)
        found = [cell]
        seen = {cell}
        for member in found:
            for other in self.near[member]:
                if self.owner[other] == tree and other not in reached and other not in seen:
                    seen.add(other)
                    found.append(other)
        return found

    def border(self) -> list[tuple[int, int]]:
        """Cells that touch another tree's, with that tree."""
        owner, roots = self.owner, set(self.roots)
        return [
            (cell, owner[other])
            for cell in range(len(owner))
            if cell not in roots
            for other in self.near[cell]
            if owner[other] != owner[cell]
        ]

    def anneal(self, bound: int, steps: int) -> None:
        """Move cells between trees until the fullest has `bound`, or the steps are used up; `best` keeps the best."""
        fullest = max(self.loads)
        warm = max(1.0, 0.1 * sum(self.loads) / len(self.loads)) ** 2
        border = self.border()
        for step in range(steps):
            if fullest <= bound or not border:
                return
            # Two coolings: the second starts from where the first ended.
            temperature = warm * 0.001 ** (2 * step / steps % 1.0)
            cell, there = border[int(self.random.random() * len(border))]
            here, weight = self.owner[cell], self.weight[cell]
            change = 2 * weight * (self.loads[there] - self.loads[here] + weight)
            if change > 0 and self.random.random() >= math.exp(-change / temperature):
                continue
            for member in self.hanging(cell):
                self.owner[member] = there
            self.loads[here] -= weight
            self.loads[there] += weight
            self.weigh(here)
            self.weigh(there)
            border = self.border()
            if max(self.loads) < fullest:
                fullest = max(self.loads)
                self.best = list(self.owner)
